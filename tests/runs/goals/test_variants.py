"""Lines of a goal evaluation's table, and in which order pieces are learned from."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.runs.goals.variants import (
    ALL_PIECES,
    CLASSIFIERS,
    MONITORS,
    NO_MONITORS,
    NO_ROLES,
    NUMBER,
    choose_variants,
    piece_order,
    possible_variants,
)


def scenario(faults: tuple[str, ...] = ("none", "slip"), scale: float = 0.5) -> Any:
    return SimpleNamespace(faults=faults, config=SimpleNamespace(noise=SimpleNamespace(scale=scale)))


def names(*methods: str, pieces: int = 9) -> list[tuple[str, str]]:
    return [(v.method, v.case) for v in choose_variants(methods, scenario(), pieces)]


def test_every_method_has_its_cases() -> None:
    faults = ("none", "slip", "noise")
    assert names() == [
        *((MONITORS, f) for f in faults), *((NO_MONITORS, f) for f in faults), (NO_ROLES, "none"),
        (NUMBER, "6 pieces"), (NUMBER, "8 pieces"), (NUMBER, "9 pieces"),
    ]  # fmt: skip
    assert names(NUMBER, pieces=8) == [(NUMBER, "6 pieces"), (NUMBER, "8 pieces")]
    assert names(NUMBER, pieces=4) == [(NUMBER, "4 pieces")]
    assert names(f"{MONITORS}/slip", MONITORS, f"{MONITORS}/slip") == [
        (MONITORS, "slip"), (MONITORS, "none"), (MONITORS, "noise"),
    ]  # fmt: skip
    assert names(CLASSIFIERS) == []


def test_a_line_says_what_its_trials_share() -> None:
    found = {(v.method, v.case): v for v in choose_variants((), scenario(), 9)}
    assert found[(MONITORS, "slip")].settings == ("fault.kind=slip",)
    assert found[(MONITORS, "noise")].settings == ("noise.scale=1.5",)
    assert {m: v.monitors for (m, _), v in found.items()} == {
        MONITORS: True, NO_MONITORS: False, NO_ROLES: True, NUMBER: True,
    }  # fmt: skip
    assert found[(NO_ROLES, "none")].learning == NO_ROLES
    assert [found[(NUMBER, f"{n} pieces")].learning for n in (6, 8, 9)] == [6, 8, ALL_PIECES]


@pytest.mark.parametrize(
    ("method", "message"),
    [
        ("oracle", "there is no method 'oracle'; there are monitors, no_monitors"),
        ("monitors/knock", "method monitors has no case 'knock'; it has none, slip, noise$"),
        ("classifiers/none", "method classifiers has no case 'none'; it has none$"),
    ],
)
def test_what_there_is_not_is_refused_with_what_there_is(method: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        choose_variants([method], scenario(), 9)


def test_cases_that_a_physics_refuses_are_left_out_with_the_reason() -> None:
    asked: list[tuple[tuple[str, ...], str, int]] = []

    class World:
        faults = ("none", "slip")
        config = SimpleNamespace(noise=SimpleNamespace(scale=1.0))

        def __init__(self, settings: tuple[str, ...] = (), physics: str = "contact", seed: int = 7) -> None:
            self.physics, self.seed = physics, seed
            asked.append((settings, physics, seed))
            if "fault.kind=slip" in settings:
                raise InputError("nothing slips there")

    world: Any = World(seed=3)
    every, skipped = choose_variants([MONITORS], world, 9), dict[str, str]()
    assert [v.case for v in possible_variants(every, world, ("a=1",), skipped)] == ["none", "noise"]
    assert skipped == {"slip": "nothing slips there"}
    assert asked[1:] == [(("a=1", *v.settings), "contact", 3) for v in every]


def piece(name: str, **flags: int) -> Demonstration:
    columns = {f"hand->{k}": [0.0, float(v)] for k, v in flags.items()}
    return Demonstration(pd.DataFrame({"time": [0.0, 0.3], **columns}), {}, name)


def test_pieces_that_show_something_new_come_first_and_none_is_lost() -> None:
    pieces = [piece(f"a{k}", cup=1, lid=0) for k in range(6)] + [piece("b", cup=1, lid=1), piece("c", cup=0, lid=0)]
    orders = [[p.name for p in piece_order(pieces, seed)] for seed in range(8)]
    for names_ in orders:
        assert sorted(names_) == sorted(p.name for p in pieces)
        assert "b" in names_[:2], "the lid is shown by one alone"
        assert names_[0] != "c"
    assert len({tuple(o) for o in orders}) > 4
    assert orders[3] == [p.name for p in piece_order(pieces, 3)]
    assert np.mean([o[0] == "b" for o in orders]) < 1.0

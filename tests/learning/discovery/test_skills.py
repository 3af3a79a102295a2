"""What recordings show between switches: from where, and what it changes."""

import bath_log
import numpy as np
import pytest

from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.skills import (
    REST,
    ShownSkill,
    Stretch,
    _effects,
    _values,
    shown_skills,
    stretches,
)
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import StateSpace, Variable

PIECES = bath_log.pieces()


@pytest.fixture(scope="module")
def skills() -> dict[str, ShownSkill]:
    return {s.name: s for s in shown_skills(PIECES, bath_log.GRAPH)}


def test_stretches_cover_a_piece() -> None:
    found = stretches(PIECES[0], bath_log.GRAPH)
    assert [s.first for s in found] == [0, *(s.last + 1 for s in found[:-1])]
    assert found[-1].last == len(PIECES[0]) - 1
    assert found[0].before is None
    assert all(b.before == a.active != b.active for a, b in zip(found[:-1], found[1:], strict=True))


def test_each_set_of_active_interactions_is_a_skill(skills: dict[str, ShownSkill]) -> None:
    assert {"hand->lever", "hand->lever + lever->tank", REST} <= set(skills)
    assert sum(x.last - x.first + 1 for s in skills.values() for x in s.shown) == sum(map(len, PIECES))


def test_precondition_and_effect_are_those_of_the_world(skills: dict[str, ShownSkill]) -> None:
    fills, carries = skills["lever->tank"], skills["hand->lever"]
    assert [e for e in fills.effect if e.startswith("tank.level by +")]
    assert "hand->lever active" in fills.precondition  # who opened it let go
    assert "lever.x either way" in carries.effect
    assert any(" <= hand.y <= " in text for text in carries.precondition)
    assert not any("tank" in text for s in (carries, skills[REST]) for text in s.effect)
    assert str(fills).startswith(f"lever->tank: {len(fills.shown)} times; from hand->lever active and ")
    assert fills.report()["shown"][0]["piece"] == fills.shown[0].piece


def box_at(*places: float) -> dict[str, dict[str, np.ndarray]]:
    spaces = {"hand": np.zeros((len(places), 1)), "box": np.array(places)[:, None]}
    return {n: {"p": v} for n, v in spaces.items()}


SMALL = InteractionGraph({n: StateSpace(n, (Variable("x"),)) for n in ("hand", "box")}, ["hand->box"])
SILENT = {n: np.full(1, 1e-3) for n in ("hand", "box")}


def shown(*stretches: tuple[int, int]) -> list[Stretch]:
    return [Stretch("p", a, b, ("hand->box",), None) for a, b in stretches]


def test_values_before_a_skill_are_told_where_it_was_shown_often_enough() -> None:
    """One start or two may be narrow by chance."""
    states, times = box_at(*np.arange(60.0)), LEARNING.few
    for count, told in ((times - 1, []), (times, ["30 <= box.x <= 30"]), (times + 3, ["30 <= box.x <= 30"])):
        assert _values(SMALL, states, SILENT, ("hand->box",), shown(*[(30, 31)] * count)) == told


def test_an_effect_is_counted_from_the_row_before_a_stretch() -> None:
    """What changed before that was of another skill."""
    states = box_at(0.0, 0.0, 5.0, 6.0, 6.0)
    assert _effects(SMALL, states, SILENT, shown((3, 4))) == ["box.x by +1"]
    assert _effects(SMALL, states, SILENT, shown((1, 2))) == ["box.x by +5"]

"""The pot: what leaves a vessel over it gets in while the lid is open, and is spilled else."""

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects import Jug, Lid, Pot, PotSettings, check_object
from ichain_drake.state import StateSpace
from ichain_drake.timing import FRAME

SPACES = {"jug": Jug.state_space, "lid": Lid.state_space}
OFF = {"jug": False, "lid": False}


def pot() -> Pot:
    return Pot("pot", SPACES, pot=PotSettings(middle=(0.0, 0.16), over=(0.05, 0.09), height=0.17, ajar=0.09))


def parents(y: float, z: float, open_: float, flow: float = 0.0) -> dict[str, np.ndarray]:
    jug, lid = np.zeros(len(Jug.state_space)), np.zeros(len(Lid.state_space))
    jug[:2], jug[Jug.state_space.index("flow")], lid[0] = (y, z), flow, open_
    return {"jug": jug, "lid": lid}


def test_it_keeps_the_contract_of_a_world_object() -> None:
    check_object(pot())


@pytest.mark.parametrize(
    ("y", "z", "open_", "on"),
    [
        (0.0, 0.33, 0.10, (True, True)),
        (0.049, 0.25, 0.10, (True, True)),
        (0.051, 0.33, 0.10, (False, True)),
        (0.0, 0.43, 0.10, (False, True)),
        (0.0, 0.33, 0.08, (False, False)),
        (0.3, 0.12, 0.0, (False, False)),
    ],
)
def test_it_is_poured_into_from_over_it_while_it_is_open(
    y: float, z: float, open_: float, on: tuple[bool, bool]
) -> None:
    found = pot().decide_active(pot().state_at(0.0), parents(y, z, open_), OFF, None)
    assert (found["jug"], found["lid"]) == on


def test_what_is_on_ends_a_little_later() -> None:
    state, on = pot().state_at(0.0), {"jug": True, "lid": True}
    assert pot().decide_active(state, parents(0.053, 0.33, 0.087), on, None) == on
    assert pot().decide_active(state, parents(0.053, 0.33, 0.087), OFF, None) == OFF


@pytest.mark.parametrize(("taken", "start"), [(1.0, 0.2), (0.0, 0.2), (1.0, 0.999)])
def test_no_drop_is_lost(taken: float, start: float) -> None:
    made, state, amounts = pot(), pot().state_at(start), [start]
    active = {"jug": np.float64(taken), "lid": np.float64(taken)}
    for _ in range(12):
        state = made.step(state, parents(0.0, 0.33, 0.1, 0.01), active, np.zeros(0), FRAME)  # type: ignore[arg-type]
        amounts.append(state[0])
    assert state[0] + state[2] == pytest.approx(start + 0.12, abs=1e-12)
    assert state[0] == pytest.approx(min(start + 0.12 * taken, 1.0))
    assert state[1] == pytest.approx(amounts[-1] - amounts[-11], abs=1e-12)


def test_an_amount_that_can_not_be_is_refused() -> None:
    with pytest.raises(InputError, match="pot: amount 2.0 given; it is between 0 and 1"):
        pot().state_at(2.0)


@pytest.mark.parametrize("given", [{"jug": SPACES["jug"]}, {"lid": SPACES["lid"]}, {**SPACES, "hand": Lid.state_space}])
def test_parents_that_do_not_fit_are_refused(given: dict[str, StateSpace]) -> None:
    with pytest.raises(InputError, match="the parents of a pot are a vessel that is poured from and its lid lid"):
        Pot("pot", given)

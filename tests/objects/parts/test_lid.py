"""The lid: it goes with the hand that holds it, and shuts by itself."""

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.objects import Lid, LidMount, check_object
from ichain_drake.robot import HandSpec
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import FRAME

HAND = HandSpec(["y", "z", "roll", "grip"], {"x": 0.6}).space
MOUNT = LidMount((0.1, 0.2), 0.16, (0.02, 0.025), 0.8)


def lid() -> Lid:
    return Lid("lid", {"a": HAND, "b": HAND}, mount=MOUNT)


def step(state: np.ndarray, y: float, *, held: bool) -> np.ndarray:
    parents = {"a": np.array([9.0, 9.0, 0.0, 0.0]), "b": np.array([y, 0.2, 0.0, float(held)])}
    active = {"a": np.float64(0), "b": np.float64(held)}
    return lid().step(state, parents, active, np.zeros(0), FRAME)  # type: ignore[arg-type]


def test_it_keeps_the_contract_of_a_world_object() -> None:
    check_object(lid())


def test_it_begins_shut() -> None:
    assert lid().default_state().tolist() == [0.1, 0.2, 0.0, 0.0]


@pytest.mark.parametrize(("hand", "there"), [(0.18, 0.18), (0.05, 0.1), (0.4, 0.26)])
def test_it_goes_with_the_hand_within_its_travel(hand: float, there: float) -> None:
    state = step(lid().default_state(), hand, held=True)
    np.testing.assert_allclose(state, [there, 0.2, 0.0, 1.0])


def test_a_spring_shuts_it() -> None:
    state = np.array([0.2, 0.2, 0.0, 1.0])
    first = step(state, 0.2, held=False)
    assert first[0] == pytest.approx(0.2 - 0.8 / 30.0)
    assert first[3] == 0.0
    for _ in range(5):
        first = step(first, 0.2, held=False)
    assert first[0] == 0.1


@pytest.mark.parametrize("mount", [LidMount(travel=0.0), LidMount(spring=-1.0), LidMount(reach=(0.02, 0.0))])
def test_a_mount_that_can_not_be_is_refused(mount: LidMount) -> None:
    with pytest.raises(InputError, match="travel, reach and spring of a lid are above 0"):
        Lid("lid", {"a": HAND}, mount=mount)


def test_a_parent_that_is_no_hand_is_refused() -> None:
    with pytest.raises(InputError, match="lid: its parent a has no position along y"):
        Lid("lid", {"a": StateSpace("tank", (Variable("water"),))})

"""What is carried is moved as it was shown to be, not by whatever a model happened to find in noise."""

from types import SimpleNamespace

import numpy as np
import pytest
from chest import GRAPH, SHUT, Chest, learned, readings

from ichain_drake.control.planning.slope import led
from ichain_drake.graph import Interaction

LID = Interaction("hand", "lid")
Y, Z = 1, 2


def test_what_the_hand_did_while_it_held_the_lid_is_known() -> None:
    step = learned()[0].edges[LID].active_step
    assert step[Y] == pytest.approx(0.04, abs=0.01)
    assert (step[[0, Z, 3]] == 0).all()


def test_noise_of_a_hand_that_stands_is_no_input_of_an_effect() -> None:
    effects = learned()[0].report()["interactions"]["hand->lid"]["effects"]
    assert {v: e["columns"] for v, e in effects.items()} == {"y": ["motion with parent along child's y"]}


@pytest.mark.parametrize(("shown", "aside"), [(0.0, 0.001), (0.04, 0.05)])
def test_a_motion_that_was_not_shown_is_hardly_made(shown: float, aside: float) -> None:
    """By this model the lid would go as far along y if the hand went up."""

    def effect(edge: Interaction, states: dict[str, np.ndarray], parent_next: np.ndarray) -> np.ndarray:
        moved = parent_next - states["hand"]
        return np.stack([0 * moved[..., 0], moved[..., Y] + moved[..., Z], 0 * moved[..., 0]], axis=-1)

    step = np.array([0.0, 0.04, shown, 0.0])
    odd = SimpleNamespace(
        graph=GRAPH,
        step_limit={"hand": np.full(4, 0.04)},
        effect=effect,
        edges={LID: SimpleNamespace(active_step=step)},
    )
    now = readings(Chest(1, inside=True))
    now["hand"] = np.array([*SHUT, 1.0])
    command, whole = led(odd, LID, now, np.array([np.nan, 0.1, np.nan]), np.full(3, 0.001))  # type: ignore[arg-type]
    assert whole
    assert command[Y] - SHUT[Y] == pytest.approx(0.1 - aside, abs=0.001)
    assert command[Z] - SHUT[Z] == pytest.approx(aside, abs=0.001)

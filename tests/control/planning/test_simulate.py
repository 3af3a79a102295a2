"""What is predicted of a drive that ends before the robot is all the way to where it drives."""

import numpy as np
import pytest
from toy_models import ToyModel

from ichain_drake.control.planning.drive_option import DriveOption
from ichain_drake.control.planning.drive_run import Run
from ichain_drake.control.planning.plan import Condition
from ichain_drake.control.planning.simulate import simulate
from ichain_drake.control.settings import PLANNING
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import StateSpace, Variable

OPEN = Interaction("robot", "tank")


def lever(flow: float = 0.1, brim: float = np.inf) -> ToyModel:
    """A tank that fills the faster the further a robot has moved a lever; it goes 0.1 a tick."""
    level = Variable("level", lower=0.0, upper=brim)
    spaces = {"robot": StateSpace("robot", (Variable("x", "m"),)), "tank": StateSpace("tank", (level,))}
    shown = [{"robot": [x], "tank": [level]} for x, level in ((0.0, 0.0), (1.0, 3.0))]
    return ToyModel(
        InteractionGraph(spaces, ["robot->tank"]),
        {"robot->tank": lambda s: s["robot"][:, 0] + 0.5},
        {"robot->tank": lambda p, q, c: flow * q},
        {"tank": ["hold"]},
        {"robot->tank": shown},
        {},
    )


def test_a_drive_that_stops_on_the_way_is_undone_from_there() -> None:
    model, empty = lever(), np.zeros(1)
    drive = DriveOption(
        (OPEN,), 0, 1, 0.1, None, {"robot": np.ones(1), "tank": empty}, {"robot": np.zeros(1), "tank": empty}
    )
    start = {"robot": np.array([-1.0]), "tank": empty}
    early, full = simulate(model, [(start, drive)], start["robot"], [Condition("tank", "level", 0.145, np.inf)])[0]  # type: ignore[arg-type]
    # 0.01 + 0.02 + ... + 0.05 on the way there, and 0.04 + ... + 0.01 on the way back.
    assert early.end == pytest.approx(0.15)
    assert early.states["tank"][0] == pytest.approx(0.25)
    assert full.states["tank"][0] == pytest.approx(full.end + 0.45), "from all the way it is as far back"


@pytest.mark.parametrize("flow", [0.05, 0.02, 0.005])
def test_however_many_ticks_are_taken_at_once_a_slow_drive_takes_as_long_as_tick_by_tick(flow: float) -> None:
    model, empty = lever(flow), np.zeros(1)
    here = {"robot": np.ones(1), "tank": empty}
    drive = DriveOption((OPEN,), 0, 1, flow, None, here, here)
    start = {"robot": np.array([-1.0]), "tank": empty}
    wanted = Condition("tank", "level", 1.499, np.inf)
    met = simulate(model, [(start, drive)], start["robot"], [wanted])[0][0]  # type: ignore[arg-type]
    assert met.met == 0
    assert met.end == pytest.approx(flow * met.ticks)
    assert 1.499 <= met.end <= 1.499 + 12 * flow


def test_a_drive_ends_where_its_variable_does_not_change_any_more() -> None:
    model, empty = lever(brim=1.0), np.zeros(1)
    here = {"robot": np.ones(1), "tank": empty}
    drive = DriveOption((OPEN,), 0, 1, 0.1, None, here, here)
    start = {"robot": np.array([-1.0]), "tank": empty}
    (full,) = simulate(model, [(start, drive)], start["robot"], [])[0]  # type: ignore[arg-type]
    assert full.end == pytest.approx(1.0)
    assert 10 <= full.ticks <= 10 + 3 * PLANNING.window


@pytest.mark.parametrize(
    ("level", "change", "ticks"),
    [
        (0.5, 0.0199, 3),
        (0.5, -0.0199, 3),
        (0.5, 0.0001, 2 * PLANNING.probe),
        (0.98, 0.005, 4),
        (0.012, -0.005, 2),
        (0.5, 0.3, 1),
    ],
)
def test_ticks_are_taken_at_once_while_changes_are_small_and_no_bound_is_near(level, change, ticks) -> None:
    """A fiftieth of the range that was shown, 3 here."""
    model, here = lever(brim=1.0), {"robot": np.ones(1), "tank": np.zeros(1)}
    run = Run(model, [(here, DriveOption((OPEN,), 0, 1, 0.1, None, here, here))], np.zeros(1))  # type: ignore[arg-type]
    before = {"robot": np.ones((1, 1)), "tank": np.array([[level]])}
    assert run.leap(before, before | {"tank": np.array([[level + change]])}).tolist() == [ticks]

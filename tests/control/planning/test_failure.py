"""What is said where there is no plan: proved or not found, which interaction was missing, and by how much."""

from toy_models import TAP_START, tap

from ichain_drake.control.planning.carries import find_carries
from ichain_drake.control.planning.failure import Nearest
from ichain_drake.control.planning.format import format_plan
from ichain_drake.control.planning.goals import parse_goal
from ichain_drake.control.planning.options import find_drives
from ichain_drake.control.planning.plan import Plan
from ichain_drake.control.planning.planner import GraphPlanner
from ichain_drake.graph import Interaction

PRESS, FALL = Interaction("robot", "tap"), Interaction("tank", "cup")


def nearest() -> Nearest:
    model = tap()
    drive = next(d for d in find_drives(model, find_carries(model)) if d.chain[-1] == FALL)
    found = Nearest(model, parse_goal(["cup.water >= 0.5"], model, TAP_START), TAP_START)
    found.note_blocked(drive, PRESS, -0.1)
    found.note_blocked(drive, FALL, -0.9)
    found.note_blocked(drive, FALL, -0.4)
    return found


def test_the_interaction_that_a_drive_lacked_is_named_with_its_nearest_decision_value() -> None:
    failure = nearest().failure(7, exhausted=True)
    assert failure.edge == FALL  # it came further along the chain than the one before
    assert failure.reason == (
        "cup.water >= 0.5 can't be met: 0.05 is the nearest that was predicted, as it is, in all 7 states that can be "
        "reached; tank->cup never became active on the way, its nearest decision value is -0.4"
    )


def test_a_search_that_stopped_proves_nothing() -> None:
    assert "was not found to be met: 0.05 is the nearest" in nearest().failure(7, exhausted=False).reason
    assert "within 7 states" in nearest().failure(7, exhausted=False).reason


def test_chains_and_counts_are_written_as_they_are_said() -> None:
    model = tap()
    found = GraphPlanner(model).plan(TAP_START, parse_goal(["tank.water <= 0.5"], model, TAP_START))
    assert isinstance(found, Plan)
    text = format_plan(found, model.graph)
    assert text.startswith("1 step, ")
    assert "robot->tap->tank: " in text

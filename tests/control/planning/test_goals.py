"""Goal expressions and what is refused without a search."""

import math

import numpy as np
import pytest
from toy_models import LAMP_START, TAP_START, lamp, tap

from ichain_drake.control.execution.monitoring import unmet
from ichain_drake.control.planning.goals import gap, impossible, inside, parse_goal, stay, words
from ichain_drake.control.planning.plan import Condition, Goal, NoPlan
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction


def one(text: str) -> Condition:
    goal = parse_goal([text], tap(), TAP_START)
    assert len(goal.conditions) == 1
    return goal.conditions[0]


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("cup.water >= 0.6", 0.6, math.inf),
        ("cup.water<=0.6", -math.inf, 0.6),
        ("0.2 <= cup.water <= 0.6", 0.2, 0.6),
        ("cup.x == 0.5", 0.4798, 0.5202),
        ("cup.x = start", 0.1798, 0.2202),
        ("-0.02 <= cup.x", -0.02, math.inf),
        ("cup.x<-.5", -math.inf, math.nextafter(-0.5, -1)),
        ("0.6 > cup.water", -math.inf, math.nextafter(0.6, 0)),
        ("cup.water > 0.6", math.nextafter(0.6, 1), math.inf),
        ("0.6 >= cup.water > 0.2", math.nextafter(0.2, 1), 0.6),
        ("0.2 <= cup.water and cup.water <= 0.4", 0.2, 0.4),
        ("keep cup.x within 0.1", 0.1, 0.3),
    ],
)
def test_every_form_becomes_a_range(text: str, low: float, high: float) -> None:
    found = one(text)
    assert (found.lower, found.upper) == pytest.approx((low, high))
    if "<" in text or ">" in text:
        assert (found.lower, found.upper) == (low, high)  # more than a value is not that value


def test_several_expressions_on_one_variable_narrow_its_range() -> None:
    goal = parse_goal(["cup.water >= 0.2", "cup.water <= 0.4", "not robot->cup"], tap())
    assert goal.conditions == (Condition("cup", "water", 0.2, 0.4),)
    assert goal.inactive == (Interaction("robot", "cup"),)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mug.water >= 1", "there is no object 'mug'; objects are robot, tap, tank, cup"),
        ("cup.heat >= 1", "cup has no variable 'heat'; it has x, water"),
        ("cup.water >> 1", "at character 12, '>', a number or 'start' is expected"),
        ("cup >= 1", "at character 1, 'cup', object.variable, a number or an interaction is expected"),
        ("cup.water >=", "at the end, a number or 'start' is expected"),
        ("cup.water 1", "at character 11, '1', a sign such as >= is expected"),
        ("cup.water >= much", "at character 14, 'much', a number or 'start' is expected"),
        ("cup.water >= 1 or cup.x >= 1", "at character 16, 'or', 'and' or the end is expected"),
        ("cup.water >= 0.1 and", "at the end, object.variable, a number or an interaction is expected"),
        ("0.1 <= cup.water >= 0.3", "at character 18, '>=', <= or <, as before, is expected"),
        ("0.1 == cup.water == 0.3", "at character 18, '==', the end is expected"),
        ("0.1 <= 0.3", "at character 8, '0.3', object.variable is expected"),
        ("not cup.x", "an interaction as parent->child is expected"),
        ("keep cup.x 0.1", "'within' is expected"),
        ("robot->mug", "there is no interaction robot->mug"),
        ("", "no goal is given"),
        ("cup.water >= nan", "'nan' is not a finite number"),
        ("0.7 <= cup.water <= 0.3", "no value of cup.water is in all the ranges"),
        ("not cup->tap", "there is no interaction cup->tap"),
    ],
)
def test_a_wrong_expression_is_one_line_that_says_what_to_write(text: str, message: str) -> None:
    with pytest.raises(InputError, match="goal '|no goal") as error:
        parse_goal([text], tap(), TAP_START)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_an_interaction_that_is_to_be_active() -> None:
    goal = parse_goal(["tank->cup and cup.water >= 0.2", "not robot->cup"], tap())
    assert (goal.active, goal.inactive) == ((Interaction("tank", "cup"),), (Interaction("robot", "cup"),))
    with pytest.raises(InputError, match="robot->cup can't be both active and not"):
        parse_goal(["robot->cup", "not robot->cup"], tap())
    off = unmet(tap(), parse_goal(["tank->cup"], tap()), TAP_START)
    assert off == "tank->cup is not active"


def test_no_expression_and_a_start_that_is_not_known_are_refused() -> None:
    with pytest.raises(InputError, match="no goal is given"):
        parse_goal([], tap())
    with pytest.raises(InputError, match="needs the states at the start"):
        parse_goal(["cup.x == start"], tap())


@pytest.mark.parametrize(
    ("text", "edge", "reason"),
    [
        ("cup.water >= 1.1", "tank->cup", "cup.water goes from 0 to 1 and is bounded there"),
        ("cup.x >= 4", "robot->cup", "was never beyond that in a demonstration"),
        ("cup.water >= 0.9", "tank->cup", "there is only 0.85 in all of tank, cup"),
        ("tank.change >= 0.5", None, "no interaction was seen to change tank.change"),
        ("robot.x >= 1", None, "robot is the robot"),
    ],
)
def test_what_can_not_be_is_refused_without_a_search(text: str, edge: str | None, reason: str) -> None:
    found = impossible(parse_goal([text], tap()), tap(), TAP_START)
    assert isinstance(found, NoPlan)
    assert (found.edge and found.edge.name) == edge
    assert reason in found.reason


def test_what_holds_already_is_never_refused() -> None:
    assert impossible(parse_goal(["robot.x >= 0.2"], tap()), tap(), TAP_START) is None


def test_stay_gap_and_words() -> None:
    (c,) = stay(LAMP_START, "dimmer", ["x"], lamp(), 0.01)
    assert words(c, lamp().graph) == "0.29 <= dimmer.x <= 0.31 m"
    assert gap(c, np.array([0.2, 0.3, 0.35])) == pytest.approx([0.09, 0.0, 0.04])


def test_a_margin_is_taken_where_there_is_room() -> None:
    model = tap()
    noise = float(model.noise["cup"][1])
    assert noise > 0
    found = inside(Condition("cup", "water", 0.6, math.inf), model, 3.0)
    assert (found.lower, found.upper) == (pytest.approx(0.6 + 3 * noise), math.inf)
    narrow = inside(Condition("cup", "water", 0.6, 0.6 + noise), model, 3.0)
    assert (narrow.lower, narrow.upper) == pytest.approx((0.6 + noise / 4, 0.6 + 3 * noise / 4))
    full = model.graph.objects["cup"].variables[1].upper  # nothing is more than full
    assert inside(Condition("cup", "water", full, math.inf), model, 3.0).lower == full


def test_what_readings_can_not_tell_is_not_reached() -> None:
    model = tap()
    noise = float(model.noise["cup"][1])
    goal = Goal((Condition("cup", "water", 0.6, math.inf),), ())
    states = {n: v.copy() for n, v in TAP_START.items()}
    for value, said in ((0.5, "does not hold: it is 0.5"), (0.6 + 0.5 * noise, "holds by less than readings can tell")):
        states["cup"][1] = value
        assert said in unmet(model, goal, states)
    states["cup"][1] = 0.6 + 1.5 * noise
    assert unmet(model, goal, states) == ""


def test_what_is_taken_goes_as_far_as_the_robot_takes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A little beyond what was shown, or as far as the robot's bounds bring it."""
    for low, high in ((-3.0, 4.0), (0.4, 4.0), (-3.0, 0.6), (0.4, 0.6)):
        ends = (np.array([low, np.nan]), np.array([high, np.nan]))
        monkeypatch.setattr("ichain_drake.control.planning.goals.Frames.reach", lambda self, obj, ends=ends: ends)
        for text, possible in (
            (f"cup.x <= {low + 0.1}", low < 0),
            (f"cup.x >= {high - 0.1}", high > 1),
            (f"cup.x <= {low - 0.1}", low > 0),
            (f"cup.x >= {high + 0.1}", high < 1),
            ("cup.x <= -0.2", low < 0),
            ("cup.x >= 1.2", high > 1),
        ):
            met = impossible(parse_goal([text], tap()), tap(), {**TAP_START, "cup": np.array([0.5, 0.05])})
            assert (met is None) == (possible or text in (f"cup.x <= {low + 0.1}", f"cup.x >= {high - 0.1}")), text


@pytest.mark.parametrize(("cup", "tank", "nearest"), [(0.9, 0.0, 0.85), (0.9, 0.2, 0.65), (0.9, 0.95, 0.0)])
def test_of_an_amount_that_is_short_what_others_leave_is_as_near_as_it_comes(
    cup: float, tank: float, nearest: float
) -> None:
    goal = parse_goal([f"cup.water >= {cup}", f"tank.water >= {tank}"], tap(), TAP_START)
    found = impossible(goal, tap(), TAP_START)
    assert isinstance(found, NoPlan)
    assert found.closest == pytest.approx(nearest)

"""What an execution compares: each way in which a state is not as wanted or predicted is noticed, and no other."""

import numpy as np
import pytest
from small_job import learned
from toy_models import LAMP_START, lamp

from ichain_drake.control.execution.monitoring import asked, deviation, gone, unmet
from ichain_drake.control.planning.plan import Condition, Goal, PlanStep
from ichain_drake.graph import Interaction

HOLD, THROW = Interaction.parse("robot->dimmer"), Interaction.parse("robot->switch")


def test_an_interaction_that_should_be_over_and_is_not_is_unmet() -> None:
    model, goal = lamp(), Goal((), (HOLD,))
    held = {**LAMP_START, "robot": np.array([0.3, 0.0, 1.0])}
    assert unmet(model, goal, held) == "robot->dimmer is still active"
    let_go = {**held, "robot": np.array([0.3, 0.0, 0.0])}
    assert unmet(model, goal, let_go) == ""


def test_a_range_that_is_missed_or_hardly_met_is_unmet() -> None:
    model = lamp()
    goal = Goal((Condition("dimmer", "x", 0.25, 0.35),))
    assert unmet(model, goal, {**LAMP_START, "dimmer": np.array([0.3])}) == ""
    assert "does not hold: it is 0.2" in unmet(model, goal, {**LAMP_START, "dimmer": np.array([0.2])})
    near = {**LAMP_START, "dimmer": np.array([0.25 + 0.5 * model.noise["dimmer"][0]])}
    assert "holds by less than readings can tell" in unmet(model, goal, near)
    assert unmet(model, goal, near, readings=16) == "", "the mean of more readings tells more"


def off_by(obj: str, variable: str, share: float) -> str:
    """What is said where one variable is off by a share of its demonstrated range."""
    model, _, _ = learned()
    space = model.graph.objects[obj].observable
    states = {n: (model.low[n] + model.high[n]) / 2 for n in model.graph.objects}
    step = PlanStep((model.graph.incoming(obj)[0],), predicted={n: v.copy() for n, v in states.items()})
    i = space.index(variable)
    states[obj] = states[obj].copy()
    states[obj][i] += share * (model.high[obj][i] - model.low[obj][i])
    return deviation(model, step, states)


@pytest.mark.parametrize(("variable", "unseen", "seen"), [("x", 0.03, 0.07), ("water", 0.08, 0.16)])
def test_a_deviation_is_noticed_from_some_share_of_the_range(variable: str, unseen: float, seen: float) -> None:
    assert off_by("box", variable, 0.0) == ""
    assert off_by("box", variable, unseen) == ""
    for sign in (1, -1):
        assert off_by("box", variable, sign * seen).startswith(f"box.{variable} is "), sign


def test_what_is_neither_predicted_nor_kept_by_itself_does_not_deviate() -> None:
    model, _, _ = learned()
    states = {n: (model.low[n] + model.high[n]) / 2 for n in model.graph.objects}
    step = PlanStep((Interaction.parse("hand->box"),), predicted={"tap": states["tap"]})
    assert deviation(model, step, {**states, "box": states["box"] + 1.0}) == ""
    assert off_by("valve", "level", 0.5) == "", "it springs back by itself"


def test_an_object_is_gone_far_from_where_it_ever_was() -> None:
    model, _, _ = learned()
    states = {n: (model.low[n] + model.high[n]) / 2 for n in model.graph.objects}
    space, low, high = model.graph.objects["box"].observable, model.low["box"], model.high["box"]
    z = space.index("z")
    for away, lost in ((4.0, False), (6.0, True)):
        box = states["box"].copy()
        box[z] = low[z] - away * (high[z] - low[z])
        assert bool(gone(model, {**states, "box": box})) == lost


def test_what_holds_by_less_than_readings_can_tell_is_asked_for_by_more() -> None:
    model = lamp()
    goal = Goal((Condition("dimmer", "x", 0.25, 0.35), Condition("switch", "x", 0.5, 1.0)))
    near = {**LAMP_START, "dimmer": np.array([0.25 + 0.5 * model.noise["dimmer"][0]])}
    assert unmet(model, goal, near)
    wanted = asked(model, goal, near)
    assert wanted.conditions[0].lower > near["dimmer"][0], "a planner has something to do"
    assert wanted.conditions[1] == goal.conditions[1], "what is still to be done is asked for as it is"
    loud = asked(model.with_noise({n: 3.0 * v for n, v in model.noise.items()}), goal, near)  # type: ignore[arg-type]
    assert loud.conditions[0].lower > wanted.conditions[0].lower
    assert unmet(model, asked(model, goal, near), {**near, "dimmer": np.array([0.3])}) != unmet(model, goal, near)

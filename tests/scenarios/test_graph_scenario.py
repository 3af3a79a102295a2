"""What all scenarios with a goal share: worlds, recording, faults, and what they refuse."""

import dataclasses

import numpy as np
import pytest

import ichain_drake as ic
from ichain_drake.scenarios.faults import FAULTS, Faults, GoalFaultConfig, draw_faults


class Ball(ic.WorldObject):
    """Rolls along with the hand's x, a little unevenly."""

    state_space = ic.StateSpace("ball", (ic.Variable("x", "m", 0.0, 1.0),))
    process_noise_size = 1

    def step(self, state, parents, active, noise, dt):
        return np.clip(state + 0.01 * dt + 0.01 * noise, 0.0, 1.0)


class Rolling(ic.GraphScenario[float]):
    """One ball; the start is where it is."""

    name = "rolling"
    rows = np.tile([0.45, 0.0, 0.25, 0.0, 0.0, 0.0, 0.0], (3, 1))

    def make_graph(self):
        return ic.InteractionGraph({"hand": self.config.robot.hand.space, "ball": Ball.state_space}, ["hand->ball"])

    def draw_start(self, rng):
        return rng.uniform(0.2, 0.4)

    def make_objects(self, start, make):
        self.faults_seen = make.faults
        return {"ball": make(Ball, "ball", lambda ball: ball.default_state() + start, dropouts=make.faults.dropouts)}

    def script(self, rng):
        yield ic.ScriptedPiece("still", 0.3, self.rows)


class Faulty(Rolling):
    """The same with faults."""

    faults = FAULTS


def test_a_run_differs_from_the_next_and_repeats() -> None:
    scenario = Rolling(physics="ideal", seed=2)
    starts = [scenario.start(run) for run in (0, 1, 0)]
    assert starts[0] == starts[2] != starts[1]
    worlds = [scenario.make_world(run) for run in (0, 0, 1)]
    balls = [w.system("ball") for w in worlds]
    assert [b.settings.seed for b in balls] == [2000, 2000, 2001]
    assert balls[0].settings.object_id == 1, "its place in the graph"
    first = [b.get_state(b.CreateDefaultContext())[0] for b in balls]
    assert first == pytest.approx([starts[0], starts[0], starts[1]])


def test_pieces_are_recorded_unless_all_is_known() -> None:
    scenario = Rolling(physics="ideal")
    lines: list[str] = []
    (piece,) = scenario.record_demonstrations(lines.append)
    assert lines == ["still: 3 ticks (ideal)"]
    assert (piece.name, len(piece)) == ("still", 4)
    assert piece.table["ball.x"][0] == pytest.approx(0.3)
    assert list(scenario.record_demonstrations(known=["hand->ball"])) == []


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (
            np.zeros((3, 2)),
            r"piece still: its commands have shape \(3, 2\); give an array .* 7 columns: x, y, z, yaw",
        ),
        (np.zeros((0, 7)), r"piece still: its commands have shape \(0, 7\)"),
        (np.array([[0.0] * 7, [np.nan] * 7]), "piece still: a command is not finite in row 1"),
    ],
)
def test_commands_that_are_not_the_hand_s_are_refused(rows: np.ndarray, message: str) -> None:
    scenario = Rolling(physics="ideal")
    scenario.rows = rows
    with pytest.raises(ic.InputError, match=message):
        next(iter(scenario.record_demonstrations()))


def test_faults_are_drawn_from_what_the_configuration_says() -> None:
    config = GoalFaultConfig(time=[1.0, 2.0], knock=0.1, dropout=0.5, stiffness=3.0)
    drawn = {kind: draw_faults(dataclasses.replace(config, kind=kind), np.random.default_rng(0)) for kind in FAULTS}
    assert drawn["none"] == Faults()
    (time,) = drawn["slip"].slips
    assert 1.0 <= time <= 2.0
    ((when, x, y),) = drawn["knock"].knocks
    assert when == time
    assert np.hypot(x, y) == pytest.approx(0.1)
    assert drawn["dropout"].dropouts == ((time, time + 0.5),)
    assert drawn["stiff"] == Faults(stiffness=3.0)
    ((when, x, y),) = drawn["moved"].knocks
    assert (when, drawn["moved"].away) == (time, 0.2)
    assert (np.hypot(x, y), x < 0.0) == (pytest.approx(0.1), True)


def test_a_fault_meets_runs_but_no_demonstration() -> None:
    scenario = Faulty(["fault.kind=dropout"], physics="ideal")
    world = scenario.make_world(0)
    assert len(world.system("ball").settings.dropouts) == 1
    next(iter(scenario.record_demonstrations()))
    assert scenario.faults_seen == Faults()


def test_demonstrations_share_no_noise_with_any_run_of_an_evaluation() -> None:
    """Whatever keys a world's noise differs: what was learned from has told nothing about what is asked."""
    scenario = Rolling(physics="ideal", seed=2)
    shown: list[int] = []
    build = scenario.build_world

    def noted(start, run, *args, **kwargs):
        world = build(start, run, *args, **kwargs)
        shown.append(world.system("ball").settings.seed)
        return world

    scenario.build_world = noted  # type: ignore[method-assign]
    list(scenario.record_demonstrations())
    demonstrated = set(shown)
    assert len(demonstrated) == 1
    shown.clear()
    for run in (0, 1, 499):
        scenario.make_world(run)
    assert shown == [2000, 2001, 2499]
    assert not demonstrated & {2000 + run for run in range(500)}


def test_what_can_not_be_is_refused() -> None:
    with pytest.raises(ic.InputError, match="rolling has no fault 'slip'; it has none"):
        Rolling(["fault.kind=slip"], physics="ideal")
    for kind in ("slip", "knock", "moved"):
        with pytest.raises(ic.InputError, match=f"fault.kind {kind}: in contact the plant alone moves things"):
            Faulty([f"fault.kind={kind}"], physics="contact")
    with pytest.raises(ic.InputError, match="rolling: no object has a body that a hand could touch"):
        Rolling(physics="contact").make_world(0)


def test_only_a_point_is_drawn_as_a_hand() -> None:
    assert list(Rolling(physics="ideal").drawings()) == ["hand"]
    assert Rolling(physics="ideal").drawn_plant() is None
    assert Rolling(physics="arm").drawings() == {}
    assert Rolling(physics="arm").drawn_plant() is not None


def test_a_run_asks_for_the_scenario_s_own_goal_unless_told() -> None:
    scenario = Rolling(["goal=[ball.x >= 0.5]"], physics="ideal")
    assert ic.GraphRun(scenario).expressions == ("ball.x >= 0.5",)
    assert ic.GraphRun(scenario, ["ball.x <= 0.1"]).expressions == ("ball.x <= 0.1",)

"""What a playback says of a run towards a goal, frame by frame, from a log that is made up."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from lamp import LampScenario
from rrd import read_rrd

import ichain_drake as ic
from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.plan import Condition, Goal
from ichain_drake.graph import Interaction
from ichain_drake.runs.goals import output
from ichain_drake.runs.goals.output import (
    _contents,
    _spans,
    flags_of,
    make_graph_recording,
    write_graph_pictures,
    write_graph_recording,
)
from ichain_drake.runs.output import write_rerun_of
from ichain_drake.simulation.episode import EpisodeLog

FRAMES = 4
GOAL = Goal(
    (Condition("lamp", "light", 0.5, np.inf), Condition("dimmer", "x", 0.4, 0.5)), (Interaction("hand", "dimmer"),)
)


@pytest.fixture
def run() -> ic.GraphRun:
    """The dimmer is right from the second frame on, let go of in the third, the lamp bright in the last."""
    ran = ic.GraphRun(LampScenario(), ["lamp.light >= 0.5"])
    graph = LampScenario.graph
    states = {n: np.zeros((FRAMES, len(space))) for n, space in graph.objects.items()}
    states["lamp"][:, 0] = [0.0, 0.2, 0.4, 0.6]
    states["dimmer"][:, 0] = [0.35, 0.45, 0.45, 0.45]
    readings = {n: np.full((FRAMES, len(space.observable)), 9.0) for n, space in graph.objects.items()}
    active = {n: np.zeros((FRAMES, len(graph.parents(n)))) for n in graph.objects if graph.parents(n)}
    active["dimmer"][:2, 0] = 1.0
    active["lamp"][:, graph.parents("lamp").index("switch")] = [0, 1, 1, 0]
    ran.log = EpisodeLog(np.arange(FRAMES) / 30, states, readings, active, np.zeros((FRAMES, 3)))
    ran.goal = GOAL
    edge = graph.interactions.index(Interaction("hand", "switch"))
    ran.doing = {
        "mode": np.array([Mode.LOOK, Mode.ACTIVATE, Mode.DEACTIVATE, Mode.REACHED], dtype=float),
        "edge": np.array([-1, 0, edge, -1], dtype=float),
        "skill": np.array([0, 1, 2, 0], dtype=float),
        "plan_step": np.array([-1, 0, 1, -1], dtype=float),
    }
    return ran


def shown(run: ic.GraphRun) -> dict[str, list]:
    (episode,) = make_graph_recording(run).episodes
    return {name: list(readout.values) for name, readout in episode.readouts.items()}


def test_what_the_controller_does_is_said_in_words(run: ic.GraphRun) -> None:
    says = shown(run)
    assert says["interaction"] == ["-", LampScenario.graph.interactions[0].name, "hand->switch", "-"]
    assert says["skill"] == ["-", "activate", "deactivate", "-"]
    assert says["plan step"] == ["-", "1", "2", "-"]
    assert says["controller"][1:] == ["activates", "deactivates", "goal reached"]


def test_conditions_are_counted_in_truth(run: ic.GraphRun) -> None:
    """Readings, which are 9 here, have no say; each of three conditions comes true in a frame of its own."""
    says = shown(run)
    assert says["goal"] == ["0 of 3 met", "1 of 3 met", "2 of 3 met", "3 of 3 met"]
    assert says["error"] == ["lamp.light: 0.500", "lamp.light: 0.300", "lamp.light: 0.100", "none"]


def test_the_error_is_of_the_condition_that_has_most_of_its_way_left(run: ic.GraphRun) -> None:
    run.goal = Goal((GOAL.conditions[1], Condition("lamp", "light", 0.0, np.inf)))
    assert shown(run)["error"] == ["dimmer.x: 0.050 m", "none", "none", "none"]
    run.goal = Goal((Condition("lamp", "light", -np.inf, 0.3), Condition("dimmer", "x", 0.4, 0.5)))
    assert shown(run)["error"] == ["dimmer.x: 0.050 m", "none", "lamp.light: 0.100", "lamp.light: 0.300"]


def test_strips_show_what_the_goal_names_with_its_range(run: ic.GraphRun) -> None:
    (episode,) = make_graph_recording(run).episodes
    assert list(episode.strips) == ["lamp.light \u2265 0.5", "dimmer.x from 0.400 to 0.500"]
    light, place = episode.strips.values()
    np.testing.assert_array_equal(light.values, [0.0, 0.2, 0.4, 0.6])
    np.testing.assert_array_equal(place.values, [0.35, 0.45, 0.45, 0.45])


def test_flags_are_the_truth_of_each_interaction(run: ic.GraphRun) -> None:
    assert run.log is not None
    flags = flags_of(run.log, LampScenario.graph)
    assert {name: list(on.astype(int)) for name, on in flags.items()} == {
        "hand->dimmer": [1, 1, 0, 0], "hand->switch": [0, 0, 0, 0], "dimmer->lamp": [0, 0, 0, 0],
        "switch->lamp": [0, 1, 1, 0],
    }  # fmt: skip


def test_amounts_and_what_is_dissolved_in_them_are_read_out_and_nothing_that_is_hidden() -> None:
    cup = ic.StateSpace(
        "cup",
        (
            ic.Variable("x", "m", role=ic.Role("position", "robot", "x")),
            ic.Variable("water", "l", role=ic.Role("amount")),
            ic.Variable("heat", "degC", role=ic.Role("intensive", of="water")),
            ic.Variable("leak", "l", role=ic.Role("amount"), hidden=True),
        ),
    )
    graph = ic.InteractionGraph({"hand": LampScenario.spaces["hand"], "cup": cup}, ["hand->cup"])
    states = {"hand": np.zeros((2, len(graph.objects["hand"]))), "cup": np.arange(8.0).reshape(2, 4)}
    found = _contents(EpisodeLog(np.arange(2) / 30, states, {}, {}, np.zeros((2, 3))), graph)
    assert {n: (list(r.values), r.unit) for n, r in found.items()} == {
        "cup water": ([1.0, 5.0], "l"), "cup heat": ([2.0, 6.0], "degC"),
    }  # fmt: skip


def test_where_a_flag_holds_is_told_by_start_and_duration() -> None:
    assert _spans([False, True, True, False, True], 0.5) == [(0.5, 1.0), (2.0, 0.5)]
    assert _spans([True], 2.0) == [(0.0, 2.0)]
    assert _spans([False], 2.0) == []


def test_a_run_that_logged_nothing_has_no_recording(tmp_path: Path) -> None:
    ran = ic.GraphRun(LampScenario(), ["lamp.light >= 0.5"])
    with pytest.raises(ic.InputError, match="recording of lamp: it has no episodes; record one first"):
        make_graph_recording(ran)
    assert write_graph_recording(ran, tmp_path / "playback.html") == []
    assert write_graph_pictures(ran, tmp_path) == []
    assert list(tmp_path.iterdir()) == []


def test_a_report_says_how_long_it_ran_and_nothing_of_a_plan_that_is_none(run: ic.GraphRun) -> None:
    report = run.report()
    assert report["sim_seconds"] == pytest.approx((FRAMES - 1) / 30, abs=1e-6)
    assert (report["goal_reached"], report["control_steps"]) == (False, 0)
    metrics = report["metrics"]
    assert (metrics["plan"], metrics["cost"], metrics["probability"], metrics["events"]) == ([], None, 0.0, [])
    run.log = None
    assert run.report()["sim_seconds"] == 0.0


def test_a_run_of_two_frames_has_a_timeline_and_one_of_one_has_none(
    run: ic.GraphRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Path] = []
    monkeypatch.setattr(output, "plot_timeline", lambda file, *args: drawn.append(file))
    log, doing = run.log, run.doing
    assert log is not None
    run.model = SimpleNamespace(  # type: ignore[assignment]
        graph=LampScenario.graph, active=lambda now, before: dict.fromkeys(LampScenario.graph.interactions, False)
    )
    for frames in (1, 2):
        first = {k: {n: v[:frames] for n, v in getattr(log, k).items()} for k in ("states", "measured", "active")}
        run.log = EpisodeLog(log.times[:frames], *first.values(), log.command[:frames])
        run.doing = {k: v[:frames] for k, v in doing.items()}
        assert write_graph_pictures(run, tmp_path) == drawn == [tmp_path / "timeline.png"] * (frames - 1)


def test_a_recording_for_rerun_has_what_was_measured_commanded_and_done(
    run: ic.GraphRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rerun", reason="rerun is missing: pip install 'ichain_drake[rerun]'")
    for name, nothing in (("drawings", {}), ("drawn_plant", None), ("view", None)):  # a lamp that nobody draws
        monkeypatch.setattr(run.scenario, name, lambda nothing=nothing: nothing, raising=False)
    write_rerun_of(run, tmp_path / "run.rrd")
    found = read_rrd(tmp_path / "run.rrd")

    def values(entity: str) -> list[float]:
        times, rows = found[entity, "Scalars:scalars"]
        np.testing.assert_allclose(times, np.arange(FRAMES) / 30, atol=1e-9)
        return [row[0] for row in rows]

    assert values("/true/dimmer/x") == [0.35, 0.45, 0.45, 0.45]
    assert values("/measured/dimmer/x") == [9.0] * FRAMES
    assert values("/command/x") == [0.0] * FRAMES
    assert values("/active/switch->lamp") == [0, 1, 1, 0]
    assert [row[0] for row in found["/log/controller", "TextLog:text"][1]] == shown(run)["controller"]
    assert len(found["/log/plan step", "TextLog:text"][1]) == 4

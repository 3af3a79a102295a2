"""`show`: a run's playback for a notebook."""

from pathlib import Path

import pytest

import ichain_drake as ic


def test_a_path_run_is_shown_and_written(tmp_path: Path) -> None:
    scenario = ic.load_scenario("car_game", ["learning.samples=120"], physics="ideal")
    candidates = scenario.config.learning.candidates()
    pieces = list(scenario.record_demonstrations())
    chain = ic.learn_chain(pieces, scenario.graph, scenario.target, scenario.target_variables, candidates)
    limits = scenario.path_limits()
    controller = ic.make_controller(chain, "inverse", limits)
    path = ic.TimedPath(scenario.reference_paths()["eight"][:40], limits)
    result = ic.follow(scenario, chain, controller, "beginning", path, 0)

    shown = ic.show(ic.PathRun(scenario, results=[result]), height=300)
    assert "car_game: playback" in shown.content
    assert len(repr(shown)) < 100
    frame = shown._repr_html_()
    assert frame.startswith("<iframe")
    assert 'height="300"' in frame
    assert "<script" not in frame, "the page is escaped"
    file = tmp_path / "kept.html"
    shown.write(file)
    assert file.read_text(encoding="utf-8") == shown.content
    with pytest.raises(ic.InputError, match="give a writable folder"):
        shown.write(tmp_path / "nowhere" / "kept.html")


def test_what_was_not_run_is_not_shown() -> None:
    path_run = ic.PathRun(ic.load_scenario("car_game", physics="ideal"))
    goal_run = ic.GraphRun(ic.load_scenario("water_dispenser", physics="ideal"), ("cup.water >= 0.3",))
    for run in (path_run, goal_run):
        with pytest.raises(ic.InputError, match=f"{run.scenario.name}: there is nothing to play yet; run it"):
            ic.show(run)

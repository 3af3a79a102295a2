"""`ichain run --meshcat` in a real browser: it shows, lets adjust, can be stopped; nobody has to look."""

import json
import time

import pytest
from patience import until
from teaching_person import Person, Program

SLIDER = "viewer.gui_controllers[arguments[0]].setValue(arguments[1])"


@pytest.fixture(scope="module")
def stopped(browser, tmp_path_factory):
    """A run in real time, looked at, adjusted, left, looked at again and stopped by its button."""
    folder = tmp_path_factory.mktemp("live")
    chosen = ["--set", "learning.samples=60", "--set", "path.speed=20", "--set", "control.efforts=[0.05]"]
    program = Program(
        folder, "run", "car_game", "--physics", "ideal", "--paths", "eight", "--meshcat", "--realtime",
        *chosen, "--demos", str(_demonstrations(folder)), "-o", str(folder / "out"),
    )  # fmt: skip
    try:
        person = Person(browser, program)
        until(lambda: person.status().get("text") == "following eight")
        seen = {"state": person.status(), "before": sprite(browser)}
        browser.js(SLIDER, "noise scale", 0.5)
        browser.js(SLIDER, "push car x [px]", 10)
        until(lambda: person.value("noise scale") == "0.5")
        until(lambda: browser.js("return viewer.gui_controllers['push car x [px]'].getValue()") == 0)
        seen["after"] = sprite(browser)
        person.leave()
        time.sleep(1.0)  # nobody looks for a while; nothing is to happen
        assert program.process.poll() is None
        person.look()
        until(lambda: person.value("noise scale") == "0.5")
        person.press(person.keys.ESCAPE)
        status = program.wait()
        person.leave()
        yield folder / "out", status, program.said(), seen
    finally:
        if program.process.poll() is None:
            program.process.kill()


def _demonstrations(folder):
    from ichain_drake.demonstrations import write_demonstrations
    from ichain_drake.systems import load_scenario

    scenario = load_scenario("car_game", ["learning.samples=60"], "ideal", 0)
    write_demonstrations(list(scenario.record_demonstrations()), folder / "demonstrations")
    return folder / "demonstrations"


def sprite(browser):
    return browser.node("drake/car/screen/sprite")["position"]


def test_shows_the_scene_while_it_runs(stopped):
    *_, seen = stopped
    assert "time" in seen["state"]["values"]
    assert seen["before"] != seen["after"]


def test_stop_ends_it_as_an_interruption_and_keeps_report_and_recording(stopped):
    folder, status, said, _ = stopped
    assert status == 130
    assert "interrupted; what was done so far is kept" in said
    report = json.loads((folder / "report.json").read_text())
    assert not report["goal_reached"]
    assert report["reason"] == "interrupted"
    assert report["sim_seconds"] > 1.0
    assert (folder / "playback.html").stat().st_size > 100_000


def test_what_was_adjusted_is_in_the_report(stopped):
    folder, *_ = stopped
    changes = json.loads((folder / "report.json").read_text())["live"]["changes"]
    assert [(c["what"], c["value"]) for c in changes] == [("noise scale", 0.5), ("push car x [px]", 10.0)]

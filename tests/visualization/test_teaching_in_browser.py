"""A person teaches in a real browser, by gamepad and by keys; what is learned from it predicts what is not."""

import json
import re

import numpy as np
import pytest
from patience import until
from teaching_person import GAMEPAD, Person, Program

from ichain_drake.demonstrations import Demonstration, read_demonstrations
from ichain_drake.demonstrations.transitions import collect_transitions
from ichain_drake.learning.chain.chain import learn_link
from ichain_drake.systems import load_scenario
from ichain_drake.timing import TICK

LESSON = 10.0  # [s] of the recorded world with each device: a busy machine takes longer for them


def recorded(person: Person) -> float:
    """Length of the piece that is being recorded [s], as the page says it: whole ticks of the world."""
    said = re.search(r"(\d+) rows", person.value("piece"))
    return 0.0 if said is None else (int(said[1]) - 1) * TICK


@pytest.fixture(scope="module")
def taught(browser, tmp_path_factory):
    """Two pieces, one kept by a button, one by closing the page; then a discarded one, marks, and the end."""
    folder = tmp_path_factory.mktemp("taught")
    program = Program(
        folder, "teach", "car_game", "--browser", "--no-open", "--physics", "ideal", "-o", str(folder / "pieces")
    )
    try:
        person = Person(browser, program)
        seen = {"help": browser.js("return document.getElementById('ichain-live').innerText")}

        browser.js(GAMEPAD)
        person.press("r")
        until(lambda: person.status().get("state") == "recording")
        until(lambda: recorded(person) >= LESSON)
        seen["device"] = person.value("driven with")
        person.press("k")
        until(lambda: "joystick-001 is saved" in person.value("last"))

        person.leave()
        until(lambda: "nobody looks" in program.said().split("a browser is there")[-1])
        person.look()
        person.press("n")
        person.press("r")
        until(lambda: person.status().get("state") == "recording")
        turn = 0
        person.actions().key_down(person.keys.ARROW_UP).perform()
        while recorded(person) < LESSON:
            person.hold((person.keys.ARROW_LEFT, person.keys.ARROW_RIGHT)[turn % 2], 0.3 + 0.25 * (turn % 3))
            turn += 1
            if turn % 4 == 0:
                person.actions().key_up(person.keys.ARROW_UP).perform()
                person.press(person.keys.ARROW_DOWN)
                person.actions().key_down(person.keys.ARROW_UP).perform()
        seen["keys"] = person.value("driven with")
        person.leave()
        until(lambda: "joystick-002 is saved" in program.said())

        person.look()
        seen["sliders"] = browser.js(
            "return ['steering', 'throttle'].map(name => viewer.gui_controllers[name].getValue())"
        )
        person.press("r")
        until(lambda: person.status().get("state") == "recording")
        person.press("x")
        until(lambda: "discarded" in person.value("last"))
        person.press("r")
        until(lambda: person.status().get("state") == "recording")
        person.press("1")
        until(lambda: person.value("joystick->car") == "inactive (your mark)")
        until(lambda: recorded(person) >= 1.0)
        person.press(person.keys.ESCAPE)
        status = program.wait()
        person.leave()
        yield folder / "pieces", status, program.said(), seen
    finally:
        if program.process.poll() is None:
            program.process.kill()


def test_pieces_are_on_disk_with_how_they_were_sampled(taught):
    folder, status, said, _ = taught
    assert status == 0
    assert sorted(f.name for f in folder.iterdir()) == [
        f"joystick-00{i}.{ending}" for i in (1, 2, 3) for ending in ("json", "parquet")
    ]
    about = [json.loads((folder / f"joystick-00{i}.json").read_text()) for i in (1, 2, 3)]
    assert [a["ended_by"] for a in about] == ["the person", "the browser was lost", "the end"]
    assert about[2]["marked"] == ["joystick->car"]
    for entry in about:
        # The frame that is under way when a person begins to record isn't a whole one.
        assert entry["sampling"]["frames"] >= 10 * (entry["rows"] - 1) - 1
        assert {"mean_period_ms", "p99_period_ms", "late_frames"} <= set(entry["sampling"])
    for line in ("joystick-003 was discarded", "written:", "nobody looks"):
        assert line in said


def test_the_page_tells_a_first_time_user_what_to_do(taught):
    _, _, _, seen = taught
    for text in ("steering: left, right", "throttle: brake, go", "record a piece", "discard it", "mark joystick->car"):
        assert text in seen["help"]
    assert seen["device"] == "gamepad"
    assert seen["keys"] == "keys"


def test_a_lost_browser_lets_go_of_the_stick(taught):
    *_, seen = taught
    assert seen["sliders"] == [0, 0]


def test_marks_are_in_the_piece(taught):
    folder, *_ = taught
    pieces = read_demonstrations(folder, load_scenario("car_game").graph)
    assert (pieces[0].table["joystick->car"] == 1).all()
    flags = pieces[2].table["joystick->car"].to_numpy()
    assert flags[-1] == 0
    assert (np.diff(flags) <= 0).all()


def test_what_is_learned_predicts_what_was_held_out(taught):
    folder, *_ = taught
    scenario = load_scenario("car_game")
    edge = next(e for e in scenario.graph.interactions if e.name == "joystick->car")
    pieces = read_demonstrations(folder, scenario.graph)[:2]
    assert all(len(p) * 1 / 3 >= 0.9 * LESSON for p in pieces)

    def part(piece, first, last):
        rows = piece.table.iloc[int(first * len(piece)) : int(last * len(piece))].reset_index(drop=True)
        return Demonstration(rows, piece.units, piece.name)

    candidates = scenario.config.learning.candidates()[edge.name]
    link = learn_link([part(p, 0, 0.7) for p in pieces], scenario.graph, edge, candidates, scenario.target_indices())
    held_out = collect_transitions([part(p, 0.7, 1) for p in pieces], scenario.graph, edge)
    predicted = link.forward.model.predict(held_out.child, held_out.parent, held_out.parent_next)

    def error(states):
        return np.sqrt((held_out.child_space.difference(states, held_out.child_next) ** 2).mean(axis=0))

    ratio = error(predicted) / error(held_out.child)
    assert ratio[:2].max() < 0.5  # position
    assert ratio.mean() < 0.5  # every variable counts alike

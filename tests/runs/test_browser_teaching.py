"""Pieces, seats and the clock of teaching in the browser; the browser itself is in tests/visualization."""

import json
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from ichain_drake.demonstrations import read_demonstrations
from ichain_drake.errors import InputError
from ichain_drake.runs.browser_pieces import OpenPiece, PieceRecorder
from ichain_drake.runs.browser_teaching import END, RECORD, RESTART, TeachingSession
from ichain_drake.scenarios.seats import choose_seat
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.episode import Episode
from ichain_drake.simulation.real_time import FrameClock
from ichain_drake.systems import load_scenario
from ichain_drake.timing import FRAME


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("car_game", (), "ideal", 0)


@pytest.fixture
def driven(scenario):
    world = choose_seat(scenario).world(950)
    episode = Episode(world, Commands(np.array([[0.5, 0.02], [0.51, 0.01], [0.5, 0.03]])))
    episode.run(6)
    return episode


def test_a_piece_has_the_rows_of_whole_ticks(scenario, driven, tmp_path):
    recorder = PieceRecorder(choose_seat(scenario), scenario.graph, tmp_path, {"seed": 0})
    recorder.begin(7)
    piece = recorder.keep(driven, 44, {"late_frames": 0}, "the person")
    log = driven.log()
    assert len(piece) == 4
    assert piece.table["time"].to_list() == pytest.approx([0, 1 / 3, 2 / 3, 1])
    assert np.array_equal(piece.table["car.x"], log.measured["car"][[10, 20, 30, 40], 0])
    (read,) = read_demonstrations(tmp_path, scenario.graph)
    assert read.table.equals(piece.table)
    assert json.loads((tmp_path / "joystick-001.json").read_text())["ended_by"] == "the person"


@pytest.mark.parametrize(("frame", "rows"), [(5, 0), (19, 0), (20, 1), (29, 1), (30, 2), (51, 4)])
def test_a_row_is_begun_at_the_first_frame_and_after_every_ten(frame, rows):
    assert OpenPiece("joystick-001", 20).rows(frame) == rows


def test_numbers_go_on_where_a_folder_ends(scenario, driven, tmp_path):
    for expected in ("joystick-001", "joystick-002"):
        recorder = PieceRecorder(choose_seat(scenario), scenario.graph, tmp_path, {})
        recorder.begin(0)
        assert recorder.keep(driven, 60, {}, "the person").name == expected
    recorder.begin(0)
    recorder.drop()
    recorder.begin(0)
    assert recorder.open.name == "joystick-003"


def test_a_piece_without_a_transition_is_not_kept(scenario, driven, tmp_path):
    recorder = PieceRecorder(choose_seat(scenario), scenario.graph, tmp_path, {})
    recorder.begin(1)
    assert recorder.keep(driven, 15, {}, "the person") is None
    assert recorder.open is None
    assert not list(tmp_path.iterdir())


def test_marks_replace_the_flags_of_their_interaction(scenario, driven, tmp_path):
    recorder = PieceRecorder(choose_seat(scenario, "hand"), scenario.graph, tmp_path, {})
    recorder.begin(0)
    recorder.mark("joystick->car", 12, True)
    assert recorder.open.marked("joystick->car") is False
    recorder.mark("joystick->car", 31, True)
    assert [recorder.open.marked(e) for e in ("joystick->car", "hand->joystick")] == [True, None]
    piece = recorder.keep(driven, 60, {}, "the person")
    assert piece.table["joystick->car"].to_list() == [1, 1, 0, 0, 1, 1, 1]
    assert piece.table["hand->joystick"].to_list() == list(driven.log().active["joystick"][::10, 0])


def test_a_folder_that_cannot_be_written_keeps_the_piece_open(scenario, driven, tmp_path):
    (tmp_path / "file").write_text("")
    recorder = PieceRecorder(choose_seat(scenario), scenario.graph, tmp_path / "file", {})
    recorder.begin(0)
    with pytest.raises(InputError, match="can't make the folder"):
        recorder.keep(driven, 60, {}, "the person")
    assert recorder.open is not None


def test_the_stick_follows_its_axes_and_springs_back(scenario):
    seat = choose_seat(scenario)
    middle = seat.command(np.zeros(2), np.zeros(2), np.zeros(2))
    right = seat.command(np.array([1.0, 0.0]), middle, middle)
    assert middle == pytest.approx([0.5, 0.0])
    assert right[0] - middle[0] == pytest.approx(0.1 * np.sin(np.deg2rad(25)), rel=1e-6)


def test_the_hand_stays_where_axes_left_it():
    seat = choose_seat(load_scenario("water_dispenser", (), "ideal", 0))
    home = np.array([0.56, -0.08, 0.25, 0.0, np.pi / 2, 0.0])
    axes = np.array([1.0, 0.0, -0.5, 0.0, 0.0])
    command = home
    for _ in range(30):
        command = seat.command(axes, command, command)
    assert command[[0, 2]] - home[[0, 2]] == pytest.approx([0.15, -0.075], abs=1e-9)
    assert seat.command(np.zeros(5), command, home) == pytest.approx(command)
    assert seat.toggle("grip", command)[5] == 1.0
    assert seat.toggle("grip", seat.toggle("grip", command)) == pytest.approx(command)
    assert seat.command(axes, home + [5, 0, 0, 0, 0, 0], home)[0] < home[0] + 0.1  # never far ahead of the hand
    assert [a.keys[1] for a in seat.axes[:3]] == ["ArrowUp", "ArrowLeft", "KeyW"]


def test_every_scenario_can_be_driven_and_an_unknown_object_is_refused(scenario):
    assert choose_seat(scenario, "hand").objects == ("hand", "joystick", "car")
    with pytest.raises(InputError, match="nobody can drive 'car'; there is joystick, hand"):
        choose_seat(scenario, "car")


def test_the_clock_keeps_the_mean_period_and_does_not_hurry_after_a_stall():
    clock = FrameClock()
    clock.restart()
    for frame in range(30):
        clock.wait()
        if frame == 20:
            time.sleep(6 * FRAME)
    found = clock.sampling()
    assert found["frames"] == 30
    assert found["late_frames"] >= 1
    assert clock.recently_late >= 1
    # 29 periods, of which the stalled one takes six: nothing of it is made up for by shorter ones.
    assert found["mean_period_ms"] >= (28 + 6) / 29 * 1000 * FRAME - 1
    clock.restart()
    assert clock.sampling() == {"frames": 0, "late_frames": 0}


def test_nothing_moves_while_nobody_looks(scenario, tmp_path):
    said = []
    session = TeachingSession(scenario, choose_seat(scenario), tmp_path, said.append)
    session._start()
    session._leave()
    session._press(RECORD.name)
    for _ in range(21):
        session._frame()
    session._leave()
    session._press(RECORD.name)
    session._leave()
    session.view.close()
    assert any("joystick-002 was too short to keep" in line for line in said)
    assert [p.name for p in session.pieces.saved] == ["joystick-001"]
    assert len(session.pieces.saved[0]) == 3
    assert (tmp_path / "joystick-001.parquet").is_file()
    assert sum("nobody looks" in line for line in said) == 3


def test_a_piece_that_cannot_be_written_is_not_lost(scenario, tmp_path):
    folder = tmp_path / "pieces"
    folder.write_text("in the way")
    said = []
    session = TeachingSession(scenario, choose_seat(scenario), folder, said.append)
    session._start()
    session._press(RECORD.name)
    for _ in range(31):
        session._frame()
    assert sum(line.startswith("NOT SAVED meanwhile: ") for line in said) == 1  # however many rows come
    session._press(END.name)
    assert not session._over
    assert "can't make the folder" in session._alarm()
    folder.unlink()
    session._press(END.name)
    session.view.close()
    assert session._over
    assert (folder / "joystick-001.parquet").is_file()


def test_a_new_start_and_a_record_in_one_frame_begin_a_piece(scenario, tmp_path, monkeypatch):
    session = TeachingSession(scenario, choose_seat(scenario), tmp_path, lambda line: None)
    session._start()
    monkeypatch.setattr(session.view.controls, "pressed", lambda: [RECORD.name, RESTART.name])
    session._frame()
    session.view.close()
    assert session.pieces.open is not None


def test_an_open_piece_outlives_its_process(scenario, driven, tmp_path):
    """As after SIGKILL: nobody keeps the piece, its file loses its lock, and the next session saves it."""
    recorder = PieceRecorder(choose_seat(scenario, "hand"), scenario.graph, tmp_path, {})
    recorder.begin(0)
    recorder.mark("joystick->car", 12, True)
    for frame in (1, 20, 40, 60):
        recorder.note(driven, frame)
    rows = recorder._record.rows
    assert rows == 6
    assert not PieceRecorder(choose_seat(scenario, "hand"), scenario.graph, tmp_path, {}).recovered  # it is alive
    recorder._record._stream.close()  # the end of the process
    with next(tmp_path.glob(".*.open")).open("a") as stream:
        stream.write("[0.1, 0.2")  # a line that it was writing then
    again = PieceRecorder(choose_seat(scenario, "hand"), scenario.graph, tmp_path, {"seed": 0})
    (piece,) = again.recovered
    assert piece.name == "hand-001"
    log = driven.log()
    assert np.array_equal(piece.table["car.x"], log.measured["car"][: 10 * rows : 10, 0])
    assert piece.table["joystick->car"].to_list() == [1, 1, 0, 0, 0, 0]
    assert np.array_equal(piece.table["command.x"], log.command[1 : 10 * rows : 10, 0])
    (read,) = read_demonstrations(tmp_path, scenario.graph)
    assert read.table.equals(piece.table)
    assert json.loads((tmp_path / "hand-001.json").read_text())["ended_by"] == "the end of the process"
    assert not list(tmp_path.glob(".*.open"))
    again.begin(0)
    assert again.open.name == "hand-002"


def test_a_kept_or_dropped_piece_leaves_no_open_file(scenario, driven, tmp_path):
    recorder = PieceRecorder(choose_seat(scenario), scenario.graph, tmp_path, {})
    recorder.begin(0)
    recorder.note(driven, 40)
    assert [f.name for f in tmp_path.iterdir()] == [".joystick-001.open"]
    recorder.drop()
    assert not list(tmp_path.iterdir())
    recorder.begin(0)
    recorder.note(driven, 40)
    assert len(recorder.keep(driven, 60, {}, "the person")) == 7
    assert sorted(f.name for f in tmp_path.iterdir()) == ["joystick-001.json", "joystick-001.parquet"]


def test_numbers_go_on_after_a_middle_one_was_deleted(scenario, driven, tmp_path):
    def record():
        recorder = PieceRecorder(choose_seat(scenario), scenario.graph, tmp_path, {})
        recorder.begin(0)
        return recorder.keep(driven, 60, {}, "the person").name

    for _ in range(3):
        record()
    (tmp_path / "joystick-002.parquet").unlink()
    assert record() == "joystick-004"
    # Another session took the next number meanwhile.
    recorder = PieceRecorder(choose_seat(scenario), scenario.graph, tmp_path, {})
    assert record() == "joystick-005"
    recorder.begin(0)
    assert recorder.keep(driven, 60, {}, "the person").name == "joystick-006"


def test_a_killed_session_loses_at_most_a_second(tmp_path):
    """A process of its own records for some seconds and gets SIGKILL."""
    script = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from ichain_drake.runs.browser_teaching import RECORD, TeachingSession\n"
        "from ichain_drake.scenarios.seats import choose_seat\n"
        "from ichain_drake.systems import load_scenario\n"
        "s = load_scenario('car_game', (), 'ideal', 0)\n"
        "session = TeachingSession(s, choose_seat(s), Path(sys.argv[1]), lambda line: None)\n"
        "session._start()\n"
        "session._press(RECORD.name)\n"
        "while True:\n"
        "    session._frame()\n"
        "    print(session._count, flush=True)\n"
    )
    with subprocess.Popen([sys.executable, "-c", script, str(tmp_path)], stdout=subprocess.PIPE, text=True) as process:
        frames = next(n for line in process.stdout if (n := int(line)) >= 97)
        process.send_signal(signal.SIGKILL)
    scenario = load_scenario("car_game", (), "ideal", 0)
    (piece,) = PieceRecorder(choose_seat(scenario), scenario.graph, tmp_path, {}).recovered
    assert frames - 10 * len(piece) <= 30
    assert len(read_demonstrations(tmp_path, scenario.graph)) == 1


def test_every_start_has_noise_of_its_own_until_the_numbers_come_round():
    class StartedError(Exception):
        pass

    def world(number):
        numbers.append(number)
        raise StartedError

    numbers = []
    session = SimpleNamespace(_restarts=0, _seat=SimpleNamespace(world=world))
    for _ in range(51):
        with pytest.raises(StartedError):
            TeachingSession._start(session)
    assert numbers == [*range(950, 1000), 950]


def test_the_page_tells_how_long_a_piece_is_from_its_first_frame_on():
    shown = []
    piece = SimpleNamespace(name="p", first=20, rows=lambda count: 1)
    session = SimpleNamespace(
        pieces=SimpleNamespace(open=piece, saved=[], edges=()), clock=SimpleNamespace(late=0), _notice="", _count=26,
        _alarm=lambda: "",
        view=SimpleNamespace(
            controls=SimpleNamespace(device="keys"), page=SimpleNamespace(show=lambda *args: shown.append(args[2]))
        ),
    )  # fmt: skip
    TeachingSession._tell(session)
    assert shown[0]["piece"] == "p, 0.2 s, 1 rows"

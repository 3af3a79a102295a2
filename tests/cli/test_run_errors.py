"""Bad input to `ichain run`: status 2 and one line that names what is wrong, before any long work."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from ichain_drake.cli.main import main


@pytest.fixture
def refused(ichain, small, tmp_path):
    """Runs with a small scenario; gives the error's line."""

    def call(*arguments: object) -> str:
        done = ichain("run", "car_game", *small, "-o", tmp_path / "out", *arguments)
        assert done.status == 2, done
        assert done.out == ""
        assert not (tmp_path / "out" / "report.json").exists()
        return done.line

    return call


PATHS = {
    "nan": ([[100, 100], [200, np.nan], [300, 100]], ("x", "y"), "line 3, column y: not a finite number"),
    "infinite": ([[100, 100], [np.inf, 100]], ("x", "y"), "line 3, column x: not a finite number"),
    "one": ([[100, 100]], ("x", "y"), "1 point(s); a path needs at least 2"),
    "none": (np.zeros((0, 2)), ("x", "y"), "0 point(s)"),
    "still": ([[100, 100], [100, 100]], ("x", "y"), "all points are the same"),
    "tiny": ([[100, 100], [101, 100]], ("x", "y"), "give a longer path"),
    "outside": ([[100, 100], [900, 100]], ("x", "y"), "line 3: (900, 100) px is outside the screen of 800 x 600 px"),
    "column": ([[100, 100], [200, 100]], ("x", "z"), "column y is missing; a path has columns x, y"),
}


@pytest.mark.parametrize("name", PATHS)
def test_a_bad_path(name, refused, csv):
    points, columns, message = PATHS[name]
    file = csv(points, columns)
    line = refused("--path", file)
    assert str(file) in line and message in line


@pytest.mark.parametrize(
    ("text", "message"),
    [("x,y\n1,2\n3,far\n", "line 3, column y"), ("", "can't read the path"), ("x,y\n1,2\n3,4,5\n6,7\n", "can't read")],
)
def test_a_path_file_that_is_no_table_of_numbers(text, message, refused, tmp_path):
    file = tmp_path / "path.csv"
    file.write_text(text)
    assert message in refused("--path", file)


def test_a_path_file_that_is_not_there_or_a_folder(refused, tmp_path):
    assert "nix.csv: can't read the path" in refused("--path", tmp_path / "nix.csv")
    assert "can't read the path" in refused("--path", tmp_path)


def test_a_path_that_turns_more_tightly_than_the_demonstrations(ichain, csv, tmp_path):
    """A right angle is named with point, radius and limit."""
    corner = csv([[100, 150], [400, 150], [400, 400]], name="corner.csv")
    done = ichain(
        "run", "car_game", "--physics", "ideal", "--set", "learning.samples=300", "--path", corner,
        "-o", tmp_path / "out",
    )  # fmt: skip
    assert done.status == 2
    found = re.search(
        r"path corner: at \((\d+), (\d+)\) it turns with a radius of ([\d.]+) px; .* (\d+) px/s is ([\d.]+) px",
        done.line,
    )
    assert found, done.line
    x, y, radius, speed, limit = map(float, found.groups())
    assert np.hypot(x - 400, y - 150) < 40
    assert radius < limit < 60
    assert 5 < speed < 45
    assert "widen the turn" in done.line and "--smooth" in done.line


def test_path_and_paths_exclude_each_other_and_names_are_known(refused, bend_csv):
    assert "give one of the two" in refused("--path", bend_csv, "--paths", "eight")
    assert "has no path 'nine'; it has eight, spiral, cursive" in refused("--paths", "nine")
    assert "no path 'nine'" in refused("--paths", "eight", "nine")


def test_two_paths_have_names_of_their_own_and_smoothing_is_for_them(refused, bend_csv, csv, tmp_path):
    (tmp_path / "other").mkdir()
    again = tmp_path / "other" / bend_csv.name
    again.write_bytes(bend_csv.read_bytes())
    assert "another path is called bend, too" in refused("--path", bend_csv, "--path", again)
    assert "nix.csv: can't read the path" in refused("--path", bend_csv, "--path", tmp_path / "nix.csv")
    assert "--smooth is for --path" in refused("--smooth", "--paths", "eight")


def test_a_name_without_its_option(refused):
    assert "'eight'" in refused("eight")


SETTINGS = {
    "noise.scal=2": "there is no key 'scal'; did you mean scale?",
    "x=1": "there is no key 'x'; known are",
    "noise.scale.more=1": "more",
    "noise.scale": "write key=value",
    "=3": "write key=value",
    "noise.scale=loud": "'loud'",
    "noise.scale=[1": "malformed value",
    "noise.scale=-1": "noise.scale is -1.0",
    "noise.scale=.nan": "noise.scale is nan",
    "noise.scale=.inf": "noise.scale is inf",
    "learning.samples=1.5": "samples",
    "learning.samples=-3": "learning.samples is -3",
    "learning.samples=0": "learning.samples is 0",
    "learning.action=later": "learning.action 'later': choose next or current",
    "learning.estimator=nix": "hand->joystick: nix(): there is no estimator 'nix'",
    "learning.estimator=polynomial(degre=2)": "no parameter 'degre'; it has degree",
    "learning.estimator=poly(": "write name or name(parameter=value, ...)",
    "learning.estimator=__import__('os').system('true')": "write name or name(parameter=value, ...)",
    'learning.links=[{interaction: "a->b"}]': "a->b",
    'learning.links=[{interaction: "hand->joystick", features: [smell]}]': "features 'smell'",
    'learning.links=[{interaction: "hand->joystick", aims: [0]}]': "aims is [0]",
    "control.method=magic": "control.method 'magic': choose predictive or inverse",
    "control.horizons=[]": "one or more numbers from 2",
    "control.horizons=[1]": "one or more numbers from 2",
    "control.efforts=[0]": "one or more numbers above 0",
    "fault.kind=slip": "no fault 'slip'",
    "camera.yaw_deg=10": "no camera",
    "path.speed=0": "path.speed is 0.0",
    "path.spacing=1e-9": "give a larger spacing",
    "play.reach=-1": "play.reach is -1.0",
    "play.step=0": "play.step is 0.0",
    "joystick.handle=0": "joystick.handle is 0.0",
    "joystick.pivot=[1,2]": "joystick.pivot is [1.0, 2.0]",
    "start.axes=[5, 5]": "start.axes is [5.0, 5.0]",
    "start.axes=[0]": "start.axes is [0.0]",
    "robot.hand.exposed=3": "a list, such as ['x', 'y', 'z', 'yaw', 'pitch', 'roll', 'grip'] is needed there",
    "robot.home=[1]": "a mapping, as {a: 1} is needed there",
    "robot.arm=": "a text is needed there",
    "robot.hand.exposed=[x]": "y is neither exposed nor held",
}


@pytest.mark.parametrize("setting", SETTINGS)
def test_a_bad_setting_is_refused_before_anything_is_recorded(setting, refused, tmp_path):
    assert SETTINGS[setting] in refused("--paths", "eight", "--set", setting)
    assert not list(tmp_path.glob("out/demonstrations/*"))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["learning.samples=9"], ["hand->joystick", "9 transitions are too few", "record at least 10"]),
        (
            ["learning.samples=12", "learning.estimator=polynomial(degree=4)"],
            ["n_samples = 12 for degree 4", "lower the degree"],
        ),
        (
            ["learning.samples=40", "learning.estimator=polynomial(degree=7)"],
            ["joystick->car", "n_samples = 40 for degree 7", "record more demonstrations or lower the degree"],
        ),
    ],
)
def test_too_few_samples_for_every_candidate(settings, words, refused):
    line = refused("--paths", "eight", *(word for s in settings for word in ("--set", s)))
    assert all(word in line for word in words), line


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run", "cra_game"], "there is no scenario 'cra_game'; did you mean car_game?"),
        (["run", "zzz"], "there are car_game"),
        (["run"], "Missing argument 'SCENARIO'"),
        (["run", "car_game", "--physics", "unreal"], "physics 'unreal': choose ideal, arm or contact"),
        (["run", "car_game", "--seed", "-1"], "seed -1"),
        (["run", "car_game", "--seed", "x"], "'x' is not a valid integer"),
        (["run", "car_game", "--nix"], "--nix"),
        (["run", "car_game", "--record", "film.txt"], "a playback ends in .html"),
        (["run", "car_game", "--demos", "nix"], "nix: no such folder of demonstrations"),
        (["run", "car_game", "--library", "nix"], "nix"),
    ],
)
def test_wrong_usage(arguments, message, ichain, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # where a default output folder would go
    done = ichain(*arguments)
    assert done.status == 2
    assert message in done.line


def test_an_output_folder_that_cannot_be_made_is_refused_at_once(ichain, small, bend_csv, tmp_path):
    """Root may write everywhere, so no permission is taken away: a file stands where the folder should be."""
    blocked = tmp_path / "file" / "out"
    blocked.parent.write_text("a file")
    for options in (
        ["-o", blocked],
        ["-o", tmp_path / "o", "--record", blocked / "film.html"],
        ["-o", tmp_path / "o", "--report", blocked / "report.json"],
    ):
        done = ichain("run", "car_game", *small, "--path", bend_csv, *options)
        assert done.status == 2
        assert str(blocked) in done.line
        assert not list(tmp_path.glob("o/demonstrations/*"))


def test_a_folder_in_place_of_the_report_is_refused_at_once(ichain, small, bend_csv, tmp_path):
    (tmp_path / "r.json").mkdir()
    done = ichain("run", "car_game", *small, "--path", bend_csv, "-o", tmp_path / "o", "--report", tmp_path / "r.json")
    assert done.status == 2
    assert "r.json: is a folder" in done.line
    assert not list(tmp_path.glob("o/demonstrations/*"))


LIMITED = """
import resource, sys
from ichain_drake.cli.main import main
import ichain_drake.runs.paths.run, ichain_drake.visualization  # imported before files may not grow
import signal
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
sys.dont_write_bytecode = True  # it would be cut
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
sys.exit(main(sys.argv[1:]))
"""


def test_a_disk_that_fills_up_leaves_what_fitted(small, bend_csv, tmp_path):
    """Files may not grow over 200 kB, as on a full disk: demonstrations and report fit, the playback doesn't."""
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, "run", "car_game", *small, "--path", str(bend_csv), "-o", str(tmp_path)],
        capture_output=True, text=True, check=False, env=os.environ | {"OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    said = [line for line in done.stderr.splitlines() if not line.startswith("[")]
    assert len(said) == 1, done.stderr
    assert "playback.html: can't write" in said[0]
    left = sorted(f.name for f in tmp_path.rglob("*") if f.is_file())
    assert left == ["drive.parquet", "play.parquet", "report.json"]


def test_the_installed_command_prints_one_line(tmp_path):
    """As a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "ichain_drake", "run", "car_game", "--set", "noise.scal=2", "-o", str(tmp_path)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == "ichain: --set noise.scal: there is no key 'scal'; did you mean scale?\n"


def test_main_gives_the_status_without_raising(capsys):
    assert main(["run", "car_game", "--physics", "unreal"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


WRITTEN = {
    "metres": ("x [m],y [m]\n1,1\n2,2\n", "column x is in m, a path here in px, and there is no way from m to px"),
    "decimal commas": ("x,y\n100,5,300,5\n200,5,300,5\n", "line 2 has 4 fields, the header 2"),
    "doubled": ("x,x,y\n100,1,300\n200,1,300\n", "column x appears twice"),
    "zip": ("PK\x03\x04", "is a zip archive"),
    "huge": ("x,y\n1,1\n1e300,1\n", "outside the screen"),
}


@pytest.mark.parametrize("name", WRITTEN)
def test_a_path_that_would_be_misread(name, refused, tmp_path):
    text, message = WRITTEN[name]
    (tmp_path / "path.csv").write_text(text)
    assert message in refused("--path", tmp_path / "path.csv")


@pytest.mark.parametrize("ending", ["zip", "xz", "tar", "zst", "csv.gz"])
def test_a_broken_archive_as_a_path(ending, refused, tmp_path):
    (tmp_path / f"path.{ending}").write_bytes(b"\x1f\x8b broken" if ending == "csv.gz" else b"broken")
    assert "path" in refused("--path", tmp_path / f"path.{ending}")


def test_a_pipe_as_a_path_and_a_name_of_300_characters(refused, tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    assert "it is a pipe or a device" in refused("--path", tmp_path / "pipe.csv")
    assert "File name too long" in refused("--path", tmp_path / ("x" * 300))

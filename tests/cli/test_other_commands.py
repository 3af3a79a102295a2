"""`list`, `graph`, `play`, `library`, help, version, and what is none of these."""

import importlib.metadata
import shutil
import subprocess
import sys

import pytest


def test_list_names_every_scenario(ichain):
    from ichain_drake.systems import OPTIONAL, SCENARIOS

    done = ichain("list")
    assert done.status == 0
    assert [line.split()[0] for line in done.out.splitlines()] == [*SCENARIOS, *OPTIONAL]
    assert all(len(line.split()) > 3 for line in done.out.splitlines())


def test_version_and_help(ichain):
    assert importlib.metadata.version("ichain_drake") in ichain("--version").out
    for arguments in (["--help"], ["-h"], ["run", "--help"], ["library", "--help"], ["evaluate", "-h"]):
        done = ichain(*arguments)
        assert done.status == 0
        assert "Usage: ichain" in done.out


def test_help_names_every_option_of_the_design(ichain):
    text = ichain("run", "--help").out
    for option in ["--physics", "--seed", "--path", "--paths", "--demos", "--library", "--record", "--report", "--set"]:
        assert f"{option} " in text, option


def test_no_command_shows_the_help_with_status_2(ichain):
    done = ichain()
    assert (done.status, done.out) == (2, "")
    assert "Usage: ichain" in done.err


@pytest.mark.parametrize("arguments", [["nix"], ["library", "nix"], ["list", "--nix"], ["list", "more"]])
def test_unknown_commands_and_options(arguments, ichain):
    done = ichain(*arguments)
    assert (done.status, done.out) == (2, "")
    assert arguments[-1] in done.line or "more" in done.line


def test_help_needs_no_drake():
    """It answers at once: the heavy imports belong to the commands that need them."""
    code = (
        "import sys; from ichain_drake.cli.main import main; status = main(['run', '--help']); "
        "sys.exit(status or [m for m in sys.modules if m.startswith(('pydrake', 'sklearn'))] != [])"
    )
    assert subprocess.run([sys.executable, "-c", code], stdout=subprocess.DEVNULL, check=False).returncode == 0


def test_graph_as_text(ichain):
    done = ichain("graph", "car_game")
    assert (done.status, done.err) == (0, "")
    assert done.out == "hand -> joystick\njoystick -> car\ncar -> (nothing)\n"


def test_graph_as_dot(ichain, tmp_path):
    done = ichain("graph", "car_game", "-o", tmp_path / "g.dot")
    assert done.out == f"written: {tmp_path / 'g.dot'}\n"
    text = (tmp_path / "g.dot").read_text()
    assert '"hand" -> "joystick"' in text and "x_axis" in text and "tilt_x" not in text


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz (`dot`) is not installed")
@pytest.mark.parametrize("options", [[], ["--diagram"], ["--diagram", "--physics", "contact"]])
def test_graph_as_picture(options, ichain, tmp_path):
    done = ichain("graph", "car_game", "-o", tmp_path / "g.svg", *options)
    assert done.status == 0
    text = (tmp_path / "g.svg").read_text()
    assert "<svg" in text
    assert all(name in text for name in ("hand", "joystick", "car"))


def test_the_diagram_has_one_system_an_object(ichain):
    assert ichain("graph", "car_game", "--diagram").out.split() == ["hand", "joystick", "car"]
    systems = ichain("graph", "water_dispenser", "--diagram").out.split()
    assert sorted(systems) == ["cup", "dispense", "hand", "power", "tank"]


def test_graph_errors(ichain, tmp_path, monkeypatch):
    assert "there is no scenario 'nix'" in ichain("graph", "nix").line
    assert "a drawing ends in" in ichain("graph", "car_game", "-o", tmp_path / "g.xyz").line
    assert "can't write" in ichain("graph", "car_game", "-o", tmp_path / "nix" / "g.dot").line
    monkeypatch.setenv("PATH", str(tmp_path))
    done = ichain("graph", "car_game", "-o", tmp_path / "g.svg")
    assert done.status == 2 and "Graphviz is not installed" in done.line


def test_play_opens_a_file_that_is_there(ran, ichain, tmp_path, monkeypatch):
    missing = ichain("play", tmp_path / "nix.html")
    assert missing.status == 2 and "no such playback" in missing.line
    # `webbrowser` reads BROWSER: a browser that only notes what it was given.
    note = tmp_path / "opened"
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {note}\n')
    browser.chmod(0o755)
    code = f"import sys; from ichain_drake.cli.main import main; sys.exit(main(['play', r'{ran / 'playback.html'}']))"
    done = subprocess.run(
        [sys.executable, "-c", code], env={"BROWSER": str(browser), "PATH": "/usr/bin:/bin"}, check=False,
        stdout=subprocess.DEVNULL,
    )  # fmt: skip
    assert done.returncode == 0
    assert note.read_text().strip() == (ran / "playback.html").resolve().as_uri()


def test_a_reader_that_leaves_early_is_no_error():
    """`ichain list | head -0`."""
    process = subprocess.Popen(
        [sys.executable, "-c", "import sys; from ichain_drake.cli.start import main; sys.exit(main(['list']))"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    assert process.stdout is not None and process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == b""
    assert process.wait() == 0


def test_library_commands(ran, ichain, tmp_path):
    library, samples = tmp_path / "library", ("--set", "learning.samples=120")
    assert ichain("learn", "car_game", "--demos", ran / "demonstrations", "-o", library, *samples).status == 0
    listed = ichain("library", "list", "--library", library)
    assert listed.status == 0
    assert "hand-joystick" in listed.out and "joystick->car" in listed.out
    shown = ichain("library", "show", "hand-joystick", "--library", library)
    assert shown.status == 0
    assert "120" in shown.out and "polynomial" in shown.out and "[m]" in shown.out
    other = tmp_path / "other"
    assert ichain("library", "add", library, "--library", other).status == 0
    assert sorted(f.name for f in other.iterdir()) == ["hand-joystick", "joystick-car"]
    assert ichain("library", "check", other).status == 0
    (other / "hand-joystick" / "more.pkl").write_bytes(b"\x80\x04.")
    bad = ichain("library", "check", other)
    assert bad.status == 2 and bad.err.count("\n") == 1
    assert "more.pkl" in bad.out + bad.err


@pytest.mark.parametrize(
    "arguments",
    [
        ["library", "list", "--library", "nix"],
        ["library", "show", "hand-joystick", "--library", "nix"],
        ["library", "check", "nix"],
        ["library", "add", "nix"],
        ["learn", "car_game", "--demos", "nix", "-o", "l"],
    ],
)
def test_a_library_that_is_not_there(arguments, ichain, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = ichain(*arguments)
    assert (done.status, done.out) == (2, "")
    assert "nix" in done.line

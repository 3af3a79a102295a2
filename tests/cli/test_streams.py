"""Standard streams as they may be: nobody is told by a traceback, and the status is that of the work."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE

START = [sys.executable, "-m", "ichain_drake"]


def run(command: str, *arguments: str, **more: str) -> subprocess.CompletedProcess:
    """A shell command in which $@ is `ichain` with its arguments."""
    return subprocess.run(
        ["bash", "-c", command, "bash", *START, *arguments],
        capture_output=True, check=False, env=os.environ | {"COLUMNS": "100"} | more, timeout=PATIENCE,
    )  # fmt: skip


def test_a_full_stdout_is_one_line():
    done = run('"$@" > /dev/full', "graph", "car_game")
    assert done.returncode == 2
    assert done.stderr.decode().splitlines() == ["ichain: stdout: No space left on device; what was printed is lost"]


@pytest.mark.parametrize("closing", ['"$@" >&-', '"$@" >&- 2>&-', '"$@" <&- >&- 2>&-', '"$@" 2>/dev/full'])
def test_closed_streams_change_nothing(closing: str, tmp_path: Path):
    file = tmp_path / "graph.dot"
    done = run(closing, "graph", "car_game", "-o", str(file))
    assert (done.returncode, done.stderr) == (0, b"")
    assert file.read_text().startswith("digraph")  # and nothing that was printed is in it
    assert "written" not in file.read_text()


def test_a_reader_that_leaves_does_not_change_the_status():
    """The shell's status is that of `ichain`: bad input is 2 also where nobody reads on."""
    done = run('"$@" 2>&1 | head -0; exit ${PIPESTATUS[0]}', "graph", "nix")
    assert (done.returncode, done.stderr) == (2, b"")


def test_a_terminal_that_knows_ascii_alone():
    done = run('"$@"', "graph", "na\u00efve \U0001f916", PYTHONIOENCODING="ascii")
    assert done.returncode == 2
    (line,) = [text for text in done.stderr.splitlines() if not text.startswith(b"bash: ")]  # of its locale
    assert line.isascii() and line.startswith(b"ichain: there is no scenario")

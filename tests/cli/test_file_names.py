"""Names that no file can have, loops of links, pipes and other encodings, wherever a command takes a file."""

import os
import shutil
from pathlib import Path

import pytest

from ichain_drake.cli.main import main
from ichain_drake.demonstrations import read_folder
from ichain_drake.errors import InputError
from ichain_drake.learning.library import add_to_library

READ = [
    ["run", "car_game", "--physics", "ideal", "--demos"],
    ["run", "car_game", "--physics", "ideal", "--library"],
    ["run", "car_game", "--physics", "ideal", "--path"],
    ["run", "water_dispenser", "--physics", "ideal", "--demos"],
    ["plan", "kettle", "--demos"],
    ["plan", "kettle", "--library"],
    ["learn", "car_game", "-o", "library", "--demos"],
    ["library", "list", "--library"],
    ["library", "show", "a-b", "--library"],
    ["library", "check"],
    ["library", "add"],
    ["check"],
    ["play"],
]
WRITTEN = [
    ["run", "car_game", "--physics", "ideal", "-o"],
    ["teach", "car_game", "--physics", "ideal", "-o"],
]


@pytest.fixture
def names(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    os.mkfifo(tmp_path / "pipe.csv")
    return {"long": "x" * 300, "loop": str(tmp_path / "loop"), "pipe": str(tmp_path / "pipe.csv")}


@pytest.mark.parametrize("kind", ["long", "loop", "pipe"])
@pytest.mark.parametrize("command", [*READ, *WRITTEN], ids=lambda c: " ".join((c[0], c[-1])))
def test_is_one_line(command, kind, names, ichain, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = ichain(*command, names[kind])
    assert done.status == 2
    assert done.line


def test_a_piece_with_a_name_in_another_encoding(ichain, tmp_path):
    file = tmp_path / os.fsdecode(b"caf\xe9\n.csv")
    file.write_text("time,car.x\n0,1\n0.3333,2\n")
    (piece,) = read_folder(tmp_path)
    assert piece.name == r"caf\xe9\n.csv"
    done = ichain("check", tmp_path, "--page", tmp_path / "p.html", "--report", "-")
    assert done.status == 0
    assert r"caf\\xe9\\n.csv" in done.out
    assert r"caf\xe9\n.csv" in (tmp_path / "p.html").read_text()


def test_a_pipe_among_the_pieces_does_not_block(names, ichain, tmp_path):
    done = ichain("check", tmp_path)
    assert done.status == 2
    assert "it is a pipe or a device" in done.err


def test_a_link_is_no_library_to_add_to(tmp_path):
    folder = tmp_path / "demos"
    assert main(["teach", "car_game", "--physics", "ideal", "--set", "learning.samples=120", "-o", str(folder)]) == 0
    library = tmp_path / "lib"
    learn = ["learn", "car_game", "--demos", str(folder), "-o", str(library), "--set", "learning.samples=120"]
    assert main(learn) == 0
    part = library / "hand-joystick"
    before = {f.name: f.read_bytes() for f in part.iterdir()}
    with pytest.raises(InputError, match="it is a single link or graph; give the folder that it is in"):
        add_to_library(library, part)
    assert {f.name: f.read_bytes() for f in part.iterdir()} == before
    shutil.copytree(part, tmp_path / "other" / part.name)
    assert add_to_library(tmp_path / "other", library) == [part.name]

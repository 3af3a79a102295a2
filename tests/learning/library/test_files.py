"""Folders of a library: their names, what belongs there, and how they are replaced."""

import hashlib
from pathlib import Path

import pytest

from ichain_drake.errors import InputError
from ichain_drake.learning.library.files import (
    MANIFEST,
    graph_name,
    is_graph_name,
    is_item,
    is_weights_name,
    item_folders,
    library_entries,
    link_folder,
    link_folders,
    link_name,
    read_files,
    safe_name,
    sha256,
    write_files,
)

FILES = {MANIFEST: b"{}", "forward.npz": b"numbers"}


def test_names_are_plain_whatever_types_are_called() -> None:
    assert safe_name("cup_2") == "cup_2"
    assert safe_name("a-b/c.d") == "a%2db%2fc%2ed"
    assert safe_name("\u00e4") == "%c3%a4"
    assert link_name("robot hand", "cup") == "robot%20hand-cup"
    assert graph_name("water") == "graph.water"
    assert is_graph_name("graph.water") and is_graph_name(graph_name("a.b"))
    assert not is_graph_name("graph.") and not is_graph_name("hand-cup") and not is_graph_name("graph.a/b")
    for parent, child in (("", "cup"), ("hand", "")):
        with pytest.raises(InputError, match="an object type is empty; give both a type"):
            link_name(parent, child)
    with pytest.raises(InputError, match="a saved graph needs a name"):
        graph_name("")


@pytest.mark.parametrize(
    ("name", "plain"), [("forward.npz", True), ("../forward.npz", False), ("forward.npy", False), (".npz", False)]
)
def test_weights_are_plain_files_of_the_folder(name: str, *, plain: bool) -> None:
    assert is_weights_name(name) is plain


def test_what_is_written_comes_back_whole_and_replaces_what_was_there(tmp_path: Path) -> None:
    library = tmp_path / "deep" / "library"
    folder = write_files(library, "hand-cup", FILES)
    assert folder == library / "hand-cup"
    assert read_files(folder) == FILES
    assert is_item(folder) and not is_item(library)
    again = {MANIFEST: b"{1}"}
    write_files(library, "hand-cup", again)
    assert read_files(folder) == again, "nothing of the earlier one stays"
    assert [p.name for p in library.iterdir()] == ["hand-cup"], "nor anything beside it"
    with pytest.raises(InputError, match="it is a single link or graph; give the folder that it is in"):
        write_files(folder, "hand-cup", FILES)
    assert sha256(b"x") == hashlib.sha256(b"x").hexdigest()


def test_links_and_graphs_are_found_by_name_and_what_is_neither_is_told(tmp_path: Path) -> None:
    for name in ("hand-cup", "graph.water", "a-b"):
        write_files(tmp_path, name, FILES)
    (tmp_path / "README.md").write_text("notes")
    (tmp_path / ".git").mkdir()
    assert [f.name for f in item_folders(tmp_path)] == ["a-b", "graph.water", "hand-cup"]
    assert [f.name for f in link_folders(tmp_path)] == ["a-b", "hand-cup"]
    assert link_folder(tmp_path, "graph.water") == tmp_path / "graph.water"
    with pytest.raises(InputError, match="it has no link 'x-y'; it has a-b, graph.water, hand-cup"):
        link_folder(tmp_path, "x-y")
    with pytest.raises(InputError, match="'../a-b' is no link's name"):
        link_folder(tmp_path, "../a-b")
    (tmp_path / "odd.py").write_text("")
    found, foreign = library_entries(tmp_path)
    assert len(found) == 3
    assert foreign == [f"library {tmp_path}: odd.py is no part of a library and is not opened; remove it"]
    with pytest.raises(InputError, match="odd.py is no part of a library"):
        item_folders(tmp_path)
    with pytest.raises(InputError, match="it is a single link; give the folder that it is in"):
        item_folders(tmp_path / "a-b")
    with pytest.raises(InputError, match="can't be read as a folder"):
        item_folders(tmp_path / "none")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="it has no link 'x-y'; it has none"):
        link_folder(tmp_path / "empty", "x-y")


def test_a_link_is_a_manifest_and_arrays(tmp_path: Path) -> None:
    folder = write_files(tmp_path, "hand-cup", FILES)
    (folder / "more.txt").write_text("")
    with pytest.raises(InputError, match="more.txt: is no part of a link and is not opened"):
        read_files(folder)
    (folder / "more.txt").unlink()
    (folder / "inner").mkdir()
    with pytest.raises(InputError, match="inner: is no ordinary file"):
        read_files(folder)
    (folder / "inner").rmdir()
    (folder / MANIFEST).unlink()
    with pytest.raises(InputError, match=f"holds no {MANIFEST}, so it is no saved link"):
        read_files(folder)

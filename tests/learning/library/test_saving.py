"""What can not be saved leaves what was saved before."""

import os
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from full_disk import room_for
from linked_library import CHAIN, EDGE, HAND, HASH, LINK

from ichain_drake.errors import InputError
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.library import (
    LearnedCommand,
    check_library,
    save_chain,
    save_link,
    show_link,
)


def contents(folder: Path) -> dict[Path, bytes]:
    return {file.relative_to(folder): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def test_what_can_not_be_saved_leaves_the_earlier_link(library: Path) -> None:
    link, before = CHAIN.links[0], contents(library)
    nan = replace(link, child_limit=np.array([1.0, np.nan]))
    with pytest.raises(InputError, match=r"hand->stick of me can't be saved: child_limit\[1\]: nan can't stand here"):
        save_link(nan, library, "me", HASH)
    with pytest.raises(InputError, match="can't be saved: demonstrations_sha256: 'today'"):
        save_link(link, library, "me", "today")
    spec = replace(link.forward.spec, estimator=EstimatorSpec("polynomial", {"alphas": np.ones(2)}))
    with pytest.raises(InputError, match="its parameters must be plain values"):
        save_link(replace(link, forward=replace(link.forward, spec=spec)), library, "me", HASH)
    other = replace(link.inverses[0], model=replace(link.inverses[0].model, targets=(0,)))
    with pytest.raises(InputError, match="its inverse models have 2 sets of targets"):
        save_link(replace(link, inverses=(*link.inverses, other)), library, "me", HASH)
    with pytest.raises(InputError, match="hand->stick and b->c are between the same types of objects"):
        again = replace(link, interaction=replace(EDGE, parent="b", child="c"))
        save_chain(replace(CHAIN, links=(link, again)), library, "me", HASH)
    bad = LearnedCommand(None, np.zeros(2), np.zeros(2), np.array([0.0, np.inf]))
    with pytest.raises(InputError, match=r"command.hand_limit\[1\]: inf can't"):
        save_link(link, library, "me", HASH, bad)
    assert contents(library) == before


def test_a_full_folder_is_refused_and_the_earlier_link_stays(library: Path) -> None:
    before = contents(library)
    said = r"library: hand-joystick can't be written \(File too large\)"
    with room_for(3000), pytest.raises(InputError, match=said) as caught:
        save_chain(CHAIN, library, "another", HASH)
    assert "\n" not in str(caught.value)
    assert contents(library) == before
    assert [entry.name for entry in library.iterdir()] == [LINK]


def test_a_read_only_folder_is_refused(library: Path) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o555)
        root = os.geteuid() == 0
        if root:  # whom permissions don't stop
            os.seteuid(65534)
        try:
            with pytest.raises(InputError, match=r"hand-joystick can't be written \(Permission denied\)"):
                save_chain(CHAIN, folder, "a test", HASH)
            with pytest.raises(InputError, match=r"hand-joystick can't be written \(Permission denied\)"):
                save_chain(CHAIN, folder / "inner", "a test", HASH)
        finally:
            if root:
                os.seteuid(0)
        assert list(folder.iterdir()) == []
    (library / "file").write_text("")
    with pytest.raises(InputError, match=r"can't be written \(.*(File exists|Not a directory)"):
        save_chain(CHAIN, library / "file", "a test", HASH)


def test_only_a_saved_link_is_replaced(tmp_path: Path) -> None:
    (tmp_path / LINK).mkdir()
    (tmp_path / LINK / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="something that is no saved link is in its place"):
        save_chain(CHAIN, tmp_path, "a test", HASH)
    assert list(contents(tmp_path)) == [Path(LINK) / "notes.txt"]
    (tmp_path / LINK / "notes.txt").unlink()
    save_chain(CHAIN, tmp_path, "a test", HASH)
    assert check_library(tmp_path) == []


@pytest.mark.parametrize("kind", ["../../outside", "/etc", "..", "a b", "hand-x", "\N{SNOWMAN}", "a\0b"])
def test_types_never_lead_out_of_the_library(tmp_path: Path, kind: str) -> None:
    link, hand = CHAIN.links[0], replace(HAND, type=kind)
    forward = replace(link.forward, model=replace(link.forward.model, parent_space=hand))
    folder = save_link(replace(link, forward=forward), tmp_path / "a" / "b", "a test", HASH)
    assert folder.resolve().parent == (tmp_path / "a" / "b").resolve()
    assert [entry.name for entry in tmp_path.iterdir()] == ["a"]
    assert show_link(tmp_path / "a" / "b", folder.name).parent.startswith(f"{kind}: ")
    with pytest.raises(InputError, match="an object type is empty"):
        forward = replace(forward, model=replace(forward.model, parent_space=replace(HAND, type="")))
        save_link(replace(link, forward=forward), tmp_path, "a test", HASH)

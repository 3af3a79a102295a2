"""Files with hostile names and kinds are one line; files of ours are whole or not there."""

import os
from pathlib import Path

import pytest

from ichain_drake.errors import InputError
from ichain_drake.files import check_folder, held, is_folder, read_whole, shown, unused_folder, write_whole


def test_a_pipe_does_not_block_and_a_device_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "p.csv")
    for file in (tmp_path / "p.csv", Path("/dev/zero"), tmp_path):
        with pytest.raises(InputError, match="can't read the log: "):
            read_whole(file, "the log")


@pytest.mark.parametrize("name", ["x" * 300, "nul\0byte", "loop", "none"])
def test_names_that_can_not_be(name: str, tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    file = tmp_path / name
    with pytest.raises(InputError, match="can't read the log: "):
        read_whole(file, "the log")
    with pytest.raises(InputError):
        check_folder(file, "demonstrations")
    assert not is_folder(file)
    if name not in ("none", "loop"):
        with pytest.raises(InputError, match="can't write"):
            write_whole(file, b"")


def test_a_large_file_is_refused_unread(tmp_path: Path) -> None:
    with (tmp_path / "a").open("wb") as stream:
        stream.truncate(2**40)  # a hole: it takes no room
    with pytest.raises(InputError, match="1099512 MB, and 268 are read at most"):
        read_whole(tmp_path / "a", "the log")


def test_a_name_in_another_encoding_can_be_shown(tmp_path: Path) -> None:
    file = tmp_path / os.fsdecode(b"caf\xe9.csv")
    assert shown(file) == r"caf\xe9.csv"
    shown(file).encode()
    assert shown(tmp_path / "a\n\x1b[2Jb") == r"a\n\x1b[2Jb"


def test_a_new_file_never_replaces(tmp_path: Path) -> None:
    write_whole(tmp_path / "a", b"one", new=True)
    with pytest.raises(InputError, match="is there already and is not overwritten"):
        write_whole(tmp_path / "a", b"two", new=True)
    assert (tmp_path / "a").read_bytes() == b"one"
    write_whole(tmp_path / "a", b"three")
    assert [f.name for f in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"three"


def test_a_file_system_without_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError("no links here")

    monkeypatch.setattr(os, "link", refuse)
    write_whole(tmp_path / "a", b"one", new=True)
    with pytest.raises(InputError, match="is there already"):
        write_whole(tmp_path / "a", b"two", new=True)
    assert (tmp_path / "a").read_bytes() == b"one"


def test_one_writer_a_folder(tmp_path: Path) -> None:
    with held(tmp_path), pytest.raises(InputError, match="another run writes there now"), held(tmp_path):
        pass
    with held(tmp_path):
        pass


def test_folders_are_numbered_on(tmp_path: Path) -> None:
    assert unused_folder(tmp_path / "d") == tmp_path / "d"
    (tmp_path / "d").mkdir()
    assert unused_folder(tmp_path / "d") == tmp_path / "d"
    (tmp_path / "d" / "x").touch()
    assert unused_folder(tmp_path / "d") == tmp_path / "d-2"

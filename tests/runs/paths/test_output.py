"""Reports are whole or not there; devices and pipes are written into, never replaced."""

import json
import os
import threading
from pathlib import Path

import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs.paths.output import prepare_file, prepare_folder, write_report


def test_a_report_replaces_an_old_one_and_leaves_nothing_beside(tmp_path: Path):
    file = tmp_path / "report.json"
    file.write_text("old")
    write_report({"a": 1.5, "b": None}, file)
    assert json.loads(file.read_text()) == {"a": 1.5, "b": None}
    assert list(tmp_path.iterdir()) == [file]


def test_a_value_that_is_no_json_is_refused_and_the_old_report_kept(tmp_path: Path):
    file = tmp_path / "report.json"
    file.write_text("old")
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_report({"a": float("nan")}, file)
    assert file.read_text() == "old"


def test_a_pipe_is_written_into(tmp_path: Path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    got: list[str] = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_text()))
    reader.start()
    prepare_file(pipe)
    write_report({"a": 1}, pipe)
    reader.join(10)
    assert json.loads(got[0]) == {"a": 1}
    assert pipe.is_fifo()


def test_a_link_is_written_through(tmp_path: Path):
    link, target = tmp_path / "link.json", tmp_path / "target.json"
    link.symlink_to(target)
    write_report({"a": 1}, link)
    assert link.is_symlink() and json.loads(target.read_text()) == {"a": 1}


def test_what_can_t_be_written_is_refused(tmp_path: Path):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match="Not a directory"):
        prepare_folder(tmp_path / "file" / "deep")
    with pytest.raises(InputError, match="is a folder"):
        prepare_file(tmp_path / "folder")
    with pytest.raises(InputError, match="can't write"):
        write_report({}, tmp_path / "nowhere" / "report.json")
    prepare_file(tmp_path / "new" / "deep" / "report.json")
    assert list((tmp_path / "new" / "deep").iterdir()) == []

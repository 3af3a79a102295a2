"""Options of `teach` and `run` that are about a browser, where they don't fit."""

import pytest

from ichain_drake.cli.main import main


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["teach", "car_game", "--drive", "hand", "-o", "x"], "--drive is for --browser"),
        (["teach", "car_game", "--browser", "--drive", "car", "-o", "x"], "nobody can drive 'car'"),
        (["run", "car_game", "--realtime"], "--realtime is for --meshcat"),
    ],
)
def test_one_line_says_what_is_wrong(arguments, expected, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert expected in line

"""Bad command lines made by chance: each ends with status 2 and exactly one line, before anything is recorded.

A few dozen run here; ICHAIN_BAD_INPUTS=1000 asks for as many.
"""

import os
import random
from pathlib import Path

import bad_files
import bad_words
import pytest

from ichain_drake.scenarios.base import Scenario
from ichain_drake.systems import SCENARIOS

COUNT = int(os.environ.get("ICHAIN_BAD_INPUTS", "48"))
MAKERS = (*bad_words.MAKERS, *bad_files.MAKERS)


@pytest.fixture(autouse=True)
def nothing_is_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Scenario, *arguments: object) -> None:
        raise AssertionError("something was recorded")

    for kind in SCENARIOS.values():
        monkeypatch.setattr(kind, "record_demonstrations", fail)


@pytest.mark.parametrize("number", range(COUNT))
def test_one_line_and_status_2(number: int, ichain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    rng = random.Random(number)
    arguments = MAKERS[number % len(MAKERS)](rng, tmp_path)
    done = ichain(*arguments)
    assert done.status == 2, (arguments, done)
    if arguments[:1] not in ([], ["library"]) or len(arguments) > 1:  # those print their help
        assert done.line.isprintable(), (arguments, done)
        assert len(done.line) < 2500, (arguments, done)
        assert "not foreseen" not in done.line, (arguments, done)
    assert not list(tmp_path.glob("out/*/*.parquet"))

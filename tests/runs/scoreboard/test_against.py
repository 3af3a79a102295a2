"""What is beyond chance is called so, and nothing else."""

import json

import numpy as np
import pytest
from scipy.stats import fisher_exact

from ichain_drake.errors import InputError
from ichain_drake.runs.scoreboard.against import LEVEL, compare, holm, read_scoreboard


def table(**rows):
    return [{"row": name, "reached": reached, "runs": runs} for name, (reached, runs) in rows.items()]


def test_a_row_that_fell_is_a_loss_and_one_that_rose_a_gain():
    found = compare(
        table(a=(20, 20), b=(2, 20), c=(10, 20), old=(1, 1)), table(a=(4, 20), b=(19, 20), c=(9, 20), d=(1, 1))
    )
    assert [c.row for c in found.worse] == ["a"]
    assert [c.row for c in found.better] == ["b"]
    assert (found.gone, found.new) == (("old",), ("d",))
    assert found.worse[0].words().startswith("a: 20/20 -> 4/20 (p ")
    assert found.worse[0].p == pytest.approx(fisher_exact([[20, 0], [4, 16]]).pvalue)


def test_rows_are_corrected_for_their_number():
    one = compare(table(a=(20, 20)), table(a=(14, 20)))
    assert one.worse
    many = {f"r{k}": (20, 20) for k in range(40)}
    found = compare(table(a=(20, 20), **many), table(a=(14, 20), **many))
    assert not found.worse
    assert found.changes[0].row == "a"
    assert found.changes[0].p < LEVEL < found.changes[0].adjusted


def test_holm():
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])  # Holm 1979, by hand
    assert holm([]) == []
    assert holm([0.9, 0.8]) == [1.0, 1.0]


def test_no_change_is_called_one_more_often_than_the_level():
    rng = np.random.default_rng(5)
    wrong = 0
    for _ in range(200):
        before, after = ({f"r{k}": (int(n), 20) for k, n in enumerate(rng.binomial(20, 0.8, 30))} for _ in range(2))
        found = compare(table(**before), table(**after))
        wrong += bool(found.worse or found.better)
    assert wrong <= 200 * LEVEL * 1.5


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{", "is no complete JSON"),
        ("[]", "is no scoreboard"),
        (json.dumps({"rows": []}), "is no scoreboard"),
        (json.dumps({"table": [{"row": "a", "reached": 3, "runs": 2}]}), "is no scoreboard"),
        (json.dumps({"table": [{"row": "a", "reached": "3", "runs": 2}]}), "is no scoreboard"),
        (None, "can't read the earlier scoreboard"),
    ],
)
def test_what_is_no_scoreboard(content, message, tmp_path):
    file = tmp_path / "earlier.json"
    if content is not None:
        file.write_text(content)
    with pytest.raises(InputError, match=message):
        read_scoreboard(file)

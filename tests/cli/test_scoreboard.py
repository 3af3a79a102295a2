"""`ichain scoreboard`: one table, the same after an interruption, and a status that says whether something was lost."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from interrupting import STATUS, errors, interrupt

from ichain_drake.rules import RULES

ROOT = Path(__file__).parents[2]
BATH = str(ROOT / "examples" / "own_system" / "bath.py")
SEED = 30_000  # of a board on which every trial succeeds; how many do on others is for the scoreboard itself to say
ONLY = ["scoreboard", "--also", BATH, "--only", "bath/*", "--seed", str(SEED)]
TIMES = ("learning_seconds", "plan_seconds", "wall_seconds", "date")


def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items() if k not in TIMES}
    return [without_times(v) for v in value] if isinstance(value, list) else value


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """Two trials of each of the bath's rows, by two processes."""
    file = tmp_path_factory.mktemp("scoreboard") / "board.json"
    command = [sys.executable, "-m", "ichain_drake", *ONLY, "--trials", "2", "--jobs", "2", "--report", str(file)]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=os.environ | {"OMP_NUM_THREADS": "1"}
    )
    assert done.returncode == 0, done.stderr
    assert "Wilson's 95 % interval" in done.stdout
    assert "2/2 (.34-1.00)" in done.stdout
    return file


def test_the_report(whole, strict_json):
    report = strict_json(whole.read_text())
    assert [line["row"] for line in report["table"]] == ["bath/goal/ideal/none", "bath/goal/ideal/noise"]
    assert report["reason"] == "every trial was run"
    assert [(r["row"], r["seed"]) for r in report["rows"]] == [
        (line["row"], seed) for line in report["table"] for seed in (SEED, SEED + 1)
    ]
    assert all(r["demonstrations"] == "fresh" for r in report["rows"])
    assert report["command"] == f"ichain scoreboard --trials 2 --seed {SEED} --only 'bath/*' --also {BATH}"
    assert {"python", "ichain_drake", "drake"} <= set(report["versions"])
    line = report["table"][0]
    assert line["learning_seconds"] > 0
    assert line["wall_seconds"] > line["learning_seconds"]


def test_interrupted_and_gone_on_with_it_is_the_same_table(whole, tmp_path, ichain):
    file = tmp_path / "board.json"
    arguments = [*ONLY, "--trials", "2", "--trial-timeout", "600", "--report", str(file)]  # so each seed is by itself
    status, out, err = interrupt(arguments, at="2 of 4")
    assert status == STATUS, err
    assert errors(err) == ["ichain: interrupted"]
    part = json.loads(file.read_text())
    assert part["reason"] == "interrupted"
    assert {r["seed"] for r in part["rows"]} == {SEED}
    assert "1/1" in out
    done = ichain(*arguments, "--resume")
    assert done.status == 0
    assert "2 of 4 were done before" in done.err
    found, expected = (without_times(json.loads(f.read_text())) for f in (file, whole))
    assert found["table"] == expected["table"]
    assert found["rows"] == expected["rows"]
    # And with nothing left to do.
    assert ichain(*arguments, "--resume").status == 0
    assert without_times(json.loads(file.read_text())) == found
    other = ichain(*arguments, "--resume", "--seed", 5)
    assert other.status == 2
    assert f"rows are of another evaluation (first_seed: {SEED}, now 5)" in other.line


def test_against_an_earlier_one(whole, tmp_path, ichain):
    rows = whole.with_name("board.rows.jsonl").read_text()
    (tmp_path / "board.rows.jsonl").write_text(rows)
    again = [*ONLY, "--trials", "2", "--resume", "--report", str(tmp_path / "board.json"), "--against"]
    done = ichain(*again, whole)
    assert done.status == 0
    assert "2 rows compared: 0 better, 0 worse beyond chance" in done.out
    report = json.loads(whole.read_text())
    report["table"][0] |= {"reached": 900, "runs": 900}
    (tmp_path / "better.json").write_text(json.dumps(report))
    # Two of two now: no loss. Two failures of two are one.
    assert ichain(*again, tmp_path / "better.json").status == 0
    lines = [json.loads(line) for line in rows.splitlines()]
    for line in lines[1:]:
        line["found"]["success"] = False
    (tmp_path / "board.rows.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    lost = ichain(*again, tmp_path / "better.json")
    assert lost.status == 1
    assert "worse: bath/goal/ideal/none: 900/900 -> 0/2" in lost.out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--only", "nix/*"], "no row is called so"),
        (["--trials", "0"], "give numbers from 1"),
        (["--jobs", "0"], "give numbers from 1"),
        (["--seed", "-1"], "give a whole number from 0"),
        (["--against", "nowhere.json"], "can't read the earlier scoreboard"),
        (["--also", "nowhere.py"], "there is no such file"),
        (["--without", "magic"], "there is no rule 'magic'"),
        (["--report", "/dev/null/board.json"], "can't"),
    ],
)
def test_wrong_options_are_refused_before_any_work(options, message, ichain):
    done = ichain("scoreboard", *options)
    assert done.status == 2
    assert message in done.line
    assert done.err.count("\n") == 1


def test_rows_without_each_rule_stand_below_the_table(tmp_path, ichain):
    off = [name for name in RULES if name not in ("deviation", "detour")]
    options = [x for name in off for x in ("--without", name)]
    report = tmp_path / "rules.json"
    only = ["--only", "bath/goal/ideal/none", "--trials", "1", "--ablate", *options, "--report", str(report)]
    done = ichain("scoreboard", "--also", BATH, "--seed", str(SEED), *only)
    assert done.status == 0, done.err
    assert "rows that need it" in done.out
    found = json.loads(report.read_text())
    assert [line["rule"] for line in found["ablation"]] == ["deviation", "detour"]
    assert [(line["pairs"], line["lost"]) for line in found["ablation"]] == [(1, 0)] * 2
    assert [line["runs"] for line in found["table"]] == [1]
    complete = next(row for row in found["rows"] if not row["without"])
    assert [(line["runs"], line["predicted"], line["reached"]) for line in found["predicted"]] == [
        (1, round(complete["probability"], 4), int(complete["success"]))
    ]
    assert 0.5 < complete["probability"] <= 1.0
    assert "what the first plan of each run towards a goal said of its success" in done.out


def test_rules_are_listed(ichain):
    done = ichain("scoreboard", "--rules")
    assert done.status == 0
    assert all(name in done.out for name in RULES)

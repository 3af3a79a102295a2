"""`ichain evaluate` on a graph of one's own: rows, two tables, a report; nothing in it knows a scenario."""

import json
from pathlib import Path

import pytest
from lamp import LampScenario

import ichain_drake as ic
from ichain_drake.cli.main import main
from ichain_drake.systems import SCENARIOS

ROW = {
    "method", "physics", "case", "seed", "success", "error", "reason", "cause", "silent", "control_steps", "replans",
    "probability", "pieces", "demonstrations",
}  # fmt: skip


class WantedLamp(LampScenario):
    """With a goal of its own."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.config = ic.ScenarioConfig()
        self.config.goal = ["0.55 <= lamp.light <= 0.65"]


@pytest.fixture
def lamp(monkeypatch):
    monkeypatch.setitem(SCENARIOS, "lamp", WantedLamp)


def test_rows_tables_and_report(lamp, capfd, tmp_path: Path):
    methods = "monitors/none,pieces/6 pieces,classifiers"
    file = tmp_path / "report.json"
    arguments = ["evaluate", "lamp", "--physics", "ideal", "--trials", "1", "--methods", methods]
    assert main([*arguments, "--report", str(file)]) == 0
    report = json.loads(file.read_text(), parse_constant=pytest.fail)
    assert {"scenario", "physics", "seed", "trials", "goal", "versions", "given", "rows", "table"} <= set(report)
    rows = report["rows"]
    assert all(set(row) == ROW for row in rows)
    assert [(r["method"], r["case"], r["pieces"]) for r in rows] == [
        ("monitors", "none", 9),
        ("pieces", "6 pieces", 6),
    ]
    assert rows[0]["success"], rows[0]["reason"]
    assert all(bool(row["reason"]) != row["success"] for row in rows)
    assert [line["interaction"] for line in report["classifiers"]] == [e.name for e in LampScenario.graph.interactions]
    assert all(line["events"] >= 40 and line["near_misses"] is None for line in report["classifiers"])
    assert report["held_out"]["seeds"] == list(range(1, 1 + len(report["held_out"]["seeds"])))
    shown = capfd.readouterr().out
    assert "causes of failure" in shown
    assert "switching F1" in shown
    assert "hand->dimmer" in shown


def test_a_scenario_without_a_goal_of_its_own_is_refused(monkeypatch, capfd):
    monkeypatch.setitem(SCENARIOS, "lamp", LampScenario)
    assert main(["evaluate", "lamp", "--physics", "ideal"]) == 2
    assert capfd.readouterr().err == "ichain: lamp has no goal of its own to evaluate; set one in its file\n"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--methods", "magic"], "there is no method 'magic'; there are monitors"),
        (["--trials", "0"], "give numbers from 1"),
        (["--report", "/dev/null/report.json"], "can't"),
    ],
)
def test_wrong_options_are_refused_before_any_work(options, message, lamp, capfd):
    assert main(["evaluate", "lamp", "--physics", "ideal", *options]) == 2
    line = capfd.readouterr().err
    assert line.count("\n") == 1
    assert message in line


def test_fresh_trials_beside_those_that_share_demonstrations(lamp, capfd, tmp_path: Path):
    file = tmp_path / "report.json"
    asked = [
        "evaluate",
        "lamp",
        "--physics",
        "ideal",
        "--methods",
        "monitors/none",
        "--report",
        str(file),
        "--seed",
        "4",
    ]
    assert main([*asked, "--trials", "1", "--fresh", "--shared"]) == 0
    report = json.loads(file.read_text(), parse_constant=pytest.fail)
    fresh, shared = report["rows"]
    assert set(shared) == ROW
    assert set(fresh) == ROW | {"learning_seconds", "plan_seconds", "wall_seconds"}
    assert (fresh["demonstrations"], fresh["seed"]) == ("fresh", 4)
    assert (shared["demonstrations"], shared["seed"]) == ("seed 4", 0)
    assert fresh["wall_seconds"] > fresh["learning_seconds"] > 0
    assert [(line["demonstrations"], line["seeds"]) for line in report["table"]] == [("fresh", "4"), ("seed 4", "0")]
    assert "1/1 (.21-1.00)" in capfd.readouterr().out
    assert report["command"] == (
        "ichain evaluate lamp --physics ideal --seed 4 --trials 1 --methods monitors/none --fresh --shared"
    )
    assert "1/1 (.21-1.00)" in report["text"]
    # The first trial is known; the second has demonstrations of the next seed.
    assert main([*asked, "--trials", "2", "--fresh", "--resume"]) == 0
    more = json.loads(file.read_text())["rows"]
    assert more[0] == fresh
    assert [row["seed"] for row in more] == [4, 5]
    assert "1 of 2 were done before" in capfd.readouterr().err
    assert main([*asked[:-1], "5", "--fresh", "--resume"]) == 2
    assert "rows are of another evaluation (seed: 4, now 5)" in capfd.readouterr().err


def test_resume_needs_a_report_to_go_on_from(lamp, capfd):
    assert main(["evaluate", "lamp", "--physics", "ideal", "--resume"]) == 2
    assert capfd.readouterr().err == (
        "ichain: --resume goes on from the rows beside a report: name it with --report FILE\n"
    )

"""Figures of what was found out of states."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import bath_log
import numpy as np
import pytest

from ichain_drake.cli.evaluate_discovery import format_discovery
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning.discovery.search import FoundEdge
from ichain_drake.runs import discovery
from ichain_drake.runs.discovery_scores import cut_scores, edge_scores, one_recording_each, scores, summary
from ichain_drake.systems import load_scenario
from ichain_drake.timing import TICK

BATH = Path(__file__).parents[2] / "examples" / "own_system" / "bath.py"
PIECES = bath_log.pieces(2)


def found(parent: str, child: str, *, lag: int = 0) -> FoundEdge:
    """An edge with true flags (of the tap's where it isn't one), so many rows late."""
    edge = Interaction(parent, child)
    column = edge.name if edge.name in PIECES[0].table else "lever->tank"
    on = {p.name: np.roll(p.table[column].to_numpy() > 0.5, lag) for p in PIECES}
    return FoundEdge(edge, 1.0, 1.0, 1, (), (), on, {n: np.zeros(len(f), bool) for n, f in on.items()}, False)


def test_what_is_right_scores_one() -> None:
    row = scores([found("hand", "lever"), found("lever", "tank")], PIECES, bath_log.GRAPH)
    assert row["shd"] == 0
    assert all(set(f.values()) == {1.0} for f in row["flags"].values())


@pytest.mark.parametrize(
    ("edges", "shd", "missing", "extra"),
    [
        ([("hand", "lever")], 1, ["lever->tank"], []),
        ([("hand", "lever"), ("tank", "lever")], 1, ["lever->tank"], ["tank->lever"]),  # turned
        ([("hand", "lever"), ("hand", "tank")], 2, ["lever->tank"], ["hand->tank"]),
    ],
)
def test_distance_counts_what_is_missing_and_added(
    edges: list[tuple[str, str]], shd: int, missing: list[str], extra: list[str]
) -> None:
    row = scores([found(*e) for e in edges], PIECES, bath_log.GRAPH)
    assert (row["shd"], row["missing"], row["extra"]) == (shd, missing, extra)
    assert row["flags"]["lever->tank"]["all"] == 0.0


def test_late_flags_lose_rows_but_no_switchings() -> None:
    flags = scores([found("hand", "lever", lag=1)], PIECES, bath_log.GRAPH)["flags"]["hand->lever"]
    assert flags["all"] < 1.0
    assert flags["switchings"] == 1.0


def test_a_line_sums_over_seeds() -> None:
    rows = [
        {"reason": "", "seconds": 1.0, **scores([found(*e) for e in edges], PIECES, bath_log.GRAPH)}
        for edges in ([("hand", "lever"), ("lever", "tank")], [("hand", "lever"), ("hand", "tank")])
    ]
    line = summary("edges", [*rows, {"reason": "no pieces"}])
    assert (line["seeds"], line["failed"], line["exact"]) == (3, 1, 1)
    assert line["recall"] == pytest.approx(3 / 4)
    assert line["precision"] == pytest.approx(3 / 4)
    assert line["mean_shd"] == 1.0


def test_edges_alone_have_no_flags() -> None:
    row = edge_scores({Interaction("hand", "lever"), Interaction("tank", "lever")}, bath_log.GRAPH)
    assert (row["shd"], row["missing"], row["flags"]) == (1, ["lever->tank"], {})
    assert row["extra"] == ["tank->lever"]  # turned


def test_a_cut_counts_within_one_row_and_once() -> None:
    row = cut_scores([[10, 19, 20, 22, 31], []], [[10, 20, 30], [7]])
    assert row["missing"] == ["recording1/7"]
    assert row["extra"] == ["recording0/19", "recording0/22"]
    assert (row["true"], row["shd"]) == (4, 3)
    line = summary("cuts", [{"reason": "", "seconds": 1.0, **row}])
    assert (line["recall"], line["precision"]) == (pytest.approx(3 / 4), pytest.approx(3 / 5))
    assert line["f1_all"] is None


def test_pieces_of_the_same_columns_are_one_recording() -> None:
    other = [replace(p, table=p.table.drop(columns=["tank.level"])) for p in PIECES]
    logs, resets = one_recording_each([PIECES[0], other[0], PIECES[1]])
    assert [len(log) for log in logs] == [len(PIECES[0]) + len(PIECES[1]), len(PIECES[0])]
    assert resets == [[len(PIECES[0])], []]
    assert not any("->" in c for log in logs for c in log.table.columns)
    assert np.allclose(np.diff(logs[0].table["time"]), TICK)


def test_an_edge_that_was_not_found_scores_nothing_and_one_that_no_piece_flags_all() -> None:
    assert scores([], PIECES, bath_log.GRAPH)["flags"]["hand->lever"] == {"all": 0.0, "shown": 0.0, "switchings": 0.0}
    bare = [replace(p, table=p.table.drop(columns="hand->lever")) for p in PIECES]
    flags = scores([found("hand", "lever")], bare, bath_log.GRAPH)["flags"]["hand->lever"]
    assert flags == {"all": 1.0, "shown": 1.0, "switchings": 1.0}


def test_rows_in_which_nothing_shows_count_for_all_rows_alone() -> None:
    late = found("hand", "lever", lag=1)
    wrong = {p.name: late.on[p.name] != (p.table["hand->lever"].to_numpy() > 0.5) for p in PIECES}
    flags = scores([replace(late, open=wrong)], PIECES, bath_log.GRAPH)["flags"]["hand->lever"]
    assert flags["all"] < 1.0
    assert flags["shown"] == 1.0


def test_labels_know_the_graph_and_edges_do_not(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr(discovery, "search", lambda *given: asked.append(f"labels of {len(given[3])} edges") or [])
    nothing = SimpleNamespace(found=[])
    monkeypatch.setattr(discovery, "discover_graph", lambda *given: asked.append("edges") or nothing)
    kind = lambda *given: SimpleNamespace(  # noqa: E731 - a scenario's class
        record_demonstrations=lambda: PIECES, graph=bath_log.GRAPH
    )
    trial = discovery.DiscoveryTrial(kind, (), "ideal", 7, ("labels", "edges"))  # type: ignore[arg-type]
    rows = dict(trial.run(trial.ids))
    assert asked == ["labels of 2 edges", "edges"]
    assert list(rows) == ["labels/7", "edges/7"]
    assert [r["method"] for r in rows.values()] == ["labels", "edges"]
    assert all(r["shd"] == 2 for r in rows.values())


def test_a_task_is_run_from_states_alone_and_from_true_flags() -> None:
    scenario = load_scenario(str(BATH), [], "ideal", 70300)
    trial = discovery.DiscoveryTrial(type(scenario), (), "ideal", 70300, ("task",))
    ((name, row),) = trial.run(trial.ids)
    assert name == "task/70300"
    assert (row["shd"], row["reached"], row["why"], row["reached_with_flags"]) == (0, True, "", True)
    line = summary("task", [row, row | {"reached": False}])
    assert (line["reached"], line["reached_with_flags"], line["exact"]) == (1, 2, 2)
    assert summary("edges", [{k: row[k] for k in row if "reached" not in k}])["reached"] is None


def test_a_task_that_can_not_be_learned_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(run: object, known: object = None) -> None:
        if known is None:
            raise InputError("tap: the pieces don't show that anything acts on it")

    monkeypatch.setattr(discovery, "run_graph", nothing)
    monkeypatch.setattr(discovery, "own_goal", lambda scenario: ("tank.level >= 0.5",))
    monkeypatch.setattr(discovery, "learn", lambda *given: "model")
    run = SimpleNamespace(labels=None, goal_reached=True, reason="")
    monkeypatch.setattr(discovery, "GraphRun", lambda *given, **more: run)
    row = discovery._task(PIECES, SimpleNamespace(graph=bath_log.GRAPH))
    assert (row["reached"], row["shd"], row["reached_with_flags"]) == (False, 2, True)
    assert "anything acts on it" in row["why"]
    table = format_discovery(
        SimpleNamespace(name="bath", physics="ideal"),  # type: ignore[arg-type]
        {"rows": [row | {"seed": 7, "method": "task", "reason": ""}],
         "table": [summary("task", [row | {"reason": "", "seconds": 1.0}])]},
    )  # fmt: skip
    assert "seed 7, task: missing hand->lever, missing lever->tank, tap: the pieces" in table


def test_paths_have_no_task() -> None:
    scenario = load_scenario("car_game", [], "ideal", 1)
    what = discovery.DiscoveryEvaluation(scenario, (), 1, ("edges", "task"))
    with pytest.raises(InputError, match="car_game follows paths: task is for systems with a goal"):
        what.check()

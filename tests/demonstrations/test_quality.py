"""What teaches wrongly is found, and good pieces are left in peace."""

import itertools
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.demonstrations.column_noise import column_noise
from ichain_drake.demonstrations.overview import inferred_graph, overview, overview_page, overview_text
from ichain_drake.demonstrations.quality import Finding, findings
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

GRAPH = InteractionGraph(
    {
        "arm": StateSpace("arm", (Variable("x", "m", role=Role("position", "table", "x")),)),
        "cup": StateSpace("cup", (Variable("x", "m", role=Role("position", "table", "x")), Variable("warm"))),
    },
    ["arm->cup"],
)


def piece(name: str, seed: int, noise: float = 0.001, rows: int = 80) -> Demonstration:
    """An arm goes to and fro, and carries the cup in the middle third."""
    rng = np.random.default_rng(seed)
    t = np.arange(rows)
    arm = 0.3 * np.sin(0.15 * t + seed)
    on = (t >= rows // 3) & (t < 2 * rows // 3)
    cup = np.where(on, arm, np.where(t < rows // 3, arm[rows // 3], arm[2 * rows // 3]))
    data = {"arm.x": arm, "cup.x": cup, "cup.warm": 0.2 + 0.01 * t}
    data = {k: v + noise * rng.standard_normal(rows) for k, v in data.items()}
    return Demonstration(pd.DataFrame({"time": TICK * t, **data, "arm->cup": on.astype(float)}), {}, name)


GOOD = [piece(f"p{i}", i) for i in range(4)]


def changed(index: int, **columns: object) -> list[Demonstration]:
    out = list(GOOD)
    out[index] = replace(out[index], table=out[index].table.assign(**columns))
    return out


def only(found: list[Finding]) -> Finding:
    assert len(found) == 1, [str(f) for f in found]
    return found[0]


def test_good_pieces_have_nothing_odd() -> None:
    assert findings(GOOD, GRAPH) == []
    assert findings([piece(f"p{i}", i, noise=0.0) for i in range(4)], GRAPH) == []
    assert findings([], GRAPH) == []


def test_noise_is_told_from_the_readings() -> None:
    assert column_noise(GOOD, GRAPH)["cup.x"] == pytest.approx(0.001, rel=0.6)
    assert column_noise([piece("p", 0, noise=0.0)], GRAPH)["cup.x"] == 0.0


def test_equal_pieces_under_two_names() -> None:
    found = only(findings([*GOOD, replace(GOOD[1], name="copy")], GRAPH))
    assert str(found).startswith("p1, copy: are the same; remove one")
    part = replace(GOOD[1], name="part", table=GOOD[1].table.iloc[:50])
    assert "p1, part: have the same first 50 rows" in str(only(findings([*GOOD, part], GRAPH)))


def test_a_frozen_feed() -> None:
    cup = GOOD[2].table[["cup.x", "cup.warm"]].to_numpy().copy()
    cup[30:38] = cup[30]
    found = only(findings(changed(2, **{"cup.x": cup[:, 0], "cup.warm": cup[:, 1]}), GRAPH))
    assert (found.piece, found.rows) == ("p2", (30, 37))
    assert "no reading of cup changes for 2.33 s, not even by noise: a frozen feed" in found.what


def test_a_coarse_sensor_repeats_itself_by_chance_and_freezes_all_the_same() -> None:
    names = ["cup.x", "cup.warm"]
    rng, pieces = np.random.default_rng(3), []
    for p in GOOD:  # it stands here and there, and is read to 2 mm
        place = np.repeat(rng.uniform(size=8), 10)[: len(p.table)] + rng.normal(scale=0.0015, size=len(p.table))
        pieces.append(replace(p, table=p.table.assign(**dict.fromkeys(names, (place / 0.002).round() * 0.002))))
    longest = max(len(list(g)) for p in pieces for _, g in itertools.groupby(p.table["cup.x"]))
    assert longest >= 4
    assert not [f for f in findings(pieces, GRAPH) if "frozen" in f.what]
    cup = pieces[2].table[names].to_numpy().copy()
    cup[20:75] = cup[20]
    pieces[2] = replace(pieces[2], table=pieces[2].table.assign(**{"cup.x": cup[:, 0], "cup.warm": cup[:, 1]}))
    (found,) = [f for f in findings(pieces, GRAPH) if "frozen" in f.what]
    assert found.piece == "p2"
    assert found.rows is not None
    assert found.rows[1] >= 74


def test_a_frozen_feed_without_noise_leaps_behind() -> None:
    pieces = [piece(f"p{i}", i, noise=0.0) for i in range(4)]
    arm = pieces[1].table["arm.x"].to_numpy().copy()
    arm[50:60] = arm[50]
    pieces[1] = replace(pieces[1], table=pieces[1].table.assign(**{"arm.x": arm}))
    found = only(findings(pieces, GRAPH))
    assert found.rows == (50, 59)
    assert "then it leaps: a frozen feed" in found.what


def test_a_long_frozen_feed_of_who_goes_to_and_fro() -> None:
    pieces = [piece(f"p{i}", i, noise=0.0) for i in range(4)]
    arm = 0.3 * np.sin(0.23 * np.arange(80))
    assert not findings([replace(pieces[1], table=pieces[1].table.assign(**{"arm.x": arm})), *pieces[2:]], GRAPH)
    arm[28:75] = arm[28]
    found = only(findings([replace(pieces[1], table=pieces[1].table.assign(**{"arm.x": arm})), *pieces[2:]], GRAPH))
    assert found.rows == (28, 74)
    assert "then it leaps: a frozen feed" in found.what


def test_a_constant_column() -> None:
    found = only(findings([replace(p, table=p.table.assign(**{"cup.warm": 0.2})) for p in GOOD], GRAPH))
    assert str(found).startswith("all pieces: cup.warm is 0.2 in every row")


def test_an_idle_piece() -> None:
    rng = np.random.default_rng(9)
    still = {c: v + 0.001 * rng.standard_normal(80) for c, v in (("arm.x", 0.1), ("cup.x", 0.2), ("cup.warm", 0.3))}
    found = only(findings(changed(3, **still, **{"arm->cup": 0.0}), GRAPH))
    assert found.piece == "p3"
    assert "nothing moves in 91 % of its rows" in found.what


def test_a_flag_that_flickers_where_nothing_moves() -> None:
    rows = np.arange(80)
    arm = np.where(rows < 20, GOOD[0].table["arm.x"][0], GOOD[0].table["arm.x"])
    cup = np.where(rows < 20, GOOD[0].table["cup.x"][0], GOOD[0].table["cup.x"])
    arm, cup = (v + np.where(rows < 20, 0.001 * np.random.default_rng(5).standard_normal(80), 0) for v in (arm, cup))
    warm = 0.2 + np.where(rows < 20, 0.0, 0.01 * (rows - 20)) + 0.001 * np.random.default_rng(6).standard_normal(80)
    flag = GOOD[0].table["arm->cup"].where(~np.isin(rows, (5, 9)), 1.0)
    pieces = changed(0, **{"arm.x": arm, "cup.x": cup, "cup.warm": warm, "arm->cup": flag})
    found = only(findings(pieces, GRAPH))
    assert found.rows == (5, 9)
    assert "the flag arm->cup flips for single rows in which nothing moves, 2 times" in found.what


def test_pieces_that_contradict_each_other() -> None:
    rng = np.random.default_rng(1)
    again = GOOD[0].table.copy()
    for name in ("arm.x", "cup.x", "cup.warm"):
        again[name] += 0.0003 * rng.standard_normal(len(again))
    again["arm->cup"] = 1 - again["arm->cup"]
    found = only(findings([*GOOD, Demonstration(again, {}, "wrong")], GRAPH))
    assert found.piece == "p0, wrong"
    assert "contradict each other about arm->cup" in found.what


def test_the_report_of_a_set() -> None:
    report = overview([*GOOD, replace(GOOD[1], name="<copy>")], GRAPH, ["bad.csv: no"])
    assert report["pieces"][0]["interactions"]["arm->cup"] == {"active": 0.3375, "begins": 1, "ends": 1}
    assert report["interactions"]["arm->cup"][0] == "p0"
    text = overview_text(report)
    assert "p0: 80 rows, 26.3 s, idle 0 %; arm->cup 34 % (+1 -1)" in text
    assert "odd: p1, <copy>: are the same" in text
    page = overview_page(report, "A & B").decode()
    assert "&lt;copy&gt;" in page and "<copy>" not in page and "A &amp; B" in page
    assert "<script" not in page and "http" not in page


def test_tables_alone_tell_a_graph() -> None:
    graph = inferred_graph(GOOD)
    assert list(graph.objects) == ["arm", "cup"]
    assert [e.name for e in graph.interactions] == ["arm->cup"]
    with pytest.raises(InputError, match="no column is named"):
        inferred_graph([Demonstration(pd.DataFrame({"time": [0.0]}))])
    with pytest.raises(InputError, match="name the system with --system"):
        inferred_graph(
            [Demonstration(pd.DataFrame({"a.x": [0.0], "b.x": [0.0], "c.x": [0.0], "a->c": [0], "b->c": [0]}))]
        )

"""`relearn`: the table's rows, what each learns anew, and failures that show."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ichain_drake.cli.main import main
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.runs.paths import relearn
from ichain_drake.runs.paths.relearn import WAYS, relearn_link, summarise_ways
from ichain_drake.state import StateSpace, Variable
from ichain_drake.systems import load_scenario
from ichain_drake.timing import TICK

FAST = ("learning.samples=300", "control.efforts=[0.05]", "learning.estimator=polynomial(degree=3)")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of the car game, from few samples."""
    folder = tmp_path_factory.mktemp("relearn")
    settings = [text for setting in FAST for text in ("--set", setting)]
    teach = ["teach", "car_game", "--physics", "ideal", "-o", str(folder / "demos"), *settings]
    assert main(teach) == 0
    assert main(["learn", "car_game", "--demos", str(folder / "demos"), "-o", str(folder / "library"), *settings]) == 0
    return folder / "library"


def rows_of(report: dict) -> dict[str, dict]:
    return {row["way"]: row for row in report["rows"]}


def test_a_moved_and_turned_joystick(
    library: Path, tmp_path: Path, capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    short(monkeypatch)
    file = tmp_path / "report.json"
    settings = [*FAST, "joystick.pivot=[0.46, 0.05, 0.07]", "joystick.yaw_deg=60", "joystick.offset=[0.006, 0]"]
    more = [text for setting in settings for text in ("--set", setting)]
    link = ["--link", "hand->joystick", "--library", str(library)]
    assert main(["relearn", "car_game", *link, "--physics", "ideal", "--report", str(file), *more]) == 0
    report = json.loads(file.read_text())
    rows = rows_of(report)
    assert tuple(rows) == WAYS
    assert report["unit"] == "px"
    assert rows["original"]["ratio"] == 1.0
    assert rows["original"]["new_samples"] == rows["changed, nothing relearned"]["new_samples"] == 0
    assert rows["one link"]["relearned"] == ["hand->joystick"]
    assert rows["one link"]["new_samples"] == 300
    assert rows["one link"]["ratio"] < 1.15
    assert rows["all links"]["new_samples"] == 600
    assert rows["changed, nothing relearned"]["ratio"] is None or rows["changed, nothing relearned"]["ratio"] > 2
    assert rows["monolithic, stale"]["paths"] == {"short": None}
    assert rows["monolithic, stale"]["reason"] == "the end was not reached on: short"
    assert rows["monolithic, all anew"]["robot_seconds"] == pytest.approx(200)
    printed = capsys.readouterr().out
    assert "short (px)" in printed
    assert "monolithic, stale: the end was not reached on: short" in printed


def test_a_joystick_that_is_only_moved_needs_no_sample(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    short(monkeypatch)
    rows = relearn_rows(0, library, "joystick.pivot=[0.54, -0.04, 0.06]", ways=WAYS[:2])
    assert tuple(rows) == WAYS[:2]
    assert rows["changed, nothing relearned"]["ratio"] == pytest.approx(1.0, abs=0.02)


def test_seeds_are_summed_up_with_what_was_lost() -> None:
    def row(way: str, error: float | None, ratio: float | None, reason: str = "") -> dict:
        return {
            "way": way,
            "paths": {"p": error},
            "ratio": ratio,
            "new_samples": 5,
            "robot_seconds": 2.0,
            "reason": reason,
            "applied": error is not None,
        }

    rows = [row("a", 1.0, 1.0), row("b", 3.0, 3.0), row("a", 2.0, 1.0), row("b", None, None, "lost its way")]
    a, b = summarise_ways(rows)
    assert (a["way"], a["seeds"], a["new_samples"], a["robot_seconds"], a["reason"]) == ("a", 2, 5, 2.0, "")
    assert a["paths"]["p"] == {"mean": 1.5, "std": 0.5, "lost": 0}
    assert b["paths"]["p"] == b["ratio"] == {"mean": 3.0, "std": 0.0, "lost": 1}
    assert b["reason"] == "lost its way"
    assert a["applied"]
    assert b["applied"]


def test_another_game_takes_the_hand_s_link(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    short(monkeypatch)
    rows = relearn_rows(0, library, game="hover_game", link="joystick->hovercraft")
    assert tuple(rows) == WAYS[:5]
    assert rows["original"]["reason"] == "the library has no link for joystick->hovercraft"
    assert rows["changed, nothing relearned"]["paths"] == {"short": None}
    assert [row["applied"] for row in rows.values()] == [False, False, True, True, False]
    assert rows["monolithic, stale"]["reason"] == "what it was learned to move is not there: hovercraft is new"
    assert rows["one link"]["relearned"] == ["joystick->hovercraft"]
    assert rows["one link"]["robot_seconds"] == 0
    assert rows["one link"]["paths"]["short"] < 5
    assert rows["one link"]["ratio"] is None


def test_wrong_links_and_libraries_are_refused(library: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--link 'hand->car': the chain's links are hand->joystick, joystick->car"):
        relearn_rows(0, library, link="hand->car")
    with pytest.raises(InputError, match="it has no link for joystick->hovercraft; learn it first"):
        relearn_rows(0, library, game="hover_game")
    assert main(["relearn", "car_game", "--link", "hand->joystick", "--library", str(tmp_path / "none")]) == 2
    more = ["--library", str(library), "--trials", "0"]
    assert main(["relearn", "car_game", "--link", "hand->joystick", *more]) == 2


def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """One short path in place of the games' own three: a bend that both can go."""
    a = np.linspace(0.0, np.pi / 2, 200)
    bend = np.stack([250 + 200 * np.sin(a), 400 - 200 * (1 - np.cos(a))], axis=1)
    for name in ("car_game", "hover_game"):
        kind = type(load_scenario(name, (), "ideal"))
        monkeypatch.setattr(kind, "reference_paths", lambda self: {"short": bend})


def relearn_rows(
    seed: int,
    library: Path,
    *settings: str,
    game: str = "car_game",
    link: str = "hand->joystick",
    ways: tuple[str, ...] = WAYS[:5],
) -> dict[str, dict]:
    changed, original = (load_scenario(game, [*FAST, *more], "ideal", seed) for more in (settings, ()))
    return rows_of(relearn_link(changed, original, link, library, ways=ways))  # type: ignore[arg-type]


def test_a_path_whose_end_was_not_reached_is_named_and_has_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = load_scenario("car_game", (), "ideal", 0)

    def followed(scenario: object, chain: object, controller: object, name: str, path: object, number: int) -> object:
        return SimpleNamespace(completed=name != "spiral", error=0.25 + number)

    monkeypatch.setattr(relearn, "follow", followed)
    link = SimpleNamespace(
        source="demonstrations", interaction=SimpleNamespace(name="a->b"), forward=SimpleNamespace(samples=7),
        robot_seconds=3.0,
    )  # fmt: skip
    known = SimpleNamespace(**{**vars(link), "source": "library"})
    chain = SimpleNamespace(links=[known, link])
    row = relearn._row(scenario, relearn.ANEW, lambda: (chain, None), lambda line: None)  # type: ignore[arg-type, return-value]
    assert row["paths"] == {"eight": 0.25, "spiral": None, "cursive": 2.25}
    assert row["reason"] == "the end was not reached on: spiral"
    assert (row["relearned"], row["new_samples"], row["robot_seconds"]) == (["a->b"], 7, 3.0)
    old = relearn._row(scenario, relearn.STALE, lambda: (chain, None), lambda line: None, new=False)  # type: ignore[arg-type, return-value]
    assert (old["relearned"], old["new_samples"]) == ([], 0)


def test_a_ratio_is_the_mean_over_the_paths_and_none_where_one_was_lost() -> None:
    assert relearn._ratio({"a": 1.0, "b": 3.0}, {"a": 2.0, "b": 2.0}) == 1.0
    assert relearn._ratio({"a": 1.0, "b": None}, {"a": 2.0, "b": 2.0}) is None
    assert relearn._ratio({"a": 1.0}, {"a": 2.0, "b": 2.0}) is None
    assert relearn._ratio({}, {}) is None


@pytest.mark.parametrize(
    ("link", "known", "told"),
    [("b->c", (), True), ("b->c", ("b->c",), False), ("a->b", (), False), ("h->a", (), False)],
)
def test_a_stale_model_from_robot_to_target_is_lost_only_where_the_target_is_new(
    monkeypatch: pytest.MonkeyPatch, link: str, known: tuple[str, ...], told: bool
) -> None:
    spaces = {n: StateSpace(n, (Variable("x"),)) for n in "habc"}
    scenario: Any = SimpleNamespace(
        graph=InteractionGraph(spaces, ["h->a", "a->b", "b->c"]), target="c", reference_paths=lambda: {"eight": None},
        config=SimpleNamespace(control=SimpleNamespace(method="predictive"), learning=SimpleNamespace(samples=70)),
    )  # fmt: skip
    asked = []

    def learn(source: object, variant: Any, pieces: list[int]) -> None:
        asked.append((variant.monolithic, variant.samples, pieces))

    def row(scenario: object, way: str, learn: Any, say: object, *, new: bool = True) -> dict:
        learn()
        return {"way": way, "applied": True, "reason": "", "new_samples": 9 * new}

    scenario.monolithic_demonstration = lambda samples: samples
    monkeypatch.setattr(relearn, "learn_variant", learn)
    monkeypatch.setattr(relearn, "_row", row)
    saved: Any = SimpleNamespace(links=dict.fromkeys(known))
    ways = relearn._monolithic(scenario, scenario, saved, link, lambda line: None)
    stale = ways[relearn.STALE]()
    assert (stale["applied"], stale["new_samples"]) == (not told, 0)
    assert stale["reason"] == ("what it was learned to move is not there: c is new" if told else "")
    anew = ways[relearn.ANEW]()
    assert (anew["new_samples"], anew["robot_seconds"]) == (9, 9 * TICK)
    assert asked == [(True, 3 * 70, [3 * 70])] * (2 - told)  # as many samples as all links together

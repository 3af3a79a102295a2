"""Evaluation of goals: which lines there are, what a row says, and figures of classifiers that mean something."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from joblib import Parallel, delayed

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction
from ichain_drake.learning import InteractionModel
from ichain_drake.objects import Region
from ichain_drake.runs.goals import evaluation
from ichain_drake.runs.goals.evaluation import GoalEvaluation, check_graph_evaluation, score_classifiers
from ichain_drake.runs.goals.status_accuracy import count_events, held_out_scores, probe_scores
from ichain_drake.runs.goals.trial import Trial, run_trial, summarise, timed_trial, without_roles
from ichain_drake.runs.goals.variants import METHODS, choose_variants, piece_order, possible_variants
from ichain_drake.systems.water_dispenser.layout import LAYOUT
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

GOAL = ("cup.water <= 0.3", "not hand->cup")
SCENARIO = WaterDispenser((), "ideal")


def trial(number: int = 0, *settings: str, monitors: bool = True, goal: tuple[str, ...] = GOAL) -> Trial:
    return Trial("monitors", "none", WaterDispenser, settings, "ideal", 0, number, goal, monitors, 16)


def test_the_lines_of_the_table():
    lines = [(v.method, v.case) for v in choose_variants((), SCENARIO, 16)]
    cases = ["none", "slip", "knock", "stiff", "dropout", "moved", "noise"]
    assert lines == [
        *(("monitors", c) for c in cases), *(("no_monitors", c) for c in cases), ("no_roles", "none"),
        *(("pieces", f"{n} pieces") for n in (6, 8, 10, 12, 14, 16)),
    ]  # fmt: skip
    (noise,) = choose_variants(["monitors/noise"], WaterDispenser(("noise.scale=0.5",), "ideal"), 16)
    assert noise.settings == ("noise.scale=1.5",)
    assert [v.learning for v in choose_variants(["pieces"], SCENARIO, 9)] == [6, 8, "all"]
    assert choose_variants(["classifiers"], SCENARIO, 16) == []
    assert len(choose_variants(["monitors", "monitors/slip"], SCENARIO, 16)) == len(cases)


@pytest.mark.parametrize(
    ("methods", "trials", "message"),
    [
        (["magic"], 1, "there is no method 'magic'; there are monitors, no_monitors"),
        (
            ["monitors/quake"],
            1,
            "method monitors has no case 'quake'; it has none, slip, knock, stiff, dropout, moved, noise$",
        ),
        (["classifiers/none"], 1, "method classifiers has no case 'none'; it has none$"),
        ([], 0, "give numbers from 1"),
        ([], 901, "at most 900 runs of one seed; choose another --seed"),
    ],
)
def test_what_can_not_be_evaluated(methods, trials, message):
    with pytest.raises(InputError, match=message):
        check_graph_evaluation(SCENARIO, trials, methods)


@pytest.mark.parametrize(
    ("methods", "needed"),
    [((), True), (("classifiers",), True), (("pieces/6 pieces",), True), (("monitors/none", "no_roles"), False)],
)
def test_only_what_learns_from_shared_pieces_needs_them(methods: tuple[str, ...], needed: bool):
    what = GoalEvaluation(SCENARIO, (), GOAL, 1, methods, shared=False, fresh=True)
    assert what.needs_shared == needed
    assert replace(what, shared=True).needs_shared


def test_a_trial_that_breaks_off_is_a_row_with_its_reason_and_took_no_planning():
    def broken(overrides, physics, seed):
        raise InputError(f"no such world: {overrides}, {physics}, {seed}")

    row, seconds = timed_trial(replace(trial(3, "a.b=1"), kind=broken), SimpleNamespace())
    assert seconds == 0.0
    assert row == trial(3).row() | {"reason": "no such world: ('a.b=1',), ideal, 0", "cause": "error"}
    assert (row["success"], row["seed"], row["pieces"]) == (False, 3, 16)


def test_cases_that_a_physics_has_not_are_left_out_and_said():
    contact, skipped = WaterDispenser((), "contact"), dict[str, str]()
    left = possible_variants(choose_variants(["monitors"], contact, 16), contact, (), skipped)
    assert [v.case for v in left] == ["none", "stiff", "dropout", "moved", "noise"]
    assert set(skipped) == {"slip", "knock"}
    assert "in contact the plant alone moves things" in skipped["slip"]


def test_no_variable_says_what_it_is_without_roles():
    plain = without_roles(SCENARIO.graph)
    assert all(v.role is None for s in plain.objects.values() for v in s.variables)
    assert plain.interactions == SCENARIO.graph.interactions
    assert [v.unit for v in plain.objects["cup"].variables] == [v.unit for v in SCENARIO.graph.objects["cup"].variables]


def test_a_few_pieces_show_every_interaction_first(dispenser_pieces):
    order = piece_order(dispenser_pieces, 0)
    assert sorted(p.name for p in order) == sorted(p.name for p in dispenser_pieces)
    assert [p.name for p in order] == [p.name for p in piece_order(dispenser_pieces, 0)]
    assert [p.name for p in order] != [p.name for p in piece_order(dispenser_pieces, 1)]
    assert all(count_events(order[:6], e) for e in SCENARIO.graph.interactions)


def test_a_row_of_each_sort(dispenser_model: InteractionModel):
    reached = run_trial(trial(), dispenser_model)
    assert reached["success"], reached["reason"]
    assert (reached["error"], reached["reason"], reached["cause"], reached["silent"]) == (0.0, "", "", False)
    assert 0 < reached["control_steps"] < 400
    # Without monitors a stiff button stays out, and nobody notices.
    pressed = ("tank.temperature >= 0.2",)
    silent = run_trial(trial(0, "fault.kind=stiff", monitors=False, goal=pressed), dispenser_model)
    assert (silent["success"], silent["silent"], silent["cause"]) == (False, True, "misjudged")
    assert silent["error"] > 0
    assert "tank.temperature >= 0.2 is not true" in silent["reason"]
    never = run_trial(trial(goal=("cup.temperature >= 1.5",)), dispenser_model)
    assert (never["success"], never["silent"], never["cause"]) == (False, False, "no plan")
    assert "bounded there" in never["reason"]
    unlearned = run_trial(trial(), "hand->cup: never active")
    assert (unlearned["cause"], unlearned["reason"]) == ("learning", "hand->cup: never active")
    wrong = run_trial(trial(goal=("mug.water >= 1",)), dispenser_model)
    assert (wrong["cause"], wrong["silent"]) == ("error", False)
    rows = [reached, silent, never, unlearned, wrong]
    assert len({tuple(row) for row in rows}) == 1
    (line,) = summarise(rows)
    assert (line["runs"], line["reached"], line["silent"]) == (5, 1, 1)
    assert line["median_steps"] == reached["control_steps"]
    assert line["causes"] == {"error": 1, "learning": 1, "misjudged": 1, "no plan": 1}
    assert summarise([never])[0]["median_steps"] is None


def test_another_process_gives_the_same_rows(dispenser_model: InteractionModel):
    here = run_trial(trial(3, "fault.kind=slip"), dispenser_model)
    trials = [trial(n, "fault.kind=slip") for n in (3, 4)]
    first, second = Parallel(n_jobs=2)(delayed(run_trial)(t, dispenser_model) for t in trials)
    assert here == first
    assert first != second  # another start and another time of the slip


def test_near_misses_are_outside_but_near(dispenser_pieces: list[Demonstration]):
    camera = SCENARIO.camera()
    regions: dict[str, Region] = {
        "cup->tank": LAYOUT.pour_region(),
        "tank->cup": LAYOUT.catch_region(0.1),
        "hand->cup": SCENARIO.cup_settings().grasp,
    }
    for name, region in regions.items():
        probes = SCENARIO.probes(Interaction.parse(name), dispenser_pieces, 40)
        assert probes is not None
        assert probes.active.sum() == (~probes.active).sum() == 40
        points = camera.to_robot(probes.true["cup"][:, :3])
        if name == "hand->cup":
            points = probes.true["hand"][:, :3] - points
        share = np.abs((points - region.center) / region.half)
        sideways = np.hypot(share[:, 0], share[:, 1]) if region.round else share[:, :2].max(axis=1)
        away = np.maximum(sideways, share[:, 2])
        assert (away[probes.active] <= 1 + 1e-9).all(), name
        assert ((away[~probes.active] > 1) & (away[~probes.active] <= 1.5 + 1e-9)).all(), name
        assert 0 < np.abs(probes.read["cup"][:, :3] - probes.true["cup"][:, :3]).max() < 0.01
        assert 0.8 < np.mean(probes.gate == probes.active) <= 1.0
    for button in ("power", "dispense"):
        probes = SCENARIO.probes(Interaction(button, "tank"), dispenser_pieces, 20)
        assert probes is not None
        assert set(probes.true[button][~probes.active, 0]) == {3.0}
        assert set(probes.true[button][probes.active, 0]) == {4.0, 5.0, 6.0}
        probes = SCENARIO.probes(Interaction("hand", button), dispenser_pieces, 40)
        assert probes is not None
        assert (probes.true[button][~probes.active] == 0).all()


def test_by_contact_a_hand_has_no_near_misses(dispenser_pieces):
    contact = WaterDispenser((), "contact")
    made = {e.name: contact.probes(e, dispenser_pieces, 5) is not None for e in contact.graph.interactions}
    assert made == {e.name: e.parent != "hand" for e in contact.graph.interactions}
    empty = dict.fromkeys(("near_misses", "near_miss_f1", "near_miss_read_f1", "gate_read_f1")) | {"borders": {}}
    assert probe_scores(None, contact.graph.interactions[0], None) == empty  # type: ignore[arg-type]


def test_figures_of_classifiers(dispenser_model: InteractionModel, dispenser_pieces):
    lines = score_classifiers(SCENARIO, dispenser_model, dispenser_pieces)
    assert [line["interaction"] for line in lines] == [e.name for e in SCENARIO.graph.interactions]
    for line in lines:
        edge = Interaction.parse(line["interaction"])
        assert line["events"] == count_events(dispenser_pieces, edge) > 10
        assert line["status_f1"] > 0.95
        assert 0.5 < line["near_miss_f1"] <= 1.0
    # Flags that are all wrong give figures that are: the truth is not read from the model.
    edge = Interaction("hand", "cup")
    turned = [
        Demonstration(p.table.assign(**{edge.name: 1.0 - p.table[edge.name]}), p.units, p.name)
        for p in dispenser_pieces[:4]
    ]
    assert held_out_scores(dispenser_model, turned)[edge]["status_f1"] < 0.5


def test_events_are_counted_within_pieces():
    edge = Interaction("a", "b")
    pieces = [Demonstration(pd.DataFrame({"a->b": flags})) for flags in ([0.0, 1, 1, 0], [1.0, 1, 0, 1], [0.0, 0])]
    assert count_events(pieces, edge) == sum(x != y for p in pieces for x, y in pairwise(p.table["a->b"]))
    assert METHODS[-1] == "classifiers"


@pytest.mark.parametrize("scores", [False, True])
def test_pieces_of_further_seeds_are_recorded_where_classifiers_are_scored(
    scores: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    class RecordedError(Exception):
        pass

    def note(jobs: Iterable[tuple], backend: object, what: str) -> None:
        seeds.extend(args[-1] for _, args, _ in jobs)
        raise RecordedError

    seeds: list[int] = []
    monkeypatch.setattr(evaluation, "run_all", note)
    what = SimpleNamespace(
        scenario=SimpleNamespace(seed=5, physics="ideal"),
        kind=None,
        overrides=(),
        needs_shared=True,
        wants_scores=scores,
    )
    with pytest.raises(RecordedError):
        evaluation._prepare(what, None, lambda text, share: None, {})  # type: ignore[arg-type]
    assert seeds == list(range(5, 5 + (1 + evaluation._HELD_OUT[0] if scores else 1)))

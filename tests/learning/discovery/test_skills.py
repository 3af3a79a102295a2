"""What recordings show between switches: from where, and what it changes."""

import bath_log
import numpy as np
import pytest

from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.discovery.skills import (
    REST,
    ShownSkill,
    Stretch,
    _effects,
    _statuses,
    _values,
    shown_skills,
    stretches,
)
from ichain_drake.learning.settings import LEARNING
from ichain_drake.state import StateSpace, Variable

PIECES = bath_log.pieces()


@pytest.fixture(scope="module")
def skills() -> dict[str, ShownSkill]:
    return {s.name: s for s in shown_skills(PIECES, bath_log.GRAPH)}


def test_stretches_cover_a_piece() -> None:
    found = stretches(PIECES[0], bath_log.GRAPH)
    assert [s.first for s in found] == [0, *(s.last + 1 for s in found[:-1])]
    assert found[-1].last == len(PIECES[0]) - 1
    assert found[0].before is None
    assert all(b.before == a.active != b.active for a, b in zip(found[:-1], found[1:], strict=True))


def test_each_set_of_active_interactions_is_a_skill(skills: dict[str, ShownSkill]) -> None:
    assert {"hand->lever", "hand->lever + lever->tank", REST} <= set(skills)
    assert sum(x.last - x.first + 1 for s in skills.values() for x in s.shown) == sum(map(len, PIECES))


def test_precondition_and_effect_are_those_of_the_world(skills: dict[str, ShownSkill]) -> None:
    fills, carries = skills["lever->tank"], skills["hand->lever"]
    assert [e for e in fills.effect if e.startswith("tank.level by +")]
    assert "hand->lever active" in fills.precondition  # who opened it let go
    assert "lever.x either way" in carries.effect
    assert any(" <= hand.y <= " in text for text in carries.precondition)
    assert not any("tank" in text for s in (carries, skills[REST]) for text in s.effect)
    assert str(fills).startswith(f"lever->tank: {len(fills.shown)} times; from hand->lever active and ")
    assert fills.report()["shown"][0]["piece"] == fills.shown[0].piece


def box_at(*places: float) -> dict[str, dict[str, np.ndarray]]:
    spaces = {"hand": np.zeros((len(places), 1)), "box": np.array(places)[:, None]}
    return {n: {"p": v} for n, v in spaces.items()}


SMALL = InteractionGraph({n: StateSpace(n, (Variable("x"),)) for n in ("hand", "box")}, ["hand->box"])
SILENT = {n: np.full(1, 1e-3) for n in ("hand", "box")}


def shown(*stretches: tuple[int, int]) -> list[Stretch]:
    return [Stretch("p", a, b, ("hand->box",), None) for a, b in stretches]


def test_values_before_a_skill_are_told_where_it_was_shown_often_enough() -> None:
    """One start or two may be narrow by chance."""
    states, times = box_at(*np.arange(60.0)), LEARNING.few
    for count, told in ((times - 1, []), (times, ["30 <= box.x <= 30"]), (times + 3, ["30 <= box.x <= 30"])):
        assert _values(SMALL, states, SILENT, ("hand->box",), shown(*[(30, 31)] * count)) == told


def test_an_effect_is_counted_from_the_row_before_a_stretch() -> None:
    """What changed before that was of another skill."""
    states = box_at(0.0, 0.0, 5.0, 6.0, 6.0)
    assert _effects(SMALL, states, SILENT, shown((3, 4))) == ["box.x by +1"]
    assert _effects(SMALL, states, SILENT, shown((1, 2))) == ["box.x by +5"]


def before(*statuses: str | None) -> list[Stretch]:
    """Stretches before which these were active, a letter each."""
    return [Stretch("p", 0, 1, ("a", "b"), None if s is None else tuple(s)) for s in statuses]


def test_statuses_are_a_condition_where_they_held_before_each_time() -> None:
    assert _statuses(("a", "b"), before(None, None)) == []
    assert _statuses(("a", "b"), before("c", None, "ca")) == ["c active", "b inactive"]
    assert _statuses(("a", "b"), before("dc", "cd", "cdx")) == ["c active", "d active", "a inactive", "b inactive"]
    assert _statuses(("a", "b"), before("a", "b")) == []


@pytest.mark.parametrize(
    ("ways", "said"),
    [
        ([1.0, 1.0, 1.0, 1.0, 1.0], ["box.x by +1"]),
        ([-1.0, -2.0, -2.0, -3.0, 0.0], ["box.x by -2"]),  # in four of five
        ([1.0, 1.0, 1.0, 0.0, 0.0], ["box.x either way"]),
        ([1.0, -1.0, 1.0, -1.0, 1.0], ["box.x either way"]),
        ([1.0, -1.0, 0.0, 0.0, 0.0], []),
        ([4e-3, 4e-3, 4e-3, 4e-3, 4e-3], []),  # 4.2 are three noises of a difference
        ([5e-3, 5e-3, 5e-3, 5e-3, 5e-3], ["box.x by +0.005"]),
    ],
)
def test_an_effect_is_what_changed_clearly_in_most_of_them(ways: list[float], said: list[str]) -> None:
    places = np.concatenate([[0.0], *[[0.0, w] for w in ways]])
    assert _effects(SMALL, box_at(*places), SILENT, shown(*[(2 * k + 2, 2 * k + 2) for k in range(5)])) == said


def test_a_value_is_a_condition_where_it_was_in_a_narrow_part_of_its_range() -> None:
    for last, told in ((30.0 + 0.9 * LEARNING.reach * 59.0, True), (30.0 + 1.1 * LEARNING.reach * 59.0, False)):
        places = [*np.arange(60.0), last]
        found = _values(SMALL, box_at(*places), SILENT, ("hand->box",), shown((30, 31), (30, 31), (60, 60)))
        assert found == ([f"30 <= box.x <= {last:.3g}"] if told else [])
    still = box_at(*(5.0 + 1e-3 * (np.arange(60) % 3)))
    assert _values(SMALL, still, SILENT, ("hand->box",), shown(*[(30, 31)] * 3)) == [], (
        "what never changed says nothing"
    )
    assert _values(SMALL, box_at(*np.arange(60.0)), SILENT, (), shown(*[(30, 31)] * 3)) == [], "nobody takes part"

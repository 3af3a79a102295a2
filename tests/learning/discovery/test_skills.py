"""What recordings show between switches: from where, and what it changes."""

import bath_log
import pytest

from ichain_drake.learning.discovery.skills import REST, ShownSkill, shown_skills, stretches

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

"""The list of settings: complete, with range, default and meaning, and the same as what is refused by."""

from dataclasses import dataclass

import pytest

from ichain_drake.cli.main import main
from ichain_drake.scenarios.settings_list import attribute_meanings, list_settings, markdown_table
from ichain_drake.systems import SCENARIOS


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_key_of_every_scenario_says_what_it_means(name: str) -> None:
    lines = list_settings(SCENARIOS[name])
    keys = [line.key for line in lines]
    assert len(set(keys)) == len(keys)
    assert {"noise.scale", "fault.kind", "learning.samples", "robot.plant_step"} <= set(keys)
    assert [line.key for line in lines if not line.meaning] == []


def test_a_line_has_unit_range_and_the_scenarios_default() -> None:
    (line,) = [line for line in list_settings(SCENARIOS["car_racing"]) if line.key == "path.speed"]
    assert (line.unit, line.allowed, line.default) == ("unit/s", "above 0 and up to 10000", "15")
    assert line.meaning.startswith("nominal speed")
    assert "| `path.speed` | unit/s | above 0 and up to 10000 | `15` | nominal speed. |" in markdown_table([line])


@dataclass
class Base:
    """Base.

    Attributes:
        one, two: of both
            kinds.
    """

    one: int = 1
    two: int = 2


@dataclass
class Child(Base):
    """Child.

    Attributes:
        one: see `Base`.
        three: its own.

    Raises:
        four: is no attribute.
    """

    three: int = 3


def test_meanings_come_from_docstrings_the_bases_included() -> None:
    assert attribute_meanings(Child) == {"one": "of both kinds.", "two": "of both kinds.", "three": "its own."}


def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["settings", "car_game"]) == 0
    out = capsys.readouterr().out
    assert "path.tolerance=3 [px]  (above 0 and up to 10000)\n    the end counts as reached" in out
    assert main(["settings", "car_gme"]) == 2

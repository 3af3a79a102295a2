"""Lines of the scoreboard: which failures a fault is not to blame for."""

from typing import Any

from ichain_drake.runs.intervals import success_interval
from ichain_drake.runs.scoreboard.table import add_failures_without, prediction_lines


def rows(name: str, **successes: bool) -> list[dict[str, Any]]:
    return [{"row": name, "seed": int(seed[1:]), "success": success} for seed, success in successes.items()]


def test_failures_that_are_there_without_the_fault_are_counted() -> None:
    found = [
        *rows("cup/goal/ideal/none", s1=True, s2=False, s3=False),
        *rows("cup/goal/ideal/slip", s1=False, s2=False, s3=True, s4=False),
        *rows("cup/goal/ideal/reading", s2=False),  # of other demonstrations
        *rows("cup/goal/contact/slip", s2=False),
    ]
    names = ("cup/goal/ideal/none", "cup/goal/ideal/slip", "cup/goal/ideal/reading", "cup/goal/contact/slip")
    table = [{"row": name, "fault": name.rpartition("/")[2]} for name in names]
    add_failures_without(table, found)
    assert [line["failed_without"] for line in table] == [None, 1, None, None]


def test_what_plans_said_stands_beside_what_became_of_them() -> None:
    said = [(0.95, True), (0.97, True), (1.0, False), (0.42, True), (0.49, False), (None, False)]
    found = prediction_lines([{"probability": p, "success": success} for p, success in said])
    assert [(line["above"], line["up_to"], line["runs"], line["reached"]) for line in found] == [
        (0.9, 1.0, 3, 2),
        (0.4, 0.5, 2, 1),
    ]
    assert [line["predicted"] for line in found] == [round((0.95 + 0.97 + 1.0) / 3, 4), round((0.42 + 0.49) / 2, 4)]
    assert found[0]["interval"] == success_interval(2, 3)
    assert prediction_lines([{"probability": None, "success": False}]) == []

"""Lines of the scoreboard: which failures a fault is not to blame for."""

from typing import Any

from ichain_drake.runs.scoreboard.table import add_failures_without


def rows(name: str, **successes: bool) -> list[dict[str, Any]]:
    return [{"row": name, "seed": int(seed[1:]), "success": success} for seed, success in successes.items()]


def test_failures_that_are_there_without_the_fault_are_counted() -> None:
    found = [
        *rows("cup/goal/ideal/none", s1=True, s2=False, s3=False),
        *rows("cup/goal/ideal/slip", s1=False, s2=False, s3=True, s4=False),
        *rows("cup/goal/contact/slip", s2=False),
    ]
    names = ("cup/goal/ideal/none", "cup/goal/ideal/slip", "cup/goal/contact/slip")
    table = [{"row": name, "fault": name.rpartition("/")[2]} for name in names]
    add_failures_without(table, found)
    assert [line["failed_without"] for line in table] == [None, 1, None]

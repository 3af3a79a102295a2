"""Rules that are not the paper's: each can be switched off, where it is switched off and nowhere else."""

import re
from pathlib import Path

import pytest

from ichain_drake import rules
from ichain_drake.cli.main import main
from ichain_drake.errors import InputError

PACKAGE = Path(rules.__file__).parent


def test_a_rule_is_off_inside_and_on_outside():
    assert rules.enabled("subsumed")
    with rules.without(["subsumed"]):
        assert not rules.enabled("subsumed")
        assert rules.enabled("push_further")
        with rules.without(["push_further"]):
            assert rules.switched_off() == {"subsumed", "push_further"}
        assert rules.enabled("push_further")
    assert rules.enabled("subsumed")
    assert rules.switched_off() == frozenset()


def test_it_is_on_again_after_an_error():
    with pytest.raises(ZeroDivisionError), rules.without(["subsumed"]):
        raise ZeroDivisionError
    assert rules.enabled("subsumed")


def test_unknown_names_are_refused_with_close_ones():
    with (
        pytest.raises(InputError, match=r"there is no rule 'subsume'; did you mean subsumed\?"),
        rules.without(["subsume"]),
    ):
        pass
    with pytest.raises(InputError, match="there is no rule 'xyz'; there are subsumed, unseen"):
        rules.check_names(["xyz"])
    with pytest.raises(KeyError):
        rules.enabled("xyz")


def test_every_rule_acts_somewhere_and_every_switch_has_a_rule():
    asked: dict[str, set[str]] = {}
    for file in PACKAGE.rglob("*.py"):
        if file.name == "rules.py":
            continue
        for name in re.findall(r"\benabled\(\"(\w+)\"\)", file.read_text()):
            package = ".".join(file.relative_to(PACKAGE).parts[:-1])
            asked.setdefault(name, set()).add(package)
    assert set(asked) == set(rules.RULES)
    for name, rule in rules.RULES.items():
        assert asked[name] == {rule.where}, name
        assert rule.reason


@pytest.mark.parametrize("command", [["run"], ["evaluate"], ["scoreboard", "--only"]])
def test_commands_refuse_a_rule_that_there_is_not(command, capfd):
    name = ["*"] if command[0] == "scoreboard" else ["water_dispenser", "--physics", "ideal"]
    assert main([*command, *name, "--without", "push_furthe"]) == 2
    assert capfd.readouterr().err == "ichain: there is no rule 'push_furthe'; did you mean push_further?\n"


def test_a_report_names_the_rules_that_were_off():
    from lamp import LampScenario

    from ichain_drake.runs.provenance import given_of

    assert "without" not in given_of(LampScenario())
    with rules.without(["subsumed", "unseen"]):
        assert given_of(LampScenario())["without"] == ["subsumed", "unseen"]


def test_a_rule_changes_what_it_is_about():
    """On the smallest world that one acts in."""
    import numpy as np
    from small_job import fresh, learned, readings

    from ichain_drake.control.execution.monitoring import deviation
    from ichain_drake.control.planning.goals import parse_goal

    model, _, planner = learned()
    start = readings(fresh())
    goal = parse_goal(["box.water >= 0.5"], model, start)
    plan = planner.plan(start, goal)
    step = plan.steps[0]
    moved = {n: np.array(v) for n, v in step.predicted.items()}
    moved["box"] = moved["box"] + 1.0
    assert deviation(model, step, moved)
    with rules.without(["deviation"]):
        assert deviation(model, step, moved) == ""

"""Which rows there are: everything that ships, and nothing that a physics refuses."""

from pathlib import Path

import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs.scoreboard.cases import QUICK, WHOLE, Case, all_cases
from ichain_drake.runs.scoreboard.table import make_line
from ichain_drake.runs.scoreboard.trials import make_jobs
from ichain_drake.systems import SCENARIOS
from ichain_drake.systems.car_game.scenario import CarGame

OUTSIDE = Path(__file__).parents[2] / "helpers" / "outside"


def test_every_system_task_physics_and_fault():
    cases, skipped = all_cases(WHOLE)
    assert {c.system for c in cases} == set(SCENARIOS)
    names = [c.name for c in cases]
    assert len(set(names)) == len(names)
    for name in (
        "car_game/spiral/ideal/none", "car_game/eight/contact/none", "ship/oval/ideal/noise",
        "water_dispenser/goal/ideal/slip", "water_dispenser/goal/contact/stiff",
        "kettle/goal/arm/knock", "microwave/goal/contact/none", "kettle/goal/contact/moved",
    ):  # fmt: skip
        assert name in names
    assert not any(n.startswith(("two_dispensers/goal/arm", "two_dispensers/goal/contact")) for n in names)
    assert "an arm does not reach both" in skipped["two_dispensers/contact"]
    assert "in contact the plant alone moves things" in skipped["kettle/contact/slip"]
    assert {c.trials for c in cases if c.physics == "ideal" and c.fault == "none"} == {20}
    assert all(c.trials >= 3 for c in cases)


def test_a_path_may_have_faults_of_its_own(tmp_path):
    (tmp_path / "flaky.py").write_text(
        "from ichain_drake.systems.car_game.scenario import CarGame\n"
        "class Flaky(CarGame):\n    name = 'flaky'\n    faults = ('none', 'dropout')\n"
    )
    cases, _ = all_cases(WHOLE, [str(tmp_path / "flaky.py")], ["flaky/eight/ideal/*"])
    assert {c.fault: c.trials for c in cases} == {"none": 20, "dropout": 10, "noise": 10, "reading": 10}


def test_what_declares_noise_of_its_readings_has_a_row_of_it():
    read = {c.system for c in all_cases(WHOLE)[0] if c.fault == "reading"}
    assert read == {name for name, kind in SCENARIOS.items() if _reading_std(kind)}
    assert {"car_game", "hover_game", "driving", "ship"} <= read


def _reading_std(kind):
    return getattr(getattr(kind, "target_type", None), "reading_std", ())


def test_quick_is_a_part_of_it():
    whole = {c.name for c in all_cases(WHOLE)[0]}
    quick = all_cases(QUICK)[0]
    assert {c.name for c in quick} < whole
    assert {c.system for c in quick} == set(SCENARIOS)
    assert {c.system for c in quick if c.physics == "contact"} == {"car_game", "water_dispenser"}


def test_systems_of_ones_own_are_taken_in(tmp_path):
    cases, _ = all_cases(
        WHOLE, [str(OUTSIDE / "lock_place.py"), str(OUTSIDE / "crane.py")], ["lock_place/*", "crane/*"], 2
    )
    assert {(c.name.partition("/")[2], c.trials) for c in cases} >= {("goal/ideal/none", 2), ("goal/ideal/noise", 2)}
    assert {c.physics for c in cases} == {"ideal"}  # nothing that an arm could touch
    taken = tmp_path / "taken.py"
    taken.write_text(
        "from ichain_drake.systems.kettle.scenario import KettleScenario\nclass Mine(KettleScenario):\n    pass\n"
    )
    with pytest.raises(InputError, match="there is a system 'kettle' already; rename yours"):
        all_cases(WHOLE, [str(taken)])


def test_patterns():
    names = [c.name for c in all_cases(WHOLE, only=["kettle/*/ideal/*", "ship/bends/ideal/none"])[0]]
    assert names[-1] == "ship/bends/ideal/none"
    faults = ("none", "slip", "knock", "stiff", "dropout", "moved", "noise")
    assert set(names[:-1]) == {f"kettle/goal/ideal/{f}" for f in faults}
    with pytest.raises(
        InputError, match=r"--only nix/\*: no row is called so; rows are named as car_game/eight/ideal/none"
    ):
        all_cases(WHOLE, only=["nix/*"])


def test_a_job_has_all_that_shares_demonstrations_and_every_trial_a_seed_of_its_own():
    cases, _ = all_cases(WHOLE, only=["kettle/*/ideal/*", "car_game/*/ideal/*"])
    jobs = make_jobs(cases, 70)
    ids = [i for job in jobs for i in job.ids]
    assert len(set(ids)) == len(ids) == sum(c.trials for c in cases)
    read = [job for job in jobs if job.ids[0].endswith("/reading/seed 70")]
    assert [len(job.ids) for job in read] == [3], "a vehicle that is read with noise is demonstrated so"
    jobs = [job for job in jobs if "/reading/" not in job.ids[0]]
    kettle = [job for job in jobs if job.ids[0].startswith("kettle")]
    assert [job.seed for job in kettle] == list(range(70, 90))
    assert all(len(job.ids) == 7 for job in kettle)
    games = [job for job in jobs if job.ids[0].startswith("car_game")]
    assert [len(job.ids) for job in games] == [6] * 10 + [3] * 10  # noise in half of them
    assert [job for job in make_jobs(cases, 70) if "/reading/" not in job.ids[0]] == jobs


def row(success, seed, **more):
    return {
        "success": success, "seed": seed, "error": 0.5 if success else None, "oracle_error": None,
        "cause": "" if success else "x", "reason": "" if success else "why",
        "silent": False, "control_steps": 100 + seed, "replans": 1, "unit": "px",
        "learning_seconds": 1.0, "plan_seconds": None, "wall_seconds": 2.0,
    } | more  # fmt: skip


def test_a_line():
    case = Case("car_game", CarGame, "eight", "ideal", "none", (), 4)
    rows = [
        row(True, 1, oracle_error=0.25),
        row(True, 2),
        row(False, 3, silent=True),
        row(False, 5, cause="y", replans=None),
    ]
    line = make_line(case, rows)
    assert line["row"] == "car_game/eight/ideal/none"
    assert (line["reached"], line["runs"], line["silent"], line["seeds"]) == (2, 4, 1, "1-3, 5")
    assert (line["median_steps"], line["mean_replans"], line["mean_error"], line["ratio_to_oracle"]) == (
        101.5,
        1.0,
        0.5,
        2.0,
    )
    assert (line["learning_seconds"], line["plan_seconds"], line["unit"]) == (1.0, None, "px")
    assert (line["causes"], line["reason"]) == ({"x": 1, "y": 1}, "why")
    assert line["interval"][0] < 0.5 < line["interval"][1]
    nothing = make_line(case, [row(False, 1)])
    assert (nothing["median_steps"], nothing["mean_error"], nothing["ratio_to_oracle"]) == (None, None, None)

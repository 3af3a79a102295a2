"""Driving and the ship: start states, demonstrations, the shared link, what is refused, and whole runs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ichain_drake.cli.main import main
from ichain_drake.control.tracking.path import TimedPath
from ichain_drake.control.tracking.turns import check_turns
from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import learn_chain
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.scenarios.wheel_drive import WheelDrive
from ichain_drake.systems import load_scenario


def scenario(name: str, *settings: str, physics: str = "ideal", seed: int = 0) -> WheelDrive:
    made = load_scenario(name, settings, physics, seed)  # type: ignore[arg-type]
    assert isinstance(made, WheelDrive)
    return made


def test_play_covers_the_wheel_and_drive_is_without_the_arm() -> None:
    play, drive = scenario("driving", "learning.samples=150").record_demonstrations()
    wheel = play.table[["wheel.angle", "wheel.slide"]].to_numpy()
    assert (np.abs(wheel).max(axis=0) > [1.9, 0.018]).all()
    assert np.abs(np.diff(wheel, axis=0)).max(axis=0)[0] < np.radians(27)
    radius = np.hypot(play.table["hand.x"] - 0.47, play.table["hand.y"])
    np.testing.assert_allclose(radius, 0.11, atol=1e-9)
    assert set(drive.table.columns).isdisjoint({"hand.x", "command.x", "hand->wheel"})
    assert [p.name for p in scenario("ship", "learning.samples=20").record_demonstrations(known={"hand->wheel"})] == [
        "drive"
    ]


@pytest.mark.parametrize("name", ["driving", "ship"])
def test_reference_paths_lie_in_the_plane_and_begin_a_run(name: str) -> None:
    made = scenario(name)
    for path in choose_paths(made).values():
        assert (path.points > 0).all() and (path.points < made.size).all()
        world = made.make_world(path, 0)
        state = world.objects[made.target].get_state(world.objects[made.target].CreateDefaultContext())
        assert np.linalg.norm(state[:2] - path.points[0]) < 0.1 * made.target_length
        assert state[3] == pytest.approx(path.speed[0])


def test_the_oracle_s_coordinates_are_the_wheel_s() -> None:
    made = scenario("driving")
    chart = made.command_chart()
    wheel = np.random.default_rng(0).uniform(*made.command_range(), (20, 2))
    np.testing.assert_allclose(chart.from_hand(chart.to_hand(wheel)), wheel, atol=1e-12)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("wheel.center=[1, 2]", "give 3 numbers from -2 to 2, in m"),
        ("wheel.radius=0", "wheel.radius is 0.0; give a number above 0 and up to 1, in m"),
        ("play.angle_deg=170", "play.angle_deg is 170.0; give a number above 0 and up to 140, in deg"),
        ("play.slide=.nan", "play.slide is nan"),
        ("start.slide=0.1", "start.slide is 0.1; give a number from -0.025 to 0.025, in m"),
        ("robot.hand.ring={center: [1], radius: 0.1}", "robot.hand.ring.center is .1.0.; give 2 numbers"),
    ],
)
def test_numbers_that_can_t_work_are_refused(setting: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        scenario("driving", setting)


def test_turns_are_told_in_the_path_s_own_size() -> None:
    """A path in metres that turns too tightly: the window and the digits follow its spacing."""
    made = scenario("driving", "learning.samples=120", "path.turn_rate=50")  # it shall not slow down
    chain = learn_chain(
        list(made.record_demonstrations()), made.graph, made.target, made.target_variables,
        {"*": made.config.learning.candidates()["hand->wheel"]},
    )  # fmt: skip
    a = np.linspace(0, np.pi, 50)
    turn = np.stack([150 + 3 * np.sin(a), 103 - 3 * np.cos(a)], axis=1)
    hairpin = np.concatenate([[[100.0, 100.0]], turn, [[100.0, 106.0]]])
    with pytest.raises(InputError, match=r"path u: at \(1\d\d\.\d, 1\d\d\.\d\) it turns with a radius of \d\.\d m"):
        check_turns(TimedPath(hairpin, made.path_limits()), chain, "path u", "m")


def bend(file: Path) -> Path:
    a = np.linspace(0.0, np.pi / 2, 60)
    pd.DataFrame({"x": 150 + 40 * np.sin(a), "y": 100 + 40 * (1 - np.cos(a))}).to_csv(file, index=False)
    return file


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("wheel")


def run(folder: Path, physics: str) -> dict:
    more = [
        "--set",
        "learning.samples=120",
        "--set",
        "control.horizons=[5]",
        "--set",
        "control.efforts=[0.05]",
        "--path",
        str(bend(folder / "bend.csv")),
    ]
    assert main(["run", "driving", "--physics", physics, "-o", str(folder / physics), *more]) == 0
    return json.loads((folder / physics / "report.json").read_text())


def test_a_short_drive_in_ideal_and_by_contact(folder: Path) -> None:
    reports = {physics: run(folder, physics) for physics in ("ideal", "contact")}
    for report in reports.values():
        assert report["metrics"]["completed"]
        assert report["metrics"]["mean_error_px"] < 0.25 * report["given"]["vehicle_length"]
        assert report["metrics"]["unit"] == report["given"]["unit"] == "m"
        assert report["models"]["wheel->car"]["robot_seconds"] == 0
    play = pd.read_parquet(folder / "contact" / "demonstrations" / "play.parquet")
    assert (play["hand->wheel"].iloc[1:] == 1).all()


def test_nothing_joins_gripper_and_wheel() -> None:
    made = scenario("driving", physics="contact")
    world = made.make_world(choose_paths(made, ["eight"])["eight"], 0)
    robot = world.robot
    assert isinstance(robot, ArmRobot)
    plant = robot.plant
    assert plant.num_constraints() == 1  # the finger mimic
    wheel = plant.GetModelInstanceByName("wheel")
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        ends = {joint.parent_body().model_instance(), joint.child_body().model_instance()}
        if wheel in ends:
            assert {plant.GetModelInstanceName(i) for i in ends - {wheel}} <= {"WorldModelInstance"}


def test_the_ship_takes_the_hand_s_link_from_the_drive(tmp_path: Path) -> None:
    small = ["--set", "learning.samples=120", "--physics", "ideal"]
    assert main(["teach", "driving", *small, "-o", str(tmp_path / "demos")]) == 0
    assert (
        main(["learn", "driving", *small[:2], "--demos", str(tmp_path / "demos"), "-o", str(tmp_path / "library")]) == 0
    )
    a = np.linspace(0.0, 1.0, 40)
    pd.DataFrame({"x": 10 + 4 * a, "y": 10 + 0 * a}).to_csv(tmp_path / "short.csv", index=False)
    report = tmp_path / "report.json"
    given = ["--library", str(tmp_path / "library"), "--path", str(tmp_path / "short.csv")]
    status = main(["run", "ship", *small, *given, "--report", str(report), "-o", str(tmp_path / "out")])
    assert status in (0, 1)
    models = json.loads(report.read_text())["models"]
    assert models["hand->wheel"]["source"] != "demonstrations"
    assert models["wheel->ship"]["source"] == "demonstrations"
    assert [f.stem for f in (tmp_path / "out" / "demonstrations").glob("*.parquet")] == ["drive"]

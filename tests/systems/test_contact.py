"""The car game by contact: the same run as in the other physics, and nothing but friction holds the stick."""

import base64
import gzip
import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pydrake.systems.framework import Context, LeafSystem, State

from ichain_drake.cli.main import main
from ichain_drake.robot.arm import ArmRobot
from ichain_drake.simulation.episode import Episode, EpisodeLog
from ichain_drake.state import FloatArray
from ichain_drake.systems import load_scenario
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.timing import FRAME, FRAMES_PER_TICK


def quarter_circle(file: Path) -> Path:
    a = np.linspace(0.0, np.pi / 2, 60)
    pd.DataFrame({"x": 250 + 120 * np.sin(a), "y": 200 + 120 * (1 - np.cos(a))}).to_csv(file, index=False)
    return file


def run(folder: Path, physics: str, *more: str) -> dict:
    """A short run through the command line; its report."""
    path = quarter_circle(folder / "bend.csv")
    small = ["--set", "learning.samples=120", "--path", str(path), "-o", str(folder / physics)]
    assert main(["run", "car_game", "--physics", physics, *small, *more]) == 0
    return json.loads((folder / physics / "report.json").read_text())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("contact")


@pytest.fixture(scope="module")
def by_contact(folder: Path) -> dict:
    return run(folder, "contact")


def test_all_physics_run_through_the_same_code(by_contact, folder):
    for physics in ("ideal", "arm"):
        other = run(folder, physics)
        assert other["physics"] == physics
        assert set(other["models"]) == set(by_contact["models"])
        assert other["metrics"]["completed"] and by_contact["metrics"]["completed"]
        assert by_contact["metrics"]["mean_error_px"] < 1.6 * other["metrics"]["mean_error_px"]
    play = pd.read_parquet(folder / "contact" / "demonstrations" / "play.parquet")
    assert list(play.columns) == list(pd.read_parquet(folder / "ideal" / "demonstrations" / "play.parquet").columns)


def test_the_hand_holds_the_stick_throughout(folder, by_contact):
    """Once the fingers have closed, in the first tick."""
    play = pd.read_parquet(folder / "contact" / "demonstrations" / "play.parquet")
    assert (play["hand->joystick"].iloc[1:] == 1).all()
    assert by_contact["models"]["hand->joystick"]["samples"] == 120


def test_two_contact_runs_are_the_same(by_contact, tmp_path):
    again = run(tmp_path, "contact")
    for report in (again, by_contact):
        assert report.pop("wall_seconds") > 0
        report.pop("versions")
    assert again == by_contact


def test_the_playback_shows_arm_and_joystick(by_contact, folder):
    page = (folder / "contact" / "playback.html").read_text(encoding="utf-8")
    packed = re.search(r'id="ichain-recording">\s*([^<\s]+)\s*</script>', page)
    assert packed is not None
    data = gzip.decompress(base64.b64decode(packed.group(1)))
    for body in (b"/drake/plant/arm/", b"/drake/plant/gripper/", b"/drake/plant/joystick/", b"/drake/car/screen"):
        assert body in data, body


def test_nothing_joins_gripper_and_joystick():
    """One constraint, there without the stick as well: the finger mimic. No weld; no force but gravity and springs."""
    scenario = load_scenario("car_game", (), "contact", 0)
    assert isinstance(scenario, CarGame)
    start = (np.array([400.0, 300.0, 0.0, 0.0, 0.0, 0.0]), [0.0, 0.4], 0)
    world = scenario.build_world(*start)
    robot = world.robot
    assert isinstance(robot, ArmRobot)
    plant = robot.plant
    arm_alone = load_scenario("car_game", (), "arm", 0).build_world(*start).robot.plant
    assert plant.num_constraints() == arm_alone.num_constraints() == 1
    assert plant.num_force_elements() == 3
    stick = plant.GetModelInstanceByName("joystick")
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        ends = {joint.parent_body().model_instance(), joint.child_body().model_instance()}
        if stick in ends:
            others = {plant.GetModelInstanceName(i) for i in ends - {stick}}
            assert others <= {"WorldModelInstance"}


class GripGame(CarGame):
    """The car game with a hand that can lift and open."""

    def hand_for_tilt(self, tilt: FloatArray) -> FloatArray:
        knob = self.config.joystick.mount().knob_from_tilt(np.asarray(tilt, dtype=float))
        return np.concatenate([knob, np.ones((*knob.shape[:-1], 1))], axis=-1)


class Table(LeafSystem):
    """Sends row k of a table in tick k."""

    def __init__(self, rows: FloatArray) -> None:
        super().__init__()
        self._rows = rows
        self._command = self.DeclareDiscreteState(rows[0])
        self._frame = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("hand_command", self._command)
        self.DeclarePeriodicUnrestrictedUpdateEvent(FRAME, 0.0, self._update)

    def _update(self, context: Context, state: State) -> None:
        frame = int(context.get_discrete_state(self._frame).value()[0])
        discrete = state.get_mutable_discrete_state()
        discrete.set_value(self._command, self._rows[min(frame // FRAMES_PER_TICK, len(self._rows) - 1)])
        discrete.set_value(self._frame, [frame + 1.0])


OPENED = 4  # tick
LIFTED = OPENED + 2


def open_the_gripper(moves: list[tuple[float, float]], held: tuple[float, float]) -> EpisodeLog:
    """Hold the stick at a tilt [deg], open, lift, then move about."""
    scenario = GripGame(
        [
            "robot.hand.exposed=[x, y, z, grip]", "robot.hand.held={}", "robot.hand.surface=null",
            "robot.home={x: 0.5, y: 0.0, z: 0.15, grip: 1.0}",
        ],
        "contact",
    )  # fmt: skip
    world = scenario.build_world(np.array([400.0, 300.0, 0.0, 40.0, 0.0, 0.0]), [0.0, 0.4], 0)
    hold = scenario.hand_for_tilt(np.radians(held))
    opened = hold * [1, 1, 1, 0]
    above = opened + [0, 0, 0.12, 0]
    rows = [hold] * OPENED + [opened] * 2 + [above + [dx, dy, 0, 0] for dx, dy in moves]
    episode = Episode(world, Table(np.array(rows)))
    episode.run(len(rows))
    return episode.log()


def test_opening_the_gripper_frees_stick_and_car():
    still = open_the_gripper([(0.0, 0.0)] * 6, (-10.0, 15.0))
    about = [(0.0, 0.0), (0.06, 0.05), (-0.06, 0.0), (0.0, -0.05), (0.06, 0.0), (0.0, 0.0)]
    busy = open_the_gripper(about, (-10.0, 15.0))
    other = open_the_gripper([(0.0, 0.0)] * 6, (15.0, 10.0))
    opening, after = OPENED * FRAMES_PER_TICK, (OPENED + 1) * FRAMES_PER_TICK

    for log, tilt in ((still, (-10.0, 15.0)), (busy, (-10.0, 15.0)), (other, (15.0, 10.0))):
        active = log.active["joystick"][:, 0]
        assert active[FRAMES_PER_TICK:opening].min() == 1
        assert active[after:].max() == 0
        stick = np.degrees(log.states["joystick"][:, :2])
        np.testing.assert_allclose(stick[opening], tilt, atol=1.0)
        np.testing.assert_allclose(stick[after], 0.0, atol=2.0)  # sprung back
        np.testing.assert_allclose(stick[LIFTED * FRAMES_PER_TICK + FRAMES_PER_TICK :], 0.0, atol=0.2)

    # While held, the car obeys: two tilts drive it apart. Once open, it does not care what the hand does.
    assert np.abs(still.states["car"][after, :3] - other.states["car"][after, :3]).max() > 5.0
    assert np.abs(busy.states["hand"] - still.states["hand"]).max() > 0.05
    np.testing.assert_array_equal(busy.states["car"], still.states["car"])
    assert still.states["car"][-1, 3] < 0.3 * still.states["car"][opening, 3]  # and rolls out

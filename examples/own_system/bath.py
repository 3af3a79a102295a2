"""A bath: hand -> tap -> basin. A hand fills a basin through a tap, and closes it in time."""

from dataclasses import dataclass, field

import numpy as np
from basin import Basin, BasinDrawing
from tap import ENDS, RAIL, Tap, TapDrawing

import ichain_drake as ic


def robot():
    """A hand that moves in a plane 0.2 m over the table, and grips."""
    return ic.RobotSpec(hand=ic.HandSpec(exposed=["x", "y", "grip"], held={"z": 0.2}, noise_std={"x": 5e-4, "y": 5e-4}))


@dataclass
class BathConfig(ic.GraphConfig):
    """What `--set key=value` may change."""

    robot: ic.RobotSpec = field(default_factory=robot)
    goal: list[str] = field(default_factory=lambda: ["0.5 <= basin.level <= 0.6", "not tap->basin", "not hand->tap"])


@dataclass(frozen=True)
class BathStart:
    """What differs from world to world: where the lever is [m], and how full the basin."""

    tap: float
    level: float


class Bath(ic.GraphScenario[BathStart]):
    """Given: where the rail is. Learned: when a hand moves the lever, and what lever and leak do to the water."""

    name = "bath"
    config_class = BathConfig

    def make_graph(self):
        objects = {"hand": self.config.robot.hand.space, "tap": Tap.state_space, "basin": Basin.state_space}
        return ic.InteractionGraph(objects, ["hand->tap", "tap->basin"])

    def draw_start(self, rng):
        return BathStart(rng.uniform(ENDS[0], 0.44), rng.uniform(0.0, 0.2))

    def make_objects(self, start, make):
        return {
            "tap": make(Tap, "tap", initial=np.array([start.tap, RAIL])),
            "basin": make(Basin, "basin", initial=np.array([start.level])),
        }

    def script(self, rng):
        for k in range(8):
            start = BathStart(rng.uniform(*ENDS), rng.uniform(0.0, 0.7))
            hand = self.hand_commands().to(y=RAIL)
            beside = [(0.035, 0.0), (-0.035, 0.0), (0.0, 0.045), (0.0, -0.045), rng.uniform(-0.01, 0.01, 2)]
            for x, y in beside:  # four times nothing happens; then the lever is held
                hand.grip(False).to(start.tap + x, RAIL + y).grip(True)
            for place in rng.uniform(*ENDS, 4):
                hand.to(x=place).wait(int(rng.integers(3, 12)))
            hand.grip(False).to(y=0.0).wait(10)
            yield ic.ScriptedPiece(f"piece_{k}", start, hand.commands)

    def drawings(self):
        return {"tap": TapDrawing(), "basin": BasinDrawing(), **super().drawings()}

    def view(self):
        return ic.Camera((0.1, -0.9, 0.7), (0.57, 0.02, 0.12), 30.0)  # from, to [m], field of view [deg]

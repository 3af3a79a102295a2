"""A hand, a cup, two buttons and a tank in plain numpy, stepped as the world's diagram steps them."""

import numpy as np

from ichain_drake.objects import (
    Button,
    ButtonMount,
    CameraFrame,
    Cup,
    CupFaults,
    CupSettings,
    Surface,
    Tank,
    TankSettings,
)
from ichain_drake.robot import HandSpec
from ichain_drake.timing import FRAME

FORWARD = np.pi / 2
HAND = HandSpec(["x", "y", "z", "roll", "pitch", "grip"], {"yaw": 0.0}).space
TRAY = Surface((0.635, 0.74), (0.01, 0.11), 0.01)


class DispenserLoop:
    """Objects without a diagram; `frame` advances all by 1/30 s under a given hand."""

    def __init__(self, camera: CameraFrame | None = None, faults: CupFaults | None = None) -> None:
        camera = camera or CameraFrame()
        cup = CupSettings(surfaces=(TRAY,), camera=camera, faults=faults or CupFaults())
        self.cup = Cup("cup", {"hand": HAND, "tank": Tank.space(["cup"])}, cup=cup)
        self.power = Button("power", {"hand": HAND}, mount=ButtonMount((0.5, 0.18, 0.06)))
        self.dispense = Button("dispense", {"hand": HAND}, mount=ButtonMount((0.5, 0.26, 0.06)))
        parents = {"cup": Cup.state_space, "dispense": Button.state_space, "power": Button.state_space}
        self.tank = Tank("tank", parents, tank=TankSettings(camera=camera))
        self.objects = {"cup": self.cup, "power": self.power, "dispense": self.dispense, "tank": self.tank}
        self.states = {n: o.default_state() for n, o in self.objects.items()}
        self.active = {n: dict.fromkeys(o.parents, False) for n, o in self.objects.items()}

    def place(self, rim: tuple[float, float, float], water: float, temperature: float) -> None:
        self.states["cup"] = self.cup.state_at(rim, water, temperature)

    def fill(self, amount: float, temperature: float) -> None:
        self.states["tank"] = self.tank.state_at(amount, temperature)

    def frame(self, hand: np.ndarray) -> None:
        """All decide and settle on the states of this instant, then all step on the settled ones."""
        before = self.states | {"hand": hand}
        for name, system in self.objects.items():
            parents = {p: before[p] for p in system.parents}
            self.active[name] = dict(system.decide_active(before[name], parents, self.active[name], None))
            self.states = self.states | {name: np.array(system.settle(before[name], parents, self.active[name]))}
        settled = self.states | {"hand": hand}
        for name, system in self.objects.items():
            parents = {p: settled[p] for p in system.parents}
            active = {p: np.float64(on) for p, on in self.active[name].items()}
            self.states = self.states | {name: system.step(settled[name], parents, active, np.zeros(0), FRAME)}

    def run(self, hand: np.ndarray, frames: int) -> None:
        for _ in range(frames):
            self.frame(hand)

    def value(self, name: str, variable: str) -> float:
        return float(self.states[name][self.objects[name].state_space.index(variable)])

    def water(self) -> float:
        """All there is: in vessels, spilled and in flight."""
        return sum(self.value(n, v) for n, a in (("cup", "water"), ("tank", "amount")) for v in (a, "spilled", "flow"))

    def heat(self) -> float:
        """The same times temperature, less what the heater added."""
        held = sum(self.value(n, a) * self.value(n, "temperature") for n, a in (("cup", "water"), ("tank", "amount")))
        moved = sum(self.value(n, v) for n in ("cup", "tank") for v in ("spilled_heat", "flow_heat"))
        return held + moved - self.value("tank", "heat_added")


def hand(x: float, y: float, z: float, roll: float = 0.0, pitch: float = FORWARD, grip: float = 0.0) -> np.ndarray:
    return np.array([x, y, z, roll, pitch, grip])

"""An environment that nobody here knows: a claw on a table takes hold of a crate and carries it."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from ichain_drake import EnvironmentScenario, EnvironmentSpec, RootTerm, ScriptedPiece
from ichain_drake.state import Role, StateSpace, Variable

REACH = 0.06  # m from the crate's middle, at which closing the claw takes it
STEP = 0.03  # m, the longest step
TABLE = 1.0


class CrateEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """`state`: claw x, y [m], closed; crate x, y [m]; held. Over when the crate falls off the right edge."""

    action_space = gymnasium.spaces.Box(np.array([-STEP, -STEP, 0.0]), np.array([STEP, STEP, 1.0]), dtype=np.float64)
    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (6,), dtype=np.float64)

    def reset(self, *, seed: int | None = None, options: dict | None = None) -> tuple[np.ndarray, dict]:
        super().reset(seed=seed)
        place = self.np_random.uniform([0.1, 0.1, 0.4, 0.4], [0.2, 0.2, 0.6, 0.6])
        self.state = np.array([*place[:2], 0.0, *place[2:], 0.0])
        return self.state.copy(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict]:
        x, y, closed, cx, cy, held = self.state
        dx, dy = np.clip([x + action[0], y + action[1]], 0.0, 1.2) - [x, y]
        closing = bool(action[2] > 0.5)
        near = max(abs(cx - x), abs(cy - y)) < REACH
        held = closing and (bool(held) or (near and not closed))
        if held:
            cx, cy = cx + dx, cy + dy
        self.state = np.array([x + dx, y + dy, float(closing), cx, cy, float(held)])
        return self.state.copy(), float(cx > TABLE), bool(cx > TABLE), False, {}


def _place(frame: str) -> tuple[Variable, Variable]:
    return tuple(Variable(a, "m", 0.0, 1.2, role=Role("position", frame, a)) for a in "xy")  # type: ignore[return-value]


def spec(**changed: Any) -> EnvironmentSpec:
    claw = StateSpace("claw", (*_place("table"), Variable("grip", lower=0, upper=1, kind="binary")))
    declared: dict[str, Any] = {
        "make": CrateEnv,
        "objects": {"claw": claw, "crate": StateSpace("crate", _place("table"))},
        "interactions": ["claw->crate"],
        "actions": (RootTerm("x"), RootTerm("y"), RootTerm("grip", relative=False)),
        "read": lambda env: {"claw": env.state[:3], "crate": env.state[3:5]},
        "active": lambda env: {"claw->crate": env.state[5] > 0.5},
        "steps_per_tick": 2,
        "noise_std": {"crate.x": 5e-4, "crate.y": 5e-4, "claw.x": 5e-4, "claw.y": 5e-4},
    }
    return EnvironmentSpec(**declared | changed)


class CrateScenario(EnvironmentScenario):
    """Bring the crate to the right, and let go of it."""

    name = "crate"

    def environment(self) -> EnvironmentSpec:
        return spec()

    def script(self, rng: np.random.Generator) -> Any:
        for k in range(8):
            start = self.draw_start(rng)
            at = self.start_states(start)
            lay = self.hand_commands(at["claw"])
            crate = at["crate"]
            for miss in rng.uniform(-0.03, 0.03, (2, 2)) + rng.choice([-0.09, 0.09], (2, 2)):
                lay.to(*(crate + miss)).grip(True).to(*(crate + miss + 0.05)).grip(False)
            off = rng.uniform(-0.04, 0.04, 2)
            lay.to(*(crate + off)).wait(2).grip(True).wait(2)
            lay.to(*rng.uniform(0.2, 0.9, 2)).to(*rng.uniform(0.3, 0.9, 2)).wait(2)
            lay.grip(False).wait(2).to(*rng.uniform(0.1, 0.3, 2)).wait(2)
            yield ScriptedPiece(f"carry_{k}", start, lay.commands)

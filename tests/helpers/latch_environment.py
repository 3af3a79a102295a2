"""An environment with latches: bells that stay rung, rung by a claw or by a pole that it carries; a post in the way."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np

from ichain_drake import EnvironmentScenario, EnvironmentSpec, RootTerm, ScriptedPiece
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

STEP = 0.05  # m, the longest step
FAR = 0.6  # m: no further can the claw go along y
LONG = 0.5  # m: the pole, which stands up from where it is held
NEAR = 0.05  # m from the middle of a bell or of the pole's end, within which something is touched
POST = np.array([[0.66, 0.22], [0.74, FAR]])  # m: corners; a step into it does not happen


class BellEnv(gymnasium.Env[FloatArray, FloatArray]):
    """`state`: claw x, y, closed; pole x, y; held; of each bell x, y, rung."""

    def __init__(self, bells: int = 1) -> None:
        self.bells = bells
        self.action_space = gymnasium.spaces.Box(
            np.array([-STEP, -STEP, 0.0]), np.array([STEP, STEP, 1.0]), dtype=np.float64
        )
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (6 + 3 * bells,), dtype=np.float64)

    def reset(self, *, seed: int | None = None, options: dict | None = None) -> tuple[FloatArray, dict]:
        super().reset(seed=seed)
        claw, pole = self.np_random.uniform([0.05, 0.05], [0.5, 0.15]), self.np_random.uniform([0.1, 0.3], [0.5, 0.4])
        bells = self.np_random.uniform([0.9, 0.1, 0.0], [1.4, 1.0, 0.0], (self.bells, 3))
        self.state = np.array([*claw, 0.0, *pole, 0.0, *bells.ravel()])
        return self.state.copy(), {}

    def step(self, action: FloatArray) -> tuple[FloatArray, float, bool, bool, dict]:
        now, state = self.state, self.state.copy()
        state[:2] = np.clip(now[:2] + action[:2], 0.0, [1.5, FAR])
        state[2] = action[2] > 0.5
        if now[5]:
            state[3:5] += state[:2] - now[:2]
        if not ((state[:2] > POST[0]) & (state[:2] < POST[1])).all():  # else nothing of it happens
            near = bool(np.abs(state[3:5] - state[:2]).max() < NEAR)
            state[5] = bool(state[2]) and near
            self.state = state
        for bell in range(self.bells):
            if touches(self.state, bell) or carries_to(self.state, bell):
                self.state[8 + 3 * bell] = 1.0
        return self.state.copy(), 0.0, False, False, {}


def touches(state: FloatArray, bell: int) -> bool:
    """Whether the claw is at a bell."""
    return bool(np.abs(state[6 + 3 * bell : 8 + 3 * bell] - state[:2]).max() < NEAR)


def carries_to(state: FloatArray, bell: int) -> bool:
    """Whether the pole is at it."""
    x, y = state[6 + 3 * bell : 8 + 3 * bell] - state[3:5]
    return bool(abs(x) < NEAR and 0.0 < y < LONG)


def _place(*ends: float) -> tuple[Variable, ...]:
    bounds = zip((0.0, 0.0), ends, strict=True) if ends else ((-np.inf, np.inf),) * 2
    return tuple(Variable(a, "m", *b, role=Role("position", "yard", a)) for a, b in zip("xy", bounds, strict=True))


class BellScenario(EnvironmentScenario):
    """Ring the bell."""

    name = "belfry"
    bells = 1

    def environment(self) -> EnvironmentSpec:
        names = [f"bell{k}" for k in range(self.bells)]
        bell = StateSpace("bell", (*_place(), Variable("rung", lower=0, upper=1, kind="binary")))
        claw = StateSpace("claw", (*_place(1.5, FAR), Variable("grip", lower=0, upper=1, kind="binary")))
        things: dict[str, StateSpace] = {"claw": claw, "pole": StateSpace("pole", _place())}
        slots = {n: slice(6 + 3 * k, 9 + 3 * k) for k, n in enumerate(names)}

        def active(env: Any) -> dict[str, bool]:
            by_claw = {f"claw->{n}": touches(env.state, k) for k, n in enumerate(names)}
            by_pole = {f"pole->{n}": carries_to(env.state, k) for k, n in enumerate(names)}
            return {"claw->pole": env.state[5] > 0.5} | by_claw | by_pole

        return EnvironmentSpec(
            make=lambda: BellEnv(self.bells),
            objects=things | dict.fromkeys(names, bell),
            interactions=["claw->pole", *(f"{p}->{n}" for n in names for p in ("claw", "pole"))],
            actions=(RootTerm("x"), RootTerm("y"), RootTerm("grip", relative=False)),
            read=lambda env: {
                "claw": env.state[:3], "pole": env.state[3:5], **{n: env.state[s] for n, s in slots.items()},
            },
            active=active,
        )  # fmt: skip

    def script(self, rng: np.random.Generator) -> Iterator[ScriptedPiece[int]]:
        for k in range(20):
            start = self.draw_start(rng)
            while k % 2 and self.start_states(start)["bell0"][1] > FAR:
                start = self.draw_start(rng)
            at = self.start_states(start)
            pole, bell = at["pole"], at["bell0"][:2]
            lay = self.hand_commands(at["claw"])
            if k % 2:  # without the pole, past the post
                lay.to(y=0.1).to(x=bell[0] - 0.2).to(y=min(bell[1], FAR)).to(x=bell[0] - 0.08).wait(1)
                lay.to(x=bell[0] + rng.uniform(-0.03, 0.03)).wait(3).to(x=bell[0] + 0.2).wait(1)
            else:
                for miss in rng.uniform(-0.02, 0.02, (2, 2)) + rng.choice([-0.08, 0.08], (2, 2)):
                    lay.to(*(pole + miss)).grip(True).to(*(pole + miss - 0.03)).grip(False)
                off = rng.uniform(-0.03, 0.03, 2)
                lay.to(*(pole + off)).grip(True).wait(1).to(*rng.uniform([0.1, 0.1], [0.5, 0.2]))
                lay.to(y=0.1).to(x=bell[0] - 0.25).to(y=max(0.0, min(FAR, bell[1] - rng.uniform(0.05, LONG - 0.05))))
                for x in (-rng.uniform(0.08, 0.12), rng.uniform(-0.03, 0.03)):
                    lay.to(x=bell[0] + x + off[0]).wait(2)
                if k % 4:
                    lay.to(x=bell[0] + 0.2)
                lay.grip(False).wait(1).to(y=max(0.0, lay.now[1] - 0.12)).wait(1)
            yield ScriptedPiece(f"ring_{k}", start, lay.commands)


class TwoBells(BellScenario):
    """Ring two of them."""

    name = "carillon"
    bells = 2

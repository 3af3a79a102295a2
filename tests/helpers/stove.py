"""A stove with a rival: a hand turns a dial, which heats a pot and lights a lamp; a hand around the lamp keeps it dark.

As long as nobody touches the lamp it shines whenever the pot is heated, so that states can't tell which of the two
heats it.
"""

import numpy as np

import ichain_drake as ic

RAIL, ENDS, ON = 0.10, (0.40, 0.60), 0.50  # m
LAMP = (0.50, -0.10)  # m
HEAT, LOSS = 0.02, 0.002  # 1/s


def _place(x, y):
    return tuple(
        ic.Variable(a, "m", *b, role=ic.Role("position", "robot", a)) for a, b in zip("xy", (x, y), strict=True)
    )


class Dial(ic.WorldObject):
    """A knob on a rail along x; a hand that closes around it takes it along, and it stays where it is let go."""

    state_space = ic.StateSpace("dial", _place(ENDS, (RAIL - 0.01, RAIL + 0.01)))
    immediate = True

    def decide_active(self, state, parents, active, touch):
        x, y, grip = parents["hand"]
        around = abs(x - state[0]) < 0.025 and abs(y - state[1]) < 0.025
        return {"hand": bool(grip > 0.5 and (active["hand"] or around))}

    def step(self, state, parents, active, noise, dt):
        held = np.asarray(active["hand"]) > 0.5
        x = np.where(held, np.clip(parents["hand"][..., 0], *ENDS), state[..., 0])
        return np.stack([x, state[..., 1]], axis=-1)

    def measure(self, state, noise):
        return self.state_space.clip(state + 0.0005 * noise)


class Lamp(ic.WorldObject):
    """It stands still, and shines while the dial is on and no hand is closed around it."""

    state_space = ic.StateSpace(
        "lamp",
        (*_place(*[(c - 0.01, c + 0.01) for c in LAMP]), ic.Variable("light", "1", 0.0, 1.0)),
    )
    immediate = True

    def decide_active(self, state, parents, active, touch):
        x, y, grip = parents["hand"]
        around = abs(x - LAMP[0]) < 0.03 and abs(y - LAMP[1]) < 0.03
        return {"hand": bool(grip > 0.5 and around), "dial": bool(parents["dial"][0] > ON)}

    def step(self, state, parents, active, noise, dt):
        lit = np.asarray(active["dial"]) * (1.0 - np.asarray(active["hand"]))
        return np.stack([state[..., 0], state[..., 1], lit + 0.0 * state[..., 2]], axis=-1)

    def measure(self, state, noise):
        return self.state_space.clip(state + np.array([0.0005, 0.0005, 0.01]) * noise)


class Pot(ic.WorldObject):
    """It gets warmer while the dial is on, and loses warmth all the time."""

    state_space = ic.StateSpace("pot", (ic.Variable("warmth", "1", 0.0, 1.0),))

    def decide_active(self, state, parents, active, touch):
        return {"dial": bool(parents["dial"][0] > ON)}

    def step(self, state, parents, active, noise, dt):
        return np.clip(state + dt * (HEAT * np.asarray(active["dial"])[..., None] - LOSS * state), 0.0, 1.0)

    def measure(self, state, noise):
        return np.clip(state + 0.002 * noise, 0.0, 1.0)


class Stove(ic.GraphScenario):
    """Nothing is scripted: whoever wants to know has to try."""

    name = "stove"

    def make_graph(self):
        self.config.robot.hand = ic.HandSpec(
            exposed=["x", "y", "grip"], held={"z": 0.2}, noise_std={"x": 5e-4, "y": 5e-4}
        )
        objects = {n: k.state_space for n, k in (("dial", Dial), ("pot", Pot), ("lamp", Lamp))}
        edges = ["hand->dial", "dial->pot", "dial->lamp", "hand->lamp"]
        return ic.InteractionGraph({"hand": self.config.robot.hand.space, **objects}, edges)

    def draw_start(self, rng):
        return float(rng.uniform(0.41, 0.47))

    def make_objects(self, start, make):
        return {
            "dial": make(Dial, "dial", initial=np.array([start, RAIL])),
            "pot": make(Pot, "pot", initial=np.array([0.1])),
            "lamp": make(Lamp, "lamp", initial=np.array([*LAMP, 0.0])),
        }

    def script(self, rng):
        return ()

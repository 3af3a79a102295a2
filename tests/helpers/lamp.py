"""A second graph, on the public interface alone: a lamp with a dimmer and a switch, two sliders that a hand moves."""

import numpy as np

import ichain_drake as ic


class Slider(ic.WorldObject):
    """A knob on a rail along x; a hand that closes around it takes it along."""

    state_space = ic.StateSpace("slider", (ic.Variable("x", "m", 0.3, 0.6, role=ic.Role("position", "robot", "x")),))
    immediate, rail = True, 0.0

    def decide_active(self, state, parents, active, touch):
        (x, y, grip), was = parents["hand"], active["hand"]
        return {"hand": bool(grip > 0.5 and (was or (abs(x - state[0]) < 0.02 and abs(y - self.rail) < 0.03)))}

    def step(self, state, parents, active, noise, dt):
        return np.where(np.asarray(active["hand"])[..., None] > 0.5, np.clip(parents["hand"][..., :1], 0.3, 0.6), state)

    def measure(self, state, noise):
        return np.clip(state + 0.001 * noise, 0.3, 0.6)


class Lamp(ic.WorldObject):
    """Shines as the dimmer is set, while the switch is in the right part of its rail."""

    state_space = ic.StateSpace("lamp", (ic.Variable("light", "1", 0.0, 1.0),))

    def decide_active(self, state, parents, active, touch):
        return dict.fromkeys(active, bool(parents["switch"][0] > 0.45))

    def step(self, state, parents, active, noise, dt):
        return np.asarray(active["switch"])[..., None] * (parents["dimmer"] - 0.3) / 0.3

    def measure(self, state, noise):
        return np.clip(state + 0.005 * noise, 0.0, 1.0)


class LampScenario:
    """What `run_graph` asks of a scenario."""

    name, physics, config = "lamp", "ideal", ic.ScenarioConfig()
    spec = ic.RobotSpec(hand=ic.HandSpec(exposed=["x", "y", "grip"], held={"z": 0.2}, noise_std={"x": 5e-4, "y": 5e-4}))
    kinds = {"dimmer": Slider, "switch": Slider, "lamp": Lamp}
    spaces = {"hand": spec.hand.space, **{n: k.state_space for n, k in kinds.items()}}
    graph = ic.InteractionGraph(spaces, ["hand->dimmer", "hand->switch", "dimmer->lamp", "switch->lamp"])

    def __init__(self, overrides=(), physics="ideal", seed=0):
        self.seed = seed

    def make_world(self, run, start=(0.4, 0.35)):
        robot, parts = ic.build_robot(self.spec, "ideal", seed=run), {}
        for k, (name, kind) in enumerate(self.kinds.items()):
            parents = {p: self.spaces[p] for p in self.graph.parents(name)}
            parts[name] = kind(name, parents, np.array([(*start, 0.0)[k]]), ic.ObjectSettings(k + 1, run))
        parts["dimmer"].rail, parts["switch"].rail = -0.15, 0.15
        return ic.World(self.graph, robot, parts)

    def record_demonstrations(self, progress=None, known=()):
        for piece in range(9):
            rng, rows = np.random.default_rng([self.seed, piece]), [np.array([0.45, 0.0, 0.0])]
            places = rng.uniform(0.32, 0.58, 2)
            world = self.make_world(900 + piece, tuple(places))

            def go(x, y, grip, rows=rows):
                rows += [*np.linspace(rows[-1], [x, y, rows[-1][2]], 4)[1:], np.array([x, y, grip])]

            for k in [(0, 1), (1, 0), (piece % 2,)][piece % 3]:
                y = (-0.15, 0.15)[k] + rng.uniform(-0.01, 0.01)
                for miss in (0.035, -0.035, rng.uniform(-0.01, 0.01)):  # beside the knob, then around it
                    go(rows[-1][0], y, 0.0)
                    go(places[k] + miss, y, 1.0)
                    go(places[k] + miss, y, float(abs(miss) < 0.02))
                for x in rng.uniform(0.32, 0.58, 4):
                    go(x, y, 1.0)
                go(x, y, 0.0)
                go(x, 0.0, 0.0)
            commands = ic.Commands(np.array(rows))
            yield ic.record(world, commands, len(rows), list(self.spaces), f"piece {piece}")

    def given(self):
        return {}

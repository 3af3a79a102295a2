"""Learned graphs in small: exact models of a lamp and of a tap, with the samples that demonstrations would give."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from types import SimpleNamespace

import numpy as np

from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.state import FloatArray, Role, StateSpace, Variable

Gate = Callable[[Mapping[str, FloatArray]], FloatArray]
Act = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]
X = Variable("x", "m")
GRIP = Variable("grip", kind="binary", lower=0, upper=1)


class ToyModel:
    """A `InteractionModel` from gates (>= 0: active) and effects; objects in an order in which parents come first."""

    def __init__(
        self,
        graph: InteractionGraph,
        gates: dict[str, Gate],
        acts: dict[str, Act],
        kinds: dict[str, list[str]],
        samples: dict[str, list[dict[str, list[float]]]],
        let_go: dict[str, list[dict[str, list[float]]]],
    ) -> None:
        self.graph = graph
        self.gates = {Interaction.parse(k): v for k, v in gates.items()}
        self.acts = {Interaction.parse(k): v for k, v in acts.items()}
        self.passive = {n: SimpleNamespace(variables=[SimpleNamespace(kind=k) for k in v]) for n, v in kinds.items()}
        every = [s for group in (*samples.values(), *let_go.values()) for s in group]
        sizes = {n: len(s.observable) for n, s in graph.objects.items()}
        self.low = {n: np.min([s[n] for s in every], axis=0).astype(float) for n in sizes}
        self.high = {n: np.max([s[n] for s in every], axis=0).astype(float) for n in sizes}
        self.step_limit = {n: np.full(k, 0.1) for n, k in sizes.items()}
        self.noise = {n: np.full(k, 1e-4) for n, k in sizes.items()}
        self.edges = {}
        for e in graph.interactions:
            rows = {n: np.array([s[n] for s in samples[e.name]], dtype=float) for n in sizes}
            ends = {
                n: np.array([s[n] for s in let_go.get(e.name, [])], dtype=float).reshape(-1, sizes[n]) for n in sizes
            }
            probes = [self.acts[e](rows[e.parent], rows[e.parent] + push, rows[e.child]) for push in (0.05, -0.05)]
            effects = [SimpleNamespace(variable=i) for i in np.flatnonzero(np.abs(probes).max(axis=(0, 1)) > 0)]
            examples = SimpleNamespace(active=rows, inactive=ends, deactivations=SimpleNamespace(after=ends))
            step = np.full(sizes[e.parent], 0.1)
            self.edges[e] = SimpleNamespace(
                effects=effects, examples=examples, alignment=None, relative=False, active_step=step
            )

    def with_noise(self, noise: dict[str, FloatArray]) -> ToyModel:
        other = copy.copy(self)
        other.noise = noise
        return other

    def acting(self, robot: str) -> ToyModel:
        other = copy.copy(self)
        other.graph = self.graph.acting(robot)
        return other

    def customary(self, edge: Interaction) -> tuple[str, ...]:
        return ()

    def suspects(self, edge: Interaction) -> tuple[str, ...]:
        return (edge.child, *self.graph.parents(edge.child))

    def decide(self, edge, states):
        return self.gates[edge]({n: np.atleast_2d(v) for n, v in states.items()}).reshape(
            np.shape(states[edge.child])[:-1]
        )

    def probability(self, edge, states):
        return np.where(self.decide(edge, states) >= 0, 0.98, 0.02)

    def spread(self, child, active):
        return self.noise[child]

    def active(self, states):
        return {e: self.decide(e, states) >= 0 for e in self.graph.interactions}

    def effect(self, edge, states, parent_next):
        return self.acts[edge](states[edge.parent], np.asarray(parent_next), states[edge.child])

    def step(self, states, root_next, active=None, *, strict=True):
        after, on = {r: np.array(states[r], dtype=float) for r in self.graph.roots}, {}
        given = root_next if isinstance(root_next, Mapping) else {self.graph.root: root_next}
        after |= {name: np.array(value, dtype=float) for name, value in given.items()}
        for child in self.passive:
            now, space = states[child], self.graph.objects[child].observable
            kinds = np.array([v.kind for v in self.passive[child].variables])
            ahead = np.where(kinds == "hold", now, 0.0)
            for e in self.graph.incoming(child):
                on[e] = np.asarray(active[e] if active else self.decide(e, {**states, **after, child: now}) >= 0)
                ahead = ahead + on[e][..., None] * self.acts[e](states[e.parent], after[e.parent], now)
            ahead = space.clip(ahead)
            for i in np.flatnonzero(kinds == "change"):
                k = space.index(space.variables[i].role.of)
                ahead[..., i] = ahead[..., k] - now[..., k]
            after[child] = ahead
        return after, on


def near(states: Mapping[str, FloatArray], obj: str, other: str) -> FloatArray:
    """How surely a closed robot holds a slider."""
    close = 0.03 - np.abs(states[obj][:, 0] - states[other][:, 0])
    return np.minimum(close, states[obj][:, -1] - 0.5)


def moved(parent: FloatArray, parent_next: FloatArray, child: FloatArray) -> FloatArray:
    """A child whose first variable moves with the parent's first."""
    out = np.zeros_like(child)
    out[..., 0] = parent_next[..., 0] - parent[..., 0]
    return out


def lamp() -> ToyModel:
    """Robot slides a dimmer at y = 0 and a switch at y = 1; while that is on the lamp shines as dimmed."""
    slider = StateSpace("slider", (X,))
    spaces = {"robot": StateSpace("robot", (X, Variable("y", "m"), GRIP)), "dimmer": slider, "switch": slider}
    spaces["lamp"] = StateSpace("lamp", (Variable("light", lower=0.0, upper=1.0),))
    graph = InteractionGraph(spaces, ["robot->dimmer", "robot->switch", "dimmer->lamp", "switch->lamp"])

    def at(x: float, y: float, grip: float, dimmer: float, switch: float) -> dict[str, list[float]]:
        return {
            "robot": [x, y, grip],
            "dimmer": [dimmer],
            "switch": [switch],
            "lamp": [(0.8 * dimmer + 0.1) * (switch > 0.5)],
        }

    on = lambda s: s["switch"][:, 0] - 0.5  # noqa: E731
    dims = [at(v, 0.0, 1.0, v, 0.8) for v in (0.0, 0.4, 1.0)] + [at(0.3, 0.0, 1.0, 0.3, 0.2)]
    throws = [at(v, 1.0, 1.0, 0.5, v) for v in (0.1, 0.9)]
    return ToyModel(
        graph,
        {
            "robot->dimmer": lambda s: np.minimum(near(s, "robot", "dimmer"), 0.2 - np.abs(s["robot"][:, 1])),
            "robot->switch": lambda s: np.minimum(near(s, "robot", "switch"), 0.2 - np.abs(s["robot"][:, 1] - 1.0)),
            "dimmer->lamp": on,
            "switch->lamp": on,
        },
        {
            "robot->dimmer": moved,
            "robot->switch": moved,
            "dimmer->lamp": lambda p, q, c: 0.8 * q,
            "switch->lamp": lambda p, q, c: np.full_like(c, 0.1),
        },
        {"dimmer": ["hold"], "switch": ["hold"], "lamp": ["constant"]},
        {"robot->dimmer": dims, "robot->switch": throws, "dimmer->lamp": dims[:3], "switch->lamp": throws[1:]},
        {
            "robot->dimmer": [at(v, 0.0, 0.0, v, 0.8) for v in (0.0, 1.0)],
            "robot->switch": [at(v, 1.0, 0.0, 0.5, v) for v in (0.1, 0.9)],
        },
    )


LAMP_START = {
    "robot": np.array([0.5, 0.5, 0.0]),
    "dimmer": np.array([0.3]),
    "switch": np.array([0.2]),
    "lamp": np.zeros(1),
}


def tap() -> ToyModel:
    """A cup that slides along x; a tap at x = 2 lets a tank's water out at x = 1."""
    water = Variable("water", lower=0.0, upper=1.0, role=Role("amount"))
    spaces = {
        "robot": StateSpace("robot", (X, GRIP)),
        "tap": StateSpace("tap", (Variable("level", lower=0.0, upper=1.0),)),
        "tank": StateSpace("tank", (water, Variable("change", role=Role("change", of="water")))),
        "cup": StateSpace("cup", (X, water)),
    }
    graph = InteractionGraph(spaces, ["robot->cup", "robot->tap", "tap->tank", "tank->cup"])

    def at(x: float, grip: float, cup: float, tank: float = 0.8) -> dict[str, list[float]]:
        pressed = abs(x - 2.0) < 0.05
        return {"robot": [x, grip], "tap": [float(pressed)], "tank": [tank, -0.04 * pressed], "cup": [cup, 0.1]}

    def fall(p: FloatArray, q: FloatArray, c: FloatArray) -> FloatArray:
        return np.stack([np.zeros(len(c)), -q[:, 1]], axis=1)

    presses = [at(2.0, 0.0, 1.0), at(2.01, 0.0, 0.0), at(2.01, 0.0, 1.0, 0.5), at(1.99, 0.0, 1.01, 0.0)]
    carries = [at(v, 1.0, v) for v in (0.0, 0.5, 1.0)]
    return ToyModel(
        graph,
        {
            "robot->cup": lambda s: near(s, "robot", "cup"),
            "robot->tap": lambda s: 0.05 - np.abs(s["robot"][:, 0] - 2.0),
            "tap->tank": lambda s: s["tap"][:, 0] - 0.5,
            "tank->cup": lambda s: 0.05 - np.abs(s["cup"][:, 0] - 1.0),
        },
        {
            "robot->cup": moved,
            "robot->tap": lambda p, q, c: np.ones_like(c),
            "tap->tank": lambda p, q, c: np.array([-0.04, 0.0]) * np.ones_like(c),
            "tank->cup": fall,
        },
        {"tap": ["constant"], "tank": ["hold", "change"], "cup": ["hold", "hold"]},
        {"robot->cup": carries, "robot->tap": presses, "tap->tank": presses, "tank->cup": presses[:1] + presses[2:3]},
        {"robot->cup": [at(v, 0.0, v) for v in (0.0, 0.5, 1.0)], "robot->tap": [at(1.8, 0.0, 1.0)]},
    )


TAP_START = {
    "robot": np.array([0.3, 0.0]),
    "tap": np.zeros(1),
    "tank": np.array([0.8, 0.0]),
    "cup": np.array([0.2, 0.05]),
}


def two_hands() -> ToyModel:
    """Two robots, a flap at y = 0 that a spring shuts, a valve at y = 1: a bucket fills while both are open."""
    slider, robot = StateSpace("slider", (X,)), StateSpace("robot", (X, Variable("y", "m"), GRIP))
    spaces = {"one": robot, "other": robot, "flap": slider, "valve": slider}
    spaces["bucket"] = StateSpace("bucket", (Variable("filled", lower=0.0, upper=1.0),))
    mine = [f"{r}->{n}" for n in ("flap", "valve") for r in ("one", "other")]
    graph = InteractionGraph(spaces, [*mine, "flap->bucket", "valve->bucket"], robots=("one", "other"))
    away = [0.5, 0.5, 0.0]

    def at(flap: float = 0.0, valve: float = 0.0, **robots: list[float]) -> dict[str, list[float]]:
        return {"one": away, "other": away, "flap": [flap], "valve": [valve], "bucket": [0.2]} | robots

    def holds(robot: str, y: float) -> Gate:
        return lambda s: np.minimum(near(s, robot, "flap" if y == 0.0 else "valve"), 0.2 - np.abs(s[robot][:, 1] - y))

    ajar = lambda s: s["flap"][:, 0] - 0.3  # noqa: E731
    fills = lambda s: np.minimum(s["valve"][:, 0] - 0.5, ajar(s))  # noqa: E731
    gates: dict[str, Gate] = {"flap->bucket": ajar, "valve->bucket": fills}
    acts: dict[str, Act] = {
        "flap->bucket": lambda p, q, c: np.zeros_like(c),
        "valve->bucket": lambda p, q, c: np.full_like(c, 0.02) * (q[..., :1] > 0.5),
    }
    samples: dict[str, list[dict[str, list[float]]]] = {"flap->bucket": [], "valve->bucket": []}
    let_go = {}
    for me, it in (("one", "other"), ("other", "one")):
        opens = [at(v, **{me: [v, 0.0, 1.0]}) for v in (0.1, 0.4, 0.6)]
        turns = [at(0.0, v, **{me: [v, 1.0, 1.0]}) for v in (0.0, 0.4, 0.9)]
        both = [at(0.6, v, **{it: [0.6, 0.0, 1.0], me: [v, 1.0, 1.0]}) for v in (0.2, 0.7, 0.9)]
        gates |= {f"{me}->flap": holds(me, 0.0), f"{me}->valve": holds(me, 1.0)}
        acts |= {f"{me}->flap": lambda p, q, c: q[..., :1].copy(), f"{me}->valve": moved}
        samples |= {f"{me}->flap": opens, f"{me}->valve": [*turns, *both]}
        samples["flap->bucket"] += [*opens[1:], *both]
        samples["valve->bucket"] += both[1:]
        let_go[f"{me}->flap"] = [at(0.0, 0.0, **{me: [v, 0.0, 0.0]}) for v in (0.4, 0.6)]
        let_go[f"{me}->valve"] = [at(0.0, v, **{me: [v, 1.0, 0.0], "bucket": [v]}) for v in (0.0, 0.9)]
    kinds = {"flap": ["constant"], "valve": ["hold"], "bucket": ["hold"]}
    return ToyModel(graph, gates, acts, kinds, samples, let_go)


TWO_HANDS_START = {
    "one": np.array([0.5, 0.5, 0.0]),
    "other": np.array([0.5, 0.5, 0.0]),
    "flap": np.zeros(1),
    "valve": np.zeros(1),
    "bucket": np.array([0.2]),
}

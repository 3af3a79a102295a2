"""The world's diagram: timing, wiring, noise, cycles, replay, drop-outs."""

from typing import Any, ClassVar

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from small_car_world import HOME, MOUNT, Rig, car_world, hand_spec, random_commands

from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.noise import NoiseStream
from ichain_drake.objects import Car, Joystick, ObjectSettings, WorldObject
from ichain_drake.robot import IdealHand
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import FRAME
from ichain_drake.world import World

STATES = ("hand.state", "stick.state", "car.state")


def test_a_decision_is_in_force_in_the_first_frame_after_it_at_every_tick() -> None:
    """300 of 300: the set-point has gone the first quarter of its way one frame after each decision."""
    commands = random_commands(300)
    hand = Rig(car_world(), commands).step(3000, ["hand.state"])["hand.state"]
    start = np.concatenate([[HOME[:2]], commands[:-1]])
    first = np.abs(hand[1::10] - (start + (commands - start) / 4)).max(axis=1)
    assert np.count_nonzero(first < 1e-12) == 300


def test_the_car_is_driven_by_the_hand_of_the_same_instant() -> None:
    """The joystick is immediate: from t to t + 1/30 s the car sees the axes that the hand gives at t."""
    rows = Rig(car_world(), random_commands(30)).step(300, STATES)
    car = Car("alone", {"stick": Joystick.state_space})
    noise = NoiseStream(3, 2, "process", tuple(range(5)))
    axes = Joystick.state_at_tilt(MOUNT.tilt_from_knob(rows["hand.state"]))
    for k in range(300):
        after = car.step(rows["car.state"][k], {"stick": axes[k]}, {"stick": np.float64(1)}, noise.at(k), FRAME)
        np.testing.assert_array_equal(after, rows["car.state"][k + 1])


def test_systems_and_connections_mirror_the_graph() -> None:
    world = car_world()
    assert [s.get_name() for s in world.GetSystems()] == ["hand", "stick", "car"]
    wires = {
        (source[0].get_name(), source[0].get_output_port(source[1]).get_name(), to[0].get_name())
        for to, source in world.connection_map().items()
    }
    assert wires == {("hand", "state", "stick"), ("stick", "state", "car")}
    assert world.system("hand") is world.robot
    with pytest.raises(InputError, match="no object 'boat'; it has hand, stick, car"):
        world.system("boat")


def run_all(world: World, names: tuple[str, str, str], first: str = "world") -> np.ndarray:
    ports = [f"{n}.{p}" for n in names for p in ("state", "measured")]
    rows = Rig(world, random_commands(20), first).step(200, ports)
    return np.concatenate([rows[p] for p in ports], axis=1)


def test_noise_depends_on_ids_alone() -> None:
    """Other names, another declared order, another order of wiring: the same bits. Another id or seed: others."""
    names = ("hand", "stick", "car")
    plain = run_all(car_world(), names)
    others = ("qrx", "zab", "abc")
    np.testing.assert_array_equal(run_all(car_world(others), others), plain)
    reordered = car_world(order=lambda items: items[::-1])
    np.testing.assert_array_equal(run_all(reordered, names, first="commands"), plain)
    assert not np.array_equal(run_all(car_world(seed=4), names), plain)
    assert not np.array_equal(run_all(car_world(settings={"car": ObjectSettings(9, 3)}), names), plain)


def test_a_cloned_context_has_the_same_future() -> None:
    rig = Rig(car_world(), random_commands(20))
    rig.step(47)
    ports = ("hand.state", "stick.measured", "car.measured", "car.state")
    copies = []
    for _ in range(2):
        copy = Simulator(rig.diagram, rig.context.Clone())
        copy.AdvanceTo(147 * FRAME)
        copies.append([rig.read(p, copy.get_context()) for p in ports])
    rig.step(100)
    for port, one, two in zip(ports, *copies, strict=True):
        np.testing.assert_array_equal(one, two)
        np.testing.assert_array_equal(one, rig.read(port))


def test_a_drop_out_shows_at_the_worlds_ports_and_leaves_the_truth_alone() -> None:
    lost = {"car": ObjectSettings(2, 3, dropouts=((2.5 * FRAME, 6.5 * FRAME),))}
    ports = ("car.measured", "car.valid", "car.state")
    with_loss, without = (Rig(car_world(settings=s), random_commands(2)).step(10, ports) for s in (lost, None))
    np.testing.assert_array_equal(with_loss["car.valid"][:, 0], [1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1])
    np.testing.assert_array_equal(with_loss["car.measured"][3:7], np.repeat(without["car.measured"][2:3], 4, axis=0))
    np.testing.assert_array_equal(with_loss["car.measured"][7:], without["car.measured"][7:])
    np.testing.assert_array_equal(with_loss["car.state"], without["car.state"])


class Mass(WorldObject):
    """Drawn to each of its parents by a spring, in one dimension."""

    state_space: ClassVar[StateSpace] = StateSpace("mass", (Variable("place", "m"), Variable("speed", "m/s")))
    process_noise_size: ClassVar[int] = 1

    def step(self, state: Any, parents: Any, active: Any, noise: Any, dt: float) -> Any:
        place, speed = np.moveaxis(state, -1, 0)
        pull = sum(active[p] * (v[..., 0] - place) for p, v in parents.items())
        speed = speed + dt * (20.0 * pull - speed) + 0.01 * noise[..., 0]
        return np.stack([place + dt * speed, speed], axis=-1)


class Follower(Mass):
    """The same, but sampled at the instant itself."""

    immediate: ClassVar[bool] = True


@pytest.mark.parametrize("kind_of_a", [Mass, Follower])
def test_a_cyclic_world_builds_and_equals_a_plain_loop(kind_of_a: type[Mass]) -> None:
    """A <-> B, with the hand at A."""
    spec = hand_spec()
    spaces = {"hand": spec.space, "a": Mass.state_space, "b": Mass.state_space}
    graph = InteractionGraph(spaces, ["hand->a", "b->a", "a->b"])
    parents = {n: {p: spaces[p] for p in graph.parents(n)} for n in ("a", "b")}
    start = {"a": np.array([0.4, 0.0]), "b": np.array([0.6, 0.1])}
    objects = {
        "a": kind_of_a("a", parents["a"], start["a"], ObjectSettings(1, 0)),
        "b": Mass("b", parents["b"], start["b"], ObjectSettings(2, 0)),
    }
    world = World(graph, IdealHand(spec, spec.full(HOME[:2])), objects)
    rows = Rig(world, random_commands(20)).step(200, ["hand.state", "a.state", "b.state"])

    (a, va), (b, vb) = start["a"], start["b"]
    noise = {n: NoiseStream(0, i, "process", (0,)) for n, i in (("a", 1), ("b", 2))}
    for k in range(200):
        old_a = a
        va += FRAME * (20.0 * ((rows["hand.state"][k, 0] - a) + (b - a)) - va) + 0.01 * noise["a"].at(k)[0]
        a += FRAME * va
        seen = a if kind_of_a is Follower else old_a
        vb += FRAME * (20.0 * (seen - b) - vb) + 0.01 * noise["b"].at(k)[0]
        b += FRAME * vb
        np.testing.assert_allclose(rows["a.state"][k + 1], [a, va], rtol=0, atol=1e-12)
        np.testing.assert_allclose(rows["b.state"][k + 1], [b, vb], rtol=0, atol=1e-12)


def small_graph(child: StateSpace = Mass.state_space, **more: StateSpace) -> InteractionGraph:
    return InteractionGraph({"hand": hand_spec().space, "a": child, **more}, ["hand->a", *(f"hand->{n}" for n in more)])


HAND_SPACE = hand_spec().space
OTHER = StateSpace("mass", (Variable("place", "cm"), Variable("speed", "m/s")))


@pytest.mark.parametrize(
    ("graph", "name", "parents", "message"),
    [
        (small_graph(b=OTHER), "a", {"hand": HAND_SPACE}, "objects and graph differ: b is in only one"),
        (small_graph(), "other", {"hand": HAND_SPACE}, "object a is a system named 'other'"),
        (small_graph(OTHER), "a", {"hand": HAND_SPACE}, "object a: the graph declares another state space"),
        (small_graph(), "a", {"b": HAND_SPACE}, r"object a was built for parents \['b'\], the graph has \['hand'\]"),
        (small_graph(), "a", {"hand": OTHER}, "object a: it expects another state space of its parent hand"),
    ],
)
def test_objects_that_do_not_fit_the_graph_are_named(
    graph: InteractionGraph, name: str, parents: dict[str, StateSpace], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        World(graph, IdealHand(hand_spec(), hand_spec().full(HOME[:2])), {"a": Mass(name, parents)})


def test_a_robot_that_does_not_fit_the_graph_is_named() -> None:
    graph = InteractionGraph({"hand": OTHER.subspace(["place"]), "a": Mass.state_space}, ["hand->a"])
    mass = Mass("a", {"hand": OTHER.subspace(["place"])})
    with pytest.raises(InputError, match="robot hand: its port state has 2 values, the graph declares 1"):
        World(graph, IdealHand(hand_spec(), hand_spec().full(HOME[:2])), {"a": mass})

"""The numpy reference of the world against the diagram, and against itself in batches."""

import numpy as np
from small_car_world import HOME, Rig, car_world, hand_frames, random_commands

from ichain_drake.noise import NoiseStream
from ichain_drake.world import WorldReference

NAMES = ("hand", "stick", "car")


def test_the_diagram_and_the_reference_agree() -> None:
    """50 ticks with noise on and commands at 3 Hz; the reference is given the values of the same noise streams."""
    world, commands = car_world(), random_commands(50)
    rows = Rig(world, commands).step(500, [f"{n}.state" for n in NAMES])
    streams = {"stick": NoiseStream(3, 1, "process", ()), "car": NoiseStream(3, 2, "process", (0, 1, 2, 3, 4))}
    reference = WorldReference(world.graph, world.objects, hand_frames)
    states = {n: rows[f"{n}.state"][0] for n in NAMES}
    frames: list[dict[str, np.ndarray]] = []
    for tick, command in enumerate(commands):
        noise = lambda name, frame, tick=tick: streams[name].at(10 * tick + frame)  # noqa: E731
        states = reference.tick(states, command, noise, frames)
    assert len(frames) == 500
    for name in NAMES:
        got = np.array([f[name] for f in frames])
        np.testing.assert_allclose(got, rows[f"{name}.state"][1:], rtol=0, atol=1e-12)
        assert np.ptp(got, axis=0).max() > 0.01  # everything moved


def test_a_batch_gives_what_its_rows_give() -> None:
    world = car_world()
    reference = WorldReference(world.graph, world.objects, hand_frames)
    rng = np.random.default_rng(0)
    states = {
        "hand": HOME[:2] + rng.uniform(-0.02, 0.02, (4, 2)),
        "stick": rng.uniform(-0.1, 0.1, (4, 4)),
        "car": rng.uniform(0, 20, (4, 6)),
    }
    commands = random_commands(4)
    batch = reference.tick(states, commands)
    for i in range(4):
        row = reference.tick({n: s[i] for n, s in states.items()}, commands[i])
        for name in NAMES:
            np.testing.assert_allclose(batch[name][i], row[name], rtol=0, atol=1e-12)

"""`check_object`: the contract of a world object, checked on a live system. For a user's own objects too."""

from __future__ import annotations

import numpy as np
from pydrake.systems.analysis import Simulator

from ichain_drake.errors import IchainError
from ichain_drake.objects.base import WorldObject
from ichain_drake.state import FloatArray
from ichain_drake.timing import FRAME

_OUTPUTS = ("state", "measured", "valid", "active")
_BATCH = (2, 3)
_FRAMES = 12
_AGAIN = 20  # steps of one batch that must all be the same


class ContractError(IchainError, AssertionError):
    """An object breaks its contract; the message says which clause and how to mend it."""


def _require(condition: bool, name: str, message: str) -> None:
    if not condition:
        raise ContractError(f"{name}: {message}")


def check_object(system: WorldObject) -> None:
    """Check everything that the library relies on in a world object.

    Ports and their sizes, no feedthrough to `state`, a `step` that draws no noise of its own, leaves its arguments
    alone, accepts leading batch dimensions and agrees with itself row by row, a `measure` of the right shape, finite
    values, noise that is a function of the seed, and a context that replays.

    Args:
        system: an object that is not yet part of a diagram. It is left as it was.

    Raises:
        ContractError: naming the clause that is broken.
    """
    name = system.get_name()
    _check_ports(system, name)
    _check_step(system, name)
    _check_replay(system, name)


def _check_ports(system: WorldObject, name: str) -> None:
    space = system.state_space
    for port, size in zip(_OUTPUTS, (len(space), len(space.observable), 1, len(system.parents)), strict=True):
        _require(system.HasOutputPort(port), name, f"has no output port {port!r}; call super().__init__ first")
        got = system.GetOutputPort(port).size()
        _require(got == size, name, f"output port {port!r} has size {got}, not {size}")
    for parent, parent_space in system.parents.items():
        _require(system.HasInputPort(parent), name, f"has no input port for its parent {parent!r}")
        _require(
            system.GetInputPort(parent).size() == len(parent_space),
            name,
            f"input port {parent!r} does not carry the parent's {len(parent_space)} variables",
        )
    state_port = system.GetOutputPort("state").get_index()
    _require(
        not system.HasDirectFeedthrough(state_port),
        name,
        "its `state` port depends directly on an input; cyclic graphs would not build",
    )
    _require(
        len(space.plant_indices) == 0 or type(system).sample_body is not WorldObject.sample_body,
        name,
        "has variables measured in the plant but does not implement sample_body",
    )


def _check_step(system: WorldObject, name: str) -> None:
    space = system.state_space
    rng = np.random.default_rng(0)
    start = np.asarray(system.default_state(), dtype=float)
    _require(start.shape == (len(space),), name, f"default_state has shape {start.shape}, not ({len(space)},)")
    _require(bool(np.isfinite(start).all()), name, "default_state is not finite")
    states = np.broadcast_to(start, (*_BATCH, len(space))).copy()
    parents = {p: 0.01 * rng.standard_normal((*_BATCH, len(s))) for p, s in system.parents.items()}
    active = {p: np.ones(_BATCH) for p in system.parents}
    noise = rng.standard_normal((*_BATCH, system.process_noise_size))
    # A batch of one, twice, before the real batch: a step that draws is not to be blamed on its vectorisation.
    once = [_first_row(system, states, parents, active, noise) for _ in range(2)]
    _require(np.shape(once[0]) == start.shape, name, f"step turned shape {start.shape} into {np.shape(once[0])}")
    _require(
        bool(np.array_equal(once[0], once[1], equal_nan=True)),
        name,
        "two steps from one state differ; draw no own noise, use the argument `noise`",
    )
    given = [a.copy() for a in (states, *parents.values(), noise)]
    try:
        result = system.step(states, parents, active, noise, FRAME)
    except (ValueError, TypeError, IndexError) as error:
        raise ContractError(
            f"{name}: step fails on a batch ({str(error)[:80]}); vectorise over leading dimensions"
        ) from error
    _require(
        all(np.array_equal(a, b) for a, b in zip(given, (states, *parents.values(), noise), strict=True)),
        name,
        "step changes the arrays that it is given; work on a copy",
    )
    _require(np.shape(result) == states.shape, name, f"step turned shape {states.shape} into {np.shape(result)}")
    _require(bool(np.isfinite(result).all()), name, "step gave a value that is not finite")
    for index in np.ndindex(_BATCH):
        row = system.step(
            states[index],
            {p: v[index] for p, v in parents.items()},
            {p: v[index] for p, v in active.items()},
            noise[index],
            FRAME,
        )
        if np.allclose(row, result[index], rtol=1e-12, atol=1e-12):
            continue
        # A generator of its own may show in some rows, or now and then: the same batch again tells which it is.
        again = [system.step(states, parents, active, noise, FRAME) for _ in range(_AGAIN)]
        _require(
            all(np.array_equal(other, result) for other in again),
            name,
            "two steps from one state differ; draw no own noise, use the argument `noise`",
        )
        _require(False, name, "step gives other values for a batch than row by row; vectorise over leading dimensions")
    read = system.measure(result, rng.standard_normal((*_BATCH, len(space.observable))))
    _require(np.shape(read) == (*_BATCH, len(space.observable)), name, f"measure gave shape {np.shape(read)}")
    modes = system.decide_active(
        start, {p: v[0, 0] for p, v in parents.items()}, dict.fromkeys(system.parents, False), None
    )
    _require(set(modes) == set(system.parents), name, "decide_active must decide on every parent, and on no other")


def _first_row(
    system: WorldObject,
    states: FloatArray,
    parents: dict[str, FloatArray],
    active: dict[str, FloatArray],
    noise: FloatArray,
) -> FloatArray:
    first = (0,) * len(_BATCH)
    row = [{p: v[first].copy() for p, v in values.items()} for values in (parents, active)]
    return np.array(system.step(states[first].copy(), row[0], row[1], noise[first].copy(), FRAME), dtype=float)


def _check_replay(system: WorldObject, name: str) -> None:
    if system.settings.body_size:
        return  # its inputs need a plant; the world's own tests replay it
    context = system.CreateDefaultContext()
    for parent in system.parents:
        port = system.GetInputPort(parent)
        port.FixValue(context, np.full(port.size(), 0.01))
    values = []
    for _ in range(2):
        simulator = Simulator(system, context.Clone())
        simulator.Initialize()
        simulator.AdvanceTo(_FRAMES * FRAME)
        final = simulator.get_context()
        values.append(np.concatenate([system.GetOutputPort(p).Eval(final) for p in _OUTPUTS]))
    _require(bool(np.array_equal(values[0], values[1])), name, "two runs from one context differ; draw no own noise")

"""Making the objects of one world, each with what the graph and the run say about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from ichain_drake.graph import InteractionGraph
from ichain_drake.objects.base import ObjectSettings, WorldObject
from ichain_drake.scenarios.faults import Faults
from ichain_drake.state import FloatArray

ObjectT = TypeVar("ObjectT", bound=WorldObject)


class ObjectMaker:
    """Makes objects; call it with their class and name.

    Its place in the graph is an object's number, which keys its noise.

    Args:
        graph: the interaction graph; gives names, numbers and parents.
        seed: of the world's noise.
        noise_scale: factor on the noise.
        body_sizes: length of [q; v] of the bodies in the plant, by object name.
        faults: what goes wrong in this world.
    """

    def __init__(
        self,
        graph: InteractionGraph,
        seed: int = 0,
        noise_scale: float = 1.0,
        body_sizes: Mapping[str, int] | None = None,
        faults: Faults | None = None,
    ) -> None:
        self.faults = faults or Faults()
        self._graph, self._seed, self._noise_scale = graph, seed, noise_scale
        self._numbers = {name: k for k, name in enumerate(graph.objects)}
        self._body_sizes = dict(body_sizes or {})

    @property
    def mishap(self) -> Faults:
        """`faults` by the name that it had before; people's systems that were written with it go on working."""
        return self.faults

    def __call__(
        self,
        kind: Callable[..., ObjectT],
        name: str,
        initial: FloatArray | Callable[[ObjectT], FloatArray] | None = None,
        *,
        dropouts: tuple[tuple[float, float], ...] = (),
        **given: Any,
    ) -> ObjectT:
        """An object.

        Args:
            kind: its class.
            name: in the graph.
            initial: state at t = 0, shape (n_variables,), or what gives it for such an object, as `state_at` of some
                does; default the object's own.
            dropouts: intervals in which its sensor gives nothing [s].
            given: further arguments of its class.
        """
        parents = {p: self._graph.objects[p] for p in self._graph.parents(name)}
        size = self._body_sizes.get(name, 0)
        settings = ObjectSettings(self._numbers[name], self._seed, self._noise_scale, dropouts, size)
        if callable(initial):
            initial = initial(kind(name, parents, settings=settings, **given))
        return kind(name, parents, initial=initial, settings=settings, **given)

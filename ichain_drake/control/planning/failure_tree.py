"""Why there is no plan, as a tree in text: each condition, how near it came, and what was tried for it."""

from __future__ import annotations

from ichain_drake.control.planning.failure import Nearest, Tried
from ichain_drake.control.planning.goals import words
from ichain_drake.graph import Interaction


def failure_tree(nearest: Nearest) -> tuple[str, ...]:
    """Lines of the tree; a line deeper in it is indented by two more.

    Args:
        nearest: what a search found.
    """
    graph, lines, told = nearest.model.graph, list[str](), set[tuple[Interaction, ...]]()
    for k, c in enumerate(nearest.goal.conditions):
        off, met = nearest.closest[k], nearest.closest[k] == 0.0
        near = f"nearest {nearest.nearest[k]:.4g}" + ("" if met else f", {off:.4g} short")
        lines.append(f"{words(c, graph)}: {'met by itself' if met else 'never met'}, {near}")
        if met:
            continue
        index = graph.objects[c.object].observable.index(c.variable)
        direction = 1 if nearest.nearest[k] < c.lower else -1
        mine = [
            (key[0], t)
            for key, t in nearest.tried.items()
            if key[0][-1].child == c.object and key[1:] == (index, direction)
        ]
        for chain, tried in sorted(mine, key=lambda m: -m[1].probability):
            lines.append(f"  {_line(chain, 'it', tried)}")
            before = _before(nearest, chain, tried)
            lines += [f"    {_line(*m)}" for m in before]
            told |= {chain, *(m[0] for m in before)}
        if not mine:
            lines.append(f"  nothing drives it {'up' if direction > 0 else 'down'}")
    beside = {key[0]: t for key, t in nearest.tried.items() if t.end is None and key[0] not in told}
    if beside:
        lines.append("beside these never began:")
        lines += [f"  {_line(chain, 'it', tried)}" for chain, tried in beside.items()]
    return tuple(lines)


def _line(chain: tuple[Interaction, ...], what: str, tried: Tried) -> str:
    through = "->".join([chain[0].parent, *(e.child for e in chain)])
    went = "never began" if tried.end is None else f"drove {what} to {tried.end:.4g}"
    why = "" if tried.lost is None else f"; at best {tried.lost.name} was inactive"
    return f"{through}: tried {tried.times} times, {went}, probability at best {tried.probability:.2g}{why}"


def _before(
    nearest: Nearest, chain: tuple[Interaction, ...], tried: Tried
) -> list[tuple[tuple[Interaction, ...], str, Tried]]:
    """What was tried on the object that acts, or whose interaction was inactive: what was missing may be there."""
    obj = (tried.lost or chain[-1]).parent
    names = nearest.model.graph.objects[obj].observable.names
    return [
        (key[0], f"{obj}.{names[key[1]]} {'up' if key[2] > 0 else 'down'}", t)
        for key, t in nearest.tried.items()
        if key[0][-1].child == obj and key[0] != chain
    ]

"""A way around obstacles: RRT-Connect among hand states (Kuffner & LaValle 2000), then shortcuts.

Both trees hold, beside each hand state, the joints by which the arm comes to it; where they meet, these must agree.
"""

from __future__ import annotations

import numpy as np

from ichain_drake.robot.hand_lines import HandLines, TreeNode
from ichain_drake.state import FloatArray, wrap_angle

_REACH = 0.3  # m around both ends in which to look for a way
_ALIKE = 0.6  # rad or m that joints of the two trees may differ by where they meet
_STEPS = 1500  # ticks that a search may try
_TOWARDS = 0.15  # of the samples are the root of the other tree
_TICKS = 3  # of a step towards a sample
_SHORTCUTS = 100


def find_way(lines: HandLines, rng: np.random.Generator) -> list[FloatArray] | None:
    """Hand states on the way from the start to the goal, one a tick, without the start; None if none was found.

    Args:
        lines: between hand states.
        rng: draws the samples.
    """
    nodes = _search(lines, rng)
    return None if nodes is None else [n.hand for n in _shorten(lines, nodes, rng)[1:]]


def _search(lines: HandLines, rng: np.random.Generator) -> list[TreeNode] | None:
    trees = [[TreeNode(end.hand, end.joints)] for end in lines.ends]
    turn, begun = 0, lines.steps
    while lines.steps - begun < _STEPS:
        tree, other = trees[turn], trees[1 - turn]
        sample = other[0].hand if rng.uniform() < _TOWARDS else _sample(lines, rng)
        reached = _extend(lines, tree, sample, _TICKS)
        if reached is not None:
            met = _extend(lines, other, reached.hand, _STEPS)
            if met is not None and met.hand is reached.hand and _alike(met, reached):
                forth, back = (reached, met) if turn == 0 else (met, reached)
                first = _chain(forth)[::-1]
                # The second half was only tried out backwards.
                second = lines.follow(first[-1], [n.hand for n in _chain(back)[1:]])
                if second is not None:
                    return first + second
        turn = 1 - turn
    return None


def _sample(lines: HandLines, rng: np.random.Generator) -> FloatArray:
    """A place around both ends; all else is between them, so that what is the same at both stays as it is."""
    start, end = (n.hand for n in lines.ends)
    space, place = lines.space, lines.place
    hand = start + rng.uniform(size=len(start)) * space.difference(end, start)
    low = np.maximum(np.minimum(start, end) - _REACH, space.lower)[place]
    high = np.minimum(np.maximum(start, end) + _REACH, space.upper)[place]
    hand[place] = rng.uniform(low, high)
    hand[lines.grip] = start[lines.grip]
    return hand


def _extend(lines: HandLines, tree: list[TreeNode], goal: FloatArray, ticks: int) -> TreeNode | None:
    """Go from the nearest node towards a state, for some ticks or until something is in the way."""
    node = min(tree, key=lambda n: lines.distance(n.hand, goal))
    last = None
    for hand in lines.points(node.hand, goal)[:ticks]:
        following, _ = lines.step(node, hand)
        if following is None:
            break
        node = last = following
        tree.append(node)
    return last


def _alike(a: TreeNode, b: TreeNode) -> bool:
    return bool(np.abs(wrap_angle(a.joints - b.joints)).max() < _ALIKE)


def _chain(node: TreeNode) -> list[TreeNode]:
    """A node and those before it, back to its tree's root."""
    out = [node]
    while node.parent is not None:
        node = node.parent
        out.append(node)
    return out


def _shorten(lines: HandLines, nodes: list[TreeNode], rng: np.random.Generator) -> list[TreeNode]:
    """Replace parts by straight lines, as long as the arm can still follow the rest of the way."""
    for _ in range(_SHORTCUTS):
        i, j = sorted(int(v) for v in rng.integers(0, len(nodes), 2))
        a, b = nodes[i].hand, nodes[j].hand
        straight = lines.points(a, b) if j > i else []
        if len(straight) >= j - i:
            continue  # saves no tick
        rest = lines.follow(nodes[i], [*straight, *(n.hand for n in nodes[j + 1 :])])
        if rest is not None:
            nodes = nodes[: i + 1] + rest
    return nodes

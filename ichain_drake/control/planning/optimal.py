"""The plan of least expected time over the same options: uniform-cost search below a plan that is known.

The extension of the paper's model collapses a graph to one decision process and solves that; here the collapsed problem
is the search over options, whose costs add up (`risk.step_cost`). States that agree to a twentieth of each demonstrated
range count as the same, the cheapest way to each is kept, and what costs as much as the best plan so far is left out.
"""

from __future__ import annotations

import heapq
from itertools import count

from ichain_drake.control.planning.risk import plan_cost
from ichain_drake.control.planning.search import Search
from ichain_drake.control.planning.search_node import SearchNode
from ichain_drake.control.settings import PLANNING


class OptimalSearch(Search):
    """One search for the cheapest plan; arguments as for `Search`.

    Attributes:
        below: cost of a plan that is known [ticks]; only a cheaper one is sought.
        proved: after `run`, whether nothing cheaper than what was found, or than `below`, is left.
    """

    below: float = float("inf")
    proved: bool = False

    def _from(self, first: SearchNode) -> SearchNode | None:
        best: SearchNode | None = None
        order = count()
        frontier = [(first.cost, next(order), first)]
        cheapest = {self._key(first): first.cost}
        while frontier and self.expansions < self.settings.most:
            layer: list[SearchNode] = []
            while frontier and len(layer) < self.settings.width:
                cost, _, node = heapq.heappop(frontier)
                if cost + PLANNING.retake < self.below and cost <= cheapest[self._key(node)]:
                    layer.append(node)
            if not layer:
                break
            children = self._children(layer)
            for node in self._done(children):
                cost = plan_cost(self.model, self.goal, node.steps)
                if cost < self.below:
                    best, self.below = node, cost
            for node in children:
                key = self._key(node)
                if node.cost + PLANNING.retake < self.below and node.cost < cheapest.get(key, float("inf")):
                    cheapest[key] = node.cost
                    heapq.heappush(frontier, (node.cost, next(order), node))
        self.proved = not any(cost + PLANNING.retake < self.below for cost, _, _ in frontier)
        self.dropped |= not self.proved
        return best

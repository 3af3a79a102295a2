"""Interaction graphs: which object's state acts on which (paper sec. V, eq. 3). Pure data; no Drake systems."""

from __future__ import annotations

import copy
import math
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import networkx as nx
import numpy as np

from ichain_drake.errors import InputError
from ichain_drake.files import write_whole
from ichain_drake.state import FloatArray, StateSpace


@dataclass(frozen=True)
class Interaction:
    """A directed edge: the parent's state is (part of) the child's action (paper eq. 2, 3)."""

    parent: str
    child: str

    @property
    def name(self) -> str:
        """`parent->child`: the name of the interaction's column in a demonstration."""
        return f"{self.parent}->{self.child}"

    @classmethod
    def parse(cls, text: str) -> Interaction:
        """Read `parent->child`.

        Raises:
            InputError: if the text has another form.
        """
        parts = [p.strip() for p in text.split("->")]
        if len(parts) != 2 or not all(parts):
            raise InputError(f"interaction {text!r}: write it as parent->child")
        return cls(*parts)


@dataclass(frozen=True)
class Origin:
    """Where an object stands, as a scenario declares it: given, not learned.

    What acts on the object by its position acts by where it is relative to the object. A link that is learned in
    relative positions therefore holds wherever the object is moved to, without a new sample (paper sec. IV: "move the
    joystick: translate the hand"). A turn is not declared and has to be learned.

    Attributes:
        frame: in which it is expressed; positions with a role in this frame are taken relative to it.
        position: x, y, z [m].
    """

    frame: str
    position: tuple[float, float, float]

    def __post_init__(self) -> None:
        if len(self.position) != 3 or not all(math.isfinite(v) for v in self.position):
            raise InputError(f"an origin in frame {self.frame!r} is at {self.position}; give x, y, z in metres")

    def offset(self, space: StateSpace) -> FloatArray | None:
        """What it adds to a state whose positions are relative to it.

        Args:
            space: of that state.

        Returns:
            Its coordinate for each position in its frame and 0 for any other variable, shape (n_variables,); None if
            there is no such position.
        """
        offset, found = np.zeros(len(space)), False
        for i, variable in enumerate(space.variables):
            role = variable.role
            if role is not None and role.kind == "position" and role.frame == self.frame:
                offset[i], found = self.position["xyz".index(role.axis)], True
        return offset if found else None


class InteractionGraph:
    """Objects and the interactions between them.

    Args:
        objects: state space of each object, by name.
        interactions: edges as `Interaction`, `(parent, child)` or `"parent->child"`.
        origins: where objects stand, by name, as far as it is declared; see `Origin`.
        robots: the roots where there are several, in the order in which their commands are joined (two hands); default:
            the one object without parents.

    Attributes:
        roots: the robots, which nothing but commands controls (paper sec. III: O_1).
        root: the one of them that is looked at (see `acting`); at first the first.

    Raises:
        InputError: on an object name that is empty or holds '->', an edge to an unknown object, a doubled edge, a self
            loop, if the objects without parents are not the robots, or on an origin of an unknown object or in a frame
            in which none of its parents has a position.
    """

    def __init__(
        self,
        objects: Mapping[str, StateSpace],
        interactions: Sequence[Interaction | tuple[str, str] | str],
        origins: Mapping[str, Origin] | None = None,
        robots: Sequence[str] = (),
    ) -> None:
        self.objects = dict(objects)
        for name in self.objects:
            if not name or "->" in name:
                raise InputError(f"object name {name!r}: give a non-empty name without '->'")
        edges: dict[Interaction, None] = {}
        for item in interactions:
            if isinstance(item, str):
                edge = Interaction.parse(item)
            elif isinstance(item, Interaction):
                edge = item
            else:
                edge = Interaction(*item)
            for end in (edge.parent, edge.child):
                if end not in self.objects:
                    raise InputError(
                        f"interaction {edge.name}: there is no object {end!r}; objects are {', '.join(self.objects)}"
                    )
            if edge.parent == edge.child:
                raise InputError(f"interaction {edge.name}: an object can't act on itself; use its passive dynamics")
            if edge in edges:
                raise InputError(f"interaction {edge.name} is declared twice")
            edges[edge] = None
        self.interactions: tuple[Interaction, ...] = tuple(edges)
        self.roots = self._find_roots(tuple(robots))
        self.root = self.roots[0]
        lost = set(self.objects).difference(self.roots, *(nx.descendants(self.digraph, r) for r in self.roots))
        if lost:
            raise InputError(f"no interaction leads from {' or '.join(self.roots)} to {', '.join(sorted(lost))}")
        self.origins = dict(origins or {})
        for name, origin in self.origins.items():
            self._check_origin(name, origin)

    def _find_roots(self, robots: tuple[str, ...]) -> tuple[str, ...]:
        found = tuple(name for name in self.objects if not self.parents(name))
        if robots:
            if len(set(robots)) != len(robots) or set(robots) != set(found):
                raise InputError(
                    f"the robots are declared as {', '.join(robots)}, but the objects without parents are "
                    f"{', '.join(found) or 'none'}; declare each of these once"
                )
            return robots
        if len(found) != 1:
            raise InputError(
                f"the graph needs exactly one object without parents (the robot); it has {len(found)}: "
                f"{', '.join(found) or 'none'}" + ("; declare several as robots" if found else "")
            )
        return found

    def acting(self, robot: str) -> InteractionGraph:
        """The same graph as one of its robots sees it: that is its `root`, the others are objects that stay.

        Raises:
            InputError: if it is none of the robots.
        """
        if robot not in self.roots:
            raise InputError(f"{robot!r} is no robot of the graph; they are {', '.join(self.roots)}")
        if robot == self.root:
            return self
        other = copy.copy(self)
        other.root = robot
        return other

    @cached_property
    def command(self) -> StateSpace:
        """What all robots are commanded, one after the other; of several, each variable has its robot's name first."""
        if len(self.roots) == 1:
            return self.objects[self.root].observable
        variables = [
            replace(v, name=f"{r}:{v.name}", role=None)
            for r in self.roots
            for v in self.objects[r].observable.variables
        ]
        return StateSpace("robots", tuple(variables))

    def split_command(self, command: FloatArray) -> dict[str, FloatArray]:
        """The part of each robot, shape (..., n_robot), of a command of all, shape (..., n_command)."""
        ends = np.cumsum([len(self.objects[r].observable) for r in self.roots])
        return dict(zip(self.roots, np.split(np.asarray(command, dtype=float), ends[:-1], axis=-1), strict=True))

    def join_command(self, parts: Mapping[str, FloatArray]) -> FloatArray:
        """The command of all robots, shape (..., n_command), of each one's part, shape (..., n_robot)."""
        if len(self.roots) == 1:
            return np.asarray(parts[self.root], dtype=float)
        return np.concatenate([np.asarray(parts[r], dtype=float) for r in self.roots], axis=-1)

    def only_root(self, what: str) -> str:
        """The one robot, for what is not possible with several.

        Args:
            what: that is not, in words.

        Raises:
            InputError: if there are several.
        """
        if len(self.roots) > 1:
            raise InputError(f"{what} takes one robot; the graph has {', '.join(self.roots)}")
        return self.root

    def by_robot(self, edge: Interaction) -> bool:
        """Whether an interaction is one of a robot's own."""
        return edge.parent in self.roots

    def _check_origin(self, name: str, origin: Origin) -> None:
        self._require(name)
        if all(origin.offset(self.objects[p]) is None for p in self.parents(name)):
            raise InputError(
                f"origin of {name}: none of its parents has a position in frame {origin.frame!r}; give the frame of "
                "the parents' positions"
            )

    @cached_property
    def digraph(self) -> nx.DiGraph:
        """The same graph for networkx, nodes and edges in declared order."""
        graph = nx.DiGraph()
        graph.add_nodes_from(self.objects)
        graph.add_edges_from((e.parent, e.child) for e in self.interactions)
        return graph

    def parents(self, child: str) -> tuple[str, ...]:
        """Parents of an object in declared order: the factors of its action set (paper eq. 3)."""
        return tuple(e.parent for e in self.incoming(child))

    def children(self, parent: str) -> tuple[str, ...]:
        """Children of an object in declared order."""
        return self._children.get(parent, ())

    def incoming(self, child: str) -> tuple[Interaction, ...]:
        """Interactions that act on an object, in declared order."""
        return self._incoming.get(child, ())

    @cached_property
    def _incoming(self) -> dict[str, tuple[Interaction, ...]]:
        found: dict[str, list[Interaction]] = {}
        for e in self.interactions:
            found.setdefault(e.child, []).append(e)
        return {child: tuple(edges) for child, edges in found.items()}

    @cached_property
    def _children(self) -> dict[str, tuple[str, ...]]:
        found: dict[str, list[str]] = {}
        for e in self.interactions:
            found.setdefault(e.parent, []).append(e.child)
        return {parent: tuple(children) for parent, children in found.items()}

    @cached_property
    def edges(self) -> frozenset[Interaction]:
        """The interactions, to look whether one is among them."""
        return frozenset(self.interactions)

    def origin_for(self, edge: Interaction) -> Origin | None:
        """What the parent's positions are relative to: the child's declared origin.

        Args:
            edge: the interaction.

        Returns:
            None if none is declared, or the parent has no measured position in its frame.
        """
        origin = self.origins.get(edge.child)
        measured = self.objects[edge.parent].observable
        return None if origin is None or origin.offset(measured) is None else origin

    def chain(self, target: str) -> tuple[str, ...]:
        """The shortest chain of objects from the robot to the target, both included.

        Raises:
            InputError: if there is no such object, or the robot (`root`) does not act on it.
        """
        self._require(target)
        if not nx.has_path(self.digraph, self.root, target):
            raise InputError(f"no interaction leads from {self.root} to {target}")
        return tuple(nx.shortest_path(self.digraph, self.root, target))

    def chains(self, target: str) -> tuple[tuple[str, ...], ...]:
        """All simple chains from the robot to the target, shortest first; errors as `chain`."""
        self._require(target)
        paths = nx.all_simple_paths(self.digraph, self.root, target) if target != self.root else [[self.root]]
        return tuple(sorted((tuple(p) for p in paths), key=len))

    def _require(self, name: str) -> None:
        if name not in self.objects:
            raise InputError(f"there is no object {name!r}; objects are {', '.join(self.objects)}")

    @cached_property
    def components(self) -> tuple[tuple[str, ...], ...]:
        """Strongly connected components in topological order, members in declared order."""
        place = {name: k for k, name in enumerate(self.objects)}
        condensed = nx.condensation(self.digraph)
        return tuple(
            tuple(sorted(condensed.nodes[c]["members"], key=place.__getitem__)) for c in nx.topological_sort(condensed)
        )

    def dot(self) -> str:
        """The graph in the DOT language, one box an object with its observable variables."""
        lines = ["digraph interactions {", "  rankdir=LR;", '  node [shape=box, style=rounded, fontname="Helvetica"];']
        for name, space in self.objects.items():
            label = name + "\\n" + ", ".join(f"{v.name} [{v.unit}]" for v in space.variables if not v.hidden)
            lines.append(f'  "{name}" [label="{label}"];')
        lines += [f'  "{e.parent}" -> "{e.child}";' for e in self.interactions]
        return "\n".join([*lines, "}"]) + "\n"

    def text(self) -> str:
        """The graph as plain text: one line an object."""
        return "\n".join(f"{n} -> {', '.join(self.children(n)) or '(nothing)'}" for n in self.objects)


def write_drawing(dot: str, file: Path) -> None:
    """Write a DOT drawing as it is (`.dot`) or rendered by Graphviz (`.svg`, `.png`, `.pdf`).

    Raises:
        InputError: if the ending is none of these, the file can't be written, or `dot` is not installed for a rendered
            one.
    """
    if file.suffix == ".dot":
        write_whole(file, dot.encode(errors="backslashreplace"))
        return
    if file.suffix not in {".svg", ".png", ".pdf"}:
        raise InputError(f"{file}: a drawing ends in .svg, .png, .pdf or .dot")
    program = shutil.which("dot")
    if program is None:
        raise InputError(f"{file}: Graphviz is not installed (no `dot`); install graphviz or write a .dot file")
    done = subprocess.run([program, f"-T{file.suffix[1:]}"], input=dot.encode(), capture_output=True, check=False)
    if done.returncode:
        said = " ".join(done.stderr.decode(errors="replace").split())
        raise InputError(f"{file}: can't write the drawing: {said or 'dot failed'}")
    write_whole(file, done.stdout)

"""Pictures of how honest predictions are: reliability diagrams, and what predictive intervals cover."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ichain_drake.errors import InputError
from ichain_drake.visualization.plots import new_figure, write_figure

_COLUMNS = 4
_LEAST = 16.0  # size of a mark of few rows [pt^2]


def plot_reliability(file: Path, bins: Mapping[str, Sequence[tuple[float, float, int]]]) -> None:
    """Draw how often what was given a probability happened, a panel each; on the diagonal both are equal.

    Args:
        file: where to, ending in `.png`.
        bins: by panel, of each bin mean probability, share that happened, and number of rows.

    Raises:
        InputError: if there is nothing to draw, a number is no share, or the file can't be written.
    """
    if not bins or not all(bins.values()):
        raise InputError(f"{file}: no bin with any row; nothing to draw")
    columns = min(len(bins), _COLUMNS)
    rows = -(-len(bins) // columns)
    figure = new_figure(2.9 * columns, 2.9 * rows + 0.3)
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    for axis in axes[len(bins) :]:
        axis.remove()
    for axis, (name, points) in zip(axes, bins.items(), strict=False):
        predicted, happened, n = zip(*points, strict=True)
        if not all(0.0 <= x <= 1.0 for x in (*predicted, *happened)):
            raise InputError(f"{file}: {name}: probabilities and shares lie in [0, 1]")
        total = sum(n)
        axis.plot([0, 1], [0, 1], color="0.72", linewidth=1.2, zorder=1)
        axis.vlines(predicted, predicted, happened, color="0.55", linewidth=0.8, zorder=1)
        sizes = [_LEAST + 400.0 * k / total for k in n]  # its area is the share of rows
        axis.scatter(predicted, happened, sizes, color="0.2", alpha=0.75, linewidths=0, zorder=2)
        for p, h, k in points:
            above = h <= 0.5  # noqa: PLR2004 - the middle: numbers stay within the panel
            axis.annotate(str(k), (p, h), (0, 7 if above else -13), textcoords="offset points", ha="center", fontsize=6)
        axis.set(title=name, xlim=(-0.06, 1.06), ylim=(-0.08, 1.08), aspect="equal")
        axis.grid(color="0.92", linewidth=0.7)
        axis.set_axisbelow(True)
    figure.supxlabel("P(active), mean of a bin")
    figure.supylabel("share of its rows that were active")
    write_figure(figure, file)


def plot_coverage(file: Path, shares: Mapping[str, Mapping[str, float]], *, level: float) -> None:
    """Draw what share of readings lies within predictive intervals, a row for each variable.

    Args:
        file: where to, ending in `.png`.
        shares: by variable and by the way in which its intervals were made, in [0, 1]; of each the same ways.
        level: the share that is to be covered, in (0, 1).

    Raises:
        InputError: if there is nothing to draw, variables differ in their ways, or the file can't be written.
    """
    ways = [tuple(of) for of in shares.values()]
    if not ways or not ways[0] or set(ways) != {ways[0]}:
        raise InputError(f"{file}: every variable needs a share of the same ways; given are {sorted(set(ways))}")
    figure = new_figure(6.4, 1.3 + 0.24 * len(shares))
    axis = figure.subplots()
    places = range(len(shares))
    axis.axvline(level, color="0.55", linewidth=1.2, label=f"{100 * level:.0f} %")
    for i, way in enumerate(ways[0]):
        face = "white" if i == 0 else "0.15"
        values = [of[way] for of in shares.values()]
        axis.plot(values, places, "os^D"[i % 4], color="0.15", markerfacecolor=face, markersize=5, label=way)
    axis.set_yticks(list(places), list(shares))
    axis.invert_yaxis()
    axis.set(xlabel="share of readings within", xlim=(min(0.7, axis.get_xlim()[0]), 1.01))
    axis.grid(color="0.92", linewidth=0.7)
    axis.set_axisbelow(True)
    figure.legend(loc="outside lower center", ncols=4, frameon=False)
    write_figure(figure, file)

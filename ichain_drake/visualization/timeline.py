"""When interactions were active: truth, classifier and controller under each other. Readable in greyscale."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ichain_drake.errors import InputError
from ichain_drake.visualization.plots import new_figure, write_figure
from ichain_drake.visualization.recording import Strip

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Style = Literal["solid", "grey", "rising", "dots", "falling"]

_LOOKS: dict[str, dict[str, Any]] = {
    "solid": {"facecolor": "0.15", "edgecolor": "0.15"},
    "grey": {"facecolor": "0.65", "edgecolor": "0.35"},
    "rising": {"facecolor": "white", "edgecolor": "0.1", "hatch": "//////"},
    "dots": {"facecolor": "white", "edgecolor": "0.1", "hatch": "....."},
    "falling": {"facecolor": "white", "edgecolor": "0.1", "hatch": "\\\\\\\\\\\\"},
}


@dataclass(frozen=True)
class Lane:
    """Bars over time.

    Attributes:
        label: what the bars mean; lanes of one meaning share label and style.
        style: how they look. Lanes with a hatch (`rising`, `dots`, `falling`) share one line.
        spans: start and duration of each bar [s].
    """

    label: str
    style: Style
    spans: Sequence[tuple[float, float]]


def plot_timeline(
    file: Path,
    lanes: Mapping[str, Sequence[Lane]],
    duration: float,
    strips: Mapping[str, Strip] | None = None,
    times: ArrayLike = (),
) -> None:
    """Draw a row of lanes for each interaction, and below it quantities over the same time.

    Args:
        file: where to, ending in `.png`.
        lanes: bars of each interaction by its name, from top to bottom.
        duration: of the run [s].
        strips: quantities with the ranges wanted of them, by label.
        times: of the strips' values, shape (n,) [s].

    Raises:
        InputError: if there are no lanes, a strip has another length than `times`, or the file can't be written.
    """
    strips = strips or {}
    if not lanes:
        raise InputError(f"{file}: no interaction to draw")
    when = np.asarray(times, dtype=float)
    for label, strip in strips.items():
        if np.shape(strip.values) != when.shape:
            raise InputError(f"{file}: strip {label!r} has shape {np.shape(strip.values)}, its times {when.shape}")
    heights = [0.55 * len(lanes) + 0.3, *(0.8 for _ in strips)]
    figure = new_figure(11.0, sum(heights) + 0.9)
    axes = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    _draw_lanes(axes[0], lanes)
    for axis, (label, strip) in zip(axes[1:], strips.items(), strict=True):
        _draw_strip(axis, label, strip, when)
    axes[-1].set(xlabel="time [s]", xlim=(0.0, max(duration, 1e-9)))
    from matplotlib.patches import Patch  # noqa: PLC0415 - as in `plots`

    looks = {lane.label: lane.style for row in lanes.values() for lane in row}
    handles = [Patch(label=label, **_LOOKS[style]) for label, style in looks.items()]
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), frameon=False)
    write_figure(figure, file)


def _draw_lanes(axis: Axes, lanes: Mapping[str, Sequence[Lane]]) -> None:
    names = list(lanes)
    for row, name in enumerate(names):
        lines = list(dict.fromkeys(_line(lane) for lane in lanes[name]))
        height = 0.84 / max(len(lines), 1)
        for lane in lanes[name]:
            top = row - 0.42 + lines.index(_line(lane)) * height
            axis.broken_barh(list(lane.spans), (top, 0.86 * height), linewidth=0.6, **_LOOKS[lane.style])
        axis.axhline(row + 0.5, color="0.85", linewidth=0.7)
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.5, -0.5)
    axis.tick_params(axis="y", length=0)
    axis.grid(axis="x", color="0.92", linewidth=0.7)
    axis.set_axisbelow(True)


def _line(lane: Lane) -> str:
    return "hatched" if lane.style in ("rising", "dots", "falling") else lane.style


def _draw_strip(axis: Axes, label: str, strip: Strip, times: np.ndarray) -> None:
    axis.plot(times, strip.values, color="0.1", linewidth=1.2)
    low, high = axis.get_ylim()
    if strip.is_wanted:
        low = min([low, *(b for b in (strip.lower, strip.upper) if np.isfinite(b))])
        high = max([high, *(b for b in (strip.lower, strip.upper) if np.isfinite(b))])
        pad = 0.06 * (high - low)
        low, high = low - pad, high + pad
        axis.axhspan(max(strip.lower, low), min(strip.upper, high), color="0.87", linewidth=0)
        axis.set_ylim(low, high)
    axis.set_title(label, loc="left", fontsize=9, pad=2)
    axis.set_ylabel(strip.unit)
    axis.tick_params(labelsize=8)

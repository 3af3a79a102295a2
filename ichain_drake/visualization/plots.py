"""Pictures of results, readable in greyscale. Figures are drawn without matplotlib's global state."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ichain_drake.errors import InputError
from ichain_drake.files import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLUMNS = 3


def plot_paths(
    file: Path,
    commanded: Mapping[str, ArrayLike],
    executed: Mapping[str, ArrayLike],
    *,
    errors: Mapping[str, float] | None = None,
    unit: str = "px",
    y_down: bool = True,
) -> None:
    """Draw commanded against executed paths, a panel each (as in the paper's figures of the car's paths).

    Args:
        file: where to, ending in `.png`.
        commanded: polylines by path name, shape (m, 2).
        executed: what was driven, of the same names, shape (n, 2).
        errors: mean error of each path, for the titles.
        unit: of positions and errors.
        y_down: whether y points down, as on a game's screen.

    Raises:
        InputError: if the names differ, an array has another shape, or the file can't be written.
    """
    if not commanded or set(commanded) != set(executed):
        raise InputError(
            f"{file}: the same paths needed in both; commanded {', '.join(commanded) or 'none'}, "
            f"executed {', '.join(executed) or 'none'}"
        )
    columns = min(len(commanded), _COLUMNS)
    rows = -(-len(commanded) // columns)
    figure = new_figure(4.4 * columns, 3.8 * rows + 0.4)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for axis in axes[len(commanded) :]:
        axis.remove()
    for axis, name in zip(axes, commanded, strict=False):
        want, got = _path(commanded[name], f"commanded path {name}"), _path(executed[name], f"executed path {name}")
        axis.plot(want[:, 0], want[:, 1], color="0.72", linewidth=4.5, solid_capstyle="round", label="commanded")
        axis.plot(got[:, 0], got[:, 1], color="#b23a00", linewidth=1.1, label="executed")
        axis.plot(*got[0], "o", color="0.1", markersize=6, label="start")
        axis.plot(*got[-1], "s", color="0.1", markersize=6, markerfacecolor="white", label="end")
        axis.set_aspect("equal", adjustable="datalim")
        if y_down:
            axis.invert_yaxis()
        title = name if errors is None or name not in errors else f"{name}: mean error {errors[name]:.2f} {unit}"
        axis.set(title=title, xlabel=f"x [{unit}]", ylabel=f"y [{unit}]")
        axis.grid(color="0.92", linewidth=0.7)
        axis.set_axisbelow(True)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    write_figure(figure, file)


def plot_learning_curve(
    file: Path,
    table: pd.DataFrame,
    *,
    x: str = "samples",
    y: str = "error",
    series: str = "method",
    unit: str = "",
    logarithmic: bool = False,
) -> None:
    """Draw how an error falls with the amount of data: median and range of repeated trials, a line for each series.

    Args:
        file: where to, ending in `.png`.
        table: a row for each trial, with the columns named by `x`, `y` and, if there are several lines, `series`.
        x: column of the amount of data.
        y: column of the error.
        series: column that tells the lines apart.
        unit: of `y`.
        logarithmic: whether `y` has a logarithmic axis.

    Raises:
        InputError: if a column is missing, there are no rows, or the file can't be written.
    """
    for name in (x, y):
        if name not in table.columns:
            raise InputError(f"{file}: the table has no column {name!r}; it has {', '.join(map(str, table.columns))}")
    if table.empty:
        raise InputError(f"{file}: the table has no rows; nothing to draw")
    figure = new_figure(6.4, 4.2)
    axis = figure.subplots()
    groups: list[tuple[Any, pd.DataFrame]] = [("", table)]
    if series in table.columns:
        groups = list(table.groupby(series, sort=False))
    for i, (name, rows) in enumerate(groups):
        trials = rows.groupby(x)[y]
        median, low, high = trials.median(), trials.min(), trials.max()
        grey = f"{0.15 + 0.5 * (i % 3) / 2:.2f}"
        axis.plot(median.index, median, "os^Dv"[i % 5] + ("-", "--", ":")[i % 3], color=grey, label=str(name))
        axis.fill_between(median.index, low, high, color=grey, alpha=0.15, linewidth=0)
    axis.set(xlabel=x, ylabel=f"{y} [{unit}]" if unit else y)
    if logarithmic:
        axis.set_yscale("log")
    axis.grid(color="0.92", linewidth=0.7)
    axis.set_axisbelow(True)
    if series in table.columns:
        axis.legend(frameon=False, title=series)
    write_figure(figure, file)


def plot_success_curve(
    file: Path, table: pd.DataFrame, *, x: str = "pieces", success: str = "success", steps: str = "control_steps"
) -> None:
    """Draw how the share of runs that reach their goal grows with the amount of data, and how long those runs take.

    Args:
        file: where to, ending in `.png`.
        table: a row for each run, with the columns named below.
        x: column of the amount of data.
        success: column that says whether the goal was reached.
        steps: column of the length of a run; of those that reached the goal the median and the range are drawn.

    Raises:
        InputError: if a column is missing, there are no rows, or the file can't be written.
    """
    for name in (x, success, steps):
        if name not in table.columns:
            raise InputError(f"{file}: the table has no column {name!r}; it has {', '.join(map(str, table.columns))}")
    if table.empty:
        raise InputError(f"{file}: the table has no rows; nothing to draw")
    figure = new_figure(6.4, 5.6)
    above, below = figure.subplots(2, 1, sharex=True)
    runs = table.groupby(x)[success].agg(["mean", "sum", "count"])
    above.plot(runs.index, runs["mean"], "o-", color="0.15")
    for amount, row in runs.iterrows():
        text = f"{int(row['sum'])}/{int(row['count'])}"
        above.annotate(text, (float(amount), row["mean"]), (0, 7), textcoords="offset points", ha="center")  # type: ignore[arg-type]
    above.set(ylabel="share of runs that reach the goal", ylim=(-0.05, 1.18))
    reached = table[table[success].astype(bool)].groupby(x)[steps]
    low, middle, high = reached.min(), reached.median(), reached.max()
    below.plot(middle.index, middle, "s--", color="0.15", label="median")
    below.fill_between(middle.index, low, high, color="0.15", alpha=0.15, linewidth=0, label="least to most")
    below.set(xlabel=x, ylabel=f"{steps.replace('_', ' ')} where it is reached")
    below.legend(frameon=False)
    for axis in (above, below):
        axis.grid(color="0.92", linewidth=0.7)
        axis.set_axisbelow(True)
    write_figure(figure, file)


def _path(points: ArrayLike, where: str) -> np.ndarray:
    value = np.asarray(points, dtype=float)
    if value.ndim != 2 or value.shape[1] != 2 or not len(value):
        raise InputError(f"{where}: shape (n, 2) with n >= 1 needed, {value.shape} given")
    return value


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of a size [inch]."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - a command without pictures begins without it

    return Figure(figsize=(width, height), layout="constrained")


def write_figure(figure: Figure, file: Path) -> None:
    """Write a figure as a `.png`, whole or not at all.

    Raises:
        InputError: on another ending, or if the file can't be written.
    """
    if file.suffix != ".png":
        raise InputError(f"{file}: a picture ends in .png")
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - as above

    stream = io.BytesIO()
    FigureCanvasAgg(figure).print_png(stream)
    write_whole(file, stream.getvalue())

"""What the playback's page shows beside the scene, as plain JSON values: read-out, interaction graph, strips."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Rgba

from ichain_drake.visualization.graph_layout import layout_graph
from ichain_drake.visualization.recording import RATE, RecordedEpisode, Recording, Strip
from ichain_drake.visualization.scene import DRAWN, Drawing, Scene


def page_log(recording: Recording, drawings: Mapping[str, Drawing], scene: Scene, gap: float) -> dict[str, Any]:
    """What `page/playback.js` and `page/panel.js` read.

    Args:
        recording: what happened.
        drawings: by object; their legends are shown.
        scene: with all changes recorded.
        gap: pause between two episodes [s].
    """
    episodes = recording.episodes
    units: dict[str, str | None] = {}
    for episode in episodes:
        for label, readout in episode.readouts.items():
            units.setdefault(label, None if readout.is_text else readout.unit)
    legend = [entry for drawing in drawings.values() for entry in getattr(drawing, "legend", ())]
    return {
        "scenario": recording.scenario,
        "physics": recording.physics,
        "seed": recording.seed,
        "rate": RATE,
        "episodes": [
            {"name": e.name, "start": start, "time": float(e.times[0]), "samples": len(e.times)}
            for e, start in zip(episodes, recording.starts(gap), strict=True)
        ],
        "readouts": [
            {
                "label": label,
                "unit": unit,
                "values": [_column(e.readouts[label].values) if label in e.readouts else None for e in episodes],
            }
            for label, unit in units.items()
        ],
        "objects": [
            {
                "name": name,
                "type": space.type,
                "variables": [
                    {
                        "label": v.name,
                        "unit": "" if v.unit == "1" else v.unit,
                        "values": [_column(e.states[name][:, i]) for e in episodes],
                    }
                    for i, v in enumerate(space.variables)
                    if not v.hidden
                ],
            }
            for name, space in recording.spaces.items()
        ],
        "graph": _graph(recording),
        "strips": [
            {"label": label, "values": [_strip(e.strips.get(label)) for e in episodes]}
            for label in dict.fromkeys(label for e in episodes for label in e.strips)
        ],
        "growing": [path for path, tracks in scene.tracks.items() if any(t.kind is DRAWN for t in tracks)],
        "legend": [{"label": label, "color": _css(color)} for label, color in legend],
    }


def _graph(recording: Recording) -> dict[str, Any] | None:
    """Boxes and curves of the interaction graph, and when each interaction is switched."""
    if not recording.interactions:
        return None
    layout = layout_graph(list(recording.spaces), recording.interactions)
    return {
        "width": round(layout.width, 1),
        "height": round(layout.height, 1),
        "boxes": [{"name": n, "box": np.round(box, 1).tolist()} for n, box in layout.boxes.items()],
        "edges": [
            {
                "name": edge.name,
                "child": edge.child,
                "curve": np.round(curve, 1).tolist(),
                "switched": [_switched(episode, edge.name) for episode in recording.episodes],
            }
            for edge, curve in layout.curves.items()
        ],
    }


def _switched(episode: RecordedEpisode, edge: str) -> list[int] | None:
    """Samples from which on an interaction is active, inactive, active and so on; None if nothing was logged."""
    if edge not in episode.active:
        return None
    flags = np.concatenate([[False], np.asarray(episode.active[edge], dtype=bool)])
    return [int(k) for k in np.flatnonzero(flags[1:] != flags[:-1])]


def _strip(strip: Strip | None) -> dict[str, Any] | None:
    if strip is None:
        return None
    return {
        "unit": "" if strip.unit == "1" else strip.unit,
        "lower": strip.lower if math.isfinite(strip.lower) else None,
        "upper": strip.upper if math.isfinite(strip.upper) else None,
        "values": _column(strip.values),
        "wanted": strip.is_wanted,
    }


def _column(values: NDArray[np.float64] | list[str]) -> list[str] | list[float | None]:
    """Values for JSON: three decimals are shown; NaN becomes null."""
    if isinstance(values, list):
        return values
    return [float(v) if np.isfinite(v) else None for v in np.round(values, 3)]


def _css(color: tuple[float, float, float] | Rgba) -> str:
    rgb = (color.r(), color.g(), color.b()) if isinstance(color, Rgba) else color
    return "#" + "".join(f"{round(255 * min(max(c, 0.0), 1.0)):02x}" for c in rgb[:3])

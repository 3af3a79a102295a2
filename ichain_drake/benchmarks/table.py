"""The benchmarks as plain text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any


def format_table(results: Mapping[str, Any]) -> str:
    """What `run_benchmarks` returned, as text to print."""
    parts = (
        _diagram(results["diagram"]),
        _decision(results["decision"]),
        _together(results["together"]),
        _chain_length(results["chain_length"]),
        _frozen(results["frozen_models"]),
        _games(results["games"]),
    )
    return "\n\n".join("\n".join(part) for part in parts)


def format_profile(profile: Mapping[str, Any]) -> str:
    """What `profile_run` returned, as text to print."""
    phases, simulated = profile["phases"], profile["simulated_seconds"]
    whole = sum(row["wall"] for row in phases)
    rows = [
        [row["phase"], f"{row['wall']:.2f}", f"{row['processor']:.2f}", f"{100 * row['wall'] / whole:.0f} %"]
        for row in phases
    ]
    rows.append(["all", f"{whole:.2f}", f"{sum(row['processor'] for row in phases):.2f}", ""])
    systems = [
        [row["system"], f"{row['processor']:.3f}", f"{1000 * row['processor'] / simulated:.2f}", str(row["calls"])]
        for row in profile["systems"]
    ]
    where = f"{profile['scenario']}, {profile['physics']} physics, seed {profile['seed']}"
    return "\n".join(
        [
            f"One run by phase: {where}, {simulated:.1f} s simulated",
            *columns(["", "wall s", "processor s", "of wall"], rows),
            "  plan, control, objects (Python) and plant (with C++) are the run; their wall time is divided as their",
            "  processor time is",
            "",
            "Systems of its Diagram, each with the cost of being timed",
            *columns(["", "processor s", "ms per simulated s", "calls"], systems),
        ]
    )


def columns(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Aligned columns, the first to the left, the others to the right."""
    lines = [list(header), *map(list, rows)]
    widths = [max(len(line[i]) for line in lines) for i in range(len(header))]

    def aligned(line: Sequence[str]) -> str:
        first, *others = (c.rjust(w) if i else c.ljust(w) for i, (c, w) in enumerate(zip(line, widths, strict=True)))
        return "  ".join(["", first, *others])

    return [aligned(line) for line in lines]


def _diagram(d: Mapping[str, Any]) -> list[str]:
    rows = [
        ["bare plant, recorded motion played back", f"{d['bare_ms']:.1f}", "1.00"],
        [f"whole diagram ({d['method']})", f"{d['whole_ms']:.1f}", f"{d['ratio']:.2f}"],
        [f"whole diagram ({d['method']}), recorded", f"{d['recorded_ms']:.1f}", f"{d['ratio_recorded']:.2f}"],
        *([f"whole diagram ({m})", "", f"{r:.2f}"] for m, r in d["ratio_other_methods"].items()),
    ]
    parts = [
        [row["system"], f"{row['ms']:.2f}", f"{row['of_bare']:.2f}", _calls(row["calls_a_second"])]
        for row in d["breakdown"]
    ]
    return [
        f"Whole diagram against the bare plant: car_game in contact, {d['simulated_seconds']:g} s of {d['path']}, "
        f"plant step 1/{1 / d['plant_step']:.0f} s",
        *columns(["", "ms per simulated s", "x bare"], rows),
        "Breakdown by system, each with the cost of being timed",
        *columns(["", "ms per simulated s", "x bare", "calls a second"], parts),
        "A step of the plant by its place in the frame, whose first has what runs once a frame [us]",
        *columns(
            ["", *(str(k + 1) for k in range(len(d["steps_us"]["bare"])))],
            [
                [name, *(f"{us:.0f}" for us in d["steps_us"][key])]
                for name, key in (("bare plant", "bare"), ("whole diagram", "whole"))
            ],
        ),
    ]


def _calls(calls: float | None) -> str:
    return "" if calls is None else f"{calls:.0f}"


def _decision(d: Mapping[str, Any]) -> list[str]:
    rows = [
        [method, f"{t['median_ms']:.3f}", f"{t['longest_ms']:.3f}"] for method, t in d.items() if method != "objects"
    ]
    return [f"One control decision, {d['objects']} objects", *columns(["", "median ms", "longest ms"], rows)]


def _together(t: Mapping[str, Any]) -> list[str]:
    rows = [
        ["one after another", f"{t['single_trials_a_second']:.2f}", "1.0"],
        ["together", f"{t['together_trials_a_second']:.2f}", f"{t['ratio']:.1f}"],
        [
            f"together, each with {t['learning_seconds']:.1f} s of demonstrations and learning",
            "",
            f"{t['ratio_fresh']:.2f}",
        ],
    ]
    return [
        f"{t['trials']} trials of one learned model: {t['scenario']} in ideal, {t['steps']:.0f} control steps of "
        f"{t['path']}; {t['equal']} of {t['compared']} compared are equal to the bit",
        *columns(["", "trials/s", "x"], rows),
    ]


def _chain_length(c: Mapping[str, Any]) -> list[str]:
    labels = {key: key.replace("decision_", "decision, ").replace("_", " ") for key in c["ms"]}
    rows = [
        [
            labels[key],
            *(f"{v:.3f}" for v in values),
            f"{1000.0 * c['fit'][key]['slope']:.1f}",
            f"{c['fit'][key]['r_squared']:.4f}",
        ]
        for key, values in c["ms"].items()
    ]
    header = ["objects", *(str(n) for n in c["lengths"]), "us an object", "R^2"]
    return ["Cost against chain length [ms]", *columns(header, rows)]


def _frozen(models: Sequence[Mapping[str, Any]]) -> list[str]:
    rows = [
        [
            m["model"],
            f"{m['predict_us']:.0f}",
            f"{m['frozen_us']:.1f}",
            f"{m['frozen_jacobian_us']:.1f}",
            f"{m['speedup']:.0f}",
            f"{m['difference']:.0e}",
        ]
        for m in models
    ]
    header = ["", "predict us", "frozen us", "with Jacobian us", "times faster", "difference"]
    return ["Frozen models against scikit-learn, one row", *columns(header, rows)]


def _games(game: Mapping[str, Any] | None) -> list[str]:
    title = "Steps of a game a second, nothing rendered"
    if game is None:
        return [title, "  not measured: the extra `games` is not installed"]
    rows = [
        [f"{game['game']} alone", f"{game['bare_steps']:.0f}"],
        ["through the adapter, its state put back and read in every frame", f"{game['steps']:.0f}"],
        ["the object in a Simulator", f"{game['diagram_steps']:.0f}"],
    ]
    return [title, *columns(["", "steps/s"], rows)]

"""Saving learned links into an interaction library."""

from __future__ import annotations

import importlib.metadata
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ichain_drake.errors import InputError
from ichain_drake.learning.chain.chain import DEMONSTRATIONS, LearnedChain, LearnedLink
from ichain_drake.learning.chain.command import LearnedCommand
from ichain_drake.learning.chain.link import EstimatorSpec, Scored
from ichain_drake.learning.library.files import MANIFEST, link_name, sha256, write_files
from ichain_drake.learning.library.manifest import TIME_CONVENTION, space_fields, write_manifest
from ichain_drake.learning.library.transfer import copy_link
from ichain_drake.learning.library.weights import pack
from ichain_drake.timing import TICK

_PACKAGES = ("drake", "scikit-learn", "numpy", "ichain_drake")


def spec_text(spec: EstimatorSpec, where: str) -> str:
    """An estimator spec as text that `EstimatorSpec.parse` reads back.

    Raises:
        InputError: if a parameter is no Python literal.
    """
    plain = {k: v.item() if isinstance(v, np.generic) else v for k, v in spec.parameters.items()}
    text = f"{spec.name}({', '.join(f'{k}={v!r}' for k, v in plain.items())})"
    try:
        same = EstimatorSpec.parse(text) == EstimatorSpec(spec.name, plain)
    except InputError:
        same = False
    if not same:
        raise InputError(f"{where}: estimator {text} can't be saved: its parameters must be plain values")
    return text


def _numbers(values: ArrayLike) -> list[float]:
    return [float(v) for v in np.asarray(values, dtype=float)]


def current_versions() -> dict[str, str]:
    """Versions of Python and of the packages that learning uses, by name."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:  # this package itself, in a checkout
            found[name] = "not installed"
    return found


def _model_fields(fitted: Scored[Any, Any], file: str, where: str) -> dict[str, Any]:
    return {
        "estimator": spec_text(fitted.spec.estimator, where),
        "features": fitted.spec.features,
        "action": fitted.spec.action,
        "score": float(fitted.score),
        "residual_std": _numbers(fitted.residual_std),
        "samples": int(fitted.samples),
        "kind": fitted.model.frozen.kind,
        "file": file,
    }


def _command_fields(command: LearnedCommand) -> dict[str, Any]:
    return {
        "map": command.map and {"kind": command.map.kind, "file": "command.npz"},
        "lower": _numbers(command.lower),
        "upper": _numbers(command.upper),
        "hand_limit": _numbers(command.hand_limit),
    }


def save_link(
    link: LearnedLink, library: Path, source: str, data_hash: str, command: LearnedCommand | None = None
) -> Path:
    """Save one learned link in a folder of its own, in place of an earlier one of the same types.

    Args:
        link: learned from demonstrations.
        library: the library's folder; made where it doesn't exist.
        source: the scenario that it was learned in.
        data_hash: SHA-256 of the demonstrations, 64 hexadecimal digits.
        command: what belongs to a link whose parent is the robot.

    Returns:
        The link's folder.

    Raises:
        InputError: if it can't be saved (a NaN, an estimator with parameters that are no plain values, a bad hash) or
            written; an earlier link is kept then.
    """
    where = f"{link.interaction.name} of {source}"
    model = link.forward.model
    models = {"forward.npz": model.frozen}
    inverses = []
    for i, inverse in enumerate(link.inverses):
        file = f"inverse_{i}.npz"
        models[file] = inverse.model.frozen
        limits = {"parent_lower": _numbers(inverse.model.lower), "parent_upper": _numbers(inverse.model.upper)}
        inverses.append(_model_fields(inverse, file, where) | {"aim": int(inverse.spec.aim)} | limits)
    if command is not None and command.map is not None:
        models["command.npz"] = command.map
    targets = {inverse.model.targets for inverse in link.inverses}
    if len(targets) != 1:
        raise InputError(f"{where}: its inverse models have {len(targets)} sets of targets; a saved link has one")
    files = {file: pack(frozen) for file, frozen in models.items()}
    fields: Mapping[str, Any] = {
        "interaction": link.interaction.name,
        "source": source,
        "period": TICK,
        "time": TIME_CONVENTION,
        "parent": space_fields(model.parent_space),
        "child": space_fields(model.child_space),
        "origin": model.origin and {"frame": model.origin.frame, "position": _numbers(model.origin.position)},
        "targets": [model.child_space.names[i] for i in targets.pop()],
        "forward": _model_fields(link.forward, "forward.npz", where),
        "inverses": inverses,
        "child_limit": _numbers(link.child_limit),
        "child_scale": _numbers(link.child_scale),
        "parent_lower": _numbers(link.parent_lower),
        "parent_upper": _numbers(link.parent_upper),
        "parent_scale": _numbers(link.parent_scale),
        "command": command and _command_fields(command),
        "robot_seconds": float(link.robot_seconds),
        "versions": current_versions(),
        "demonstrations_sha256": data_hash,
        "files": {file: sha256(data) for file, data in files.items()},
    }
    manifest = write_manifest(fields, where)
    return write_files(
        library, link_name(model.parent_space.type, model.child_space.type), {MANIFEST: manifest} | files
    )


def save_chain(chain: LearnedChain, folder: str | Path, source: str, data_hash: str) -> list[Path]:
    """Save all links of a chain, each as a whole.

    A link that came from a library itself is copied from there with its own origin, or left as it is if it came from
    this one.

    Args:
        chain: the learned chain.
        folder: the library's folder; made where it doesn't exist.
        source: the scenario that it was learned in.
        data_hash: SHA-256 of the demonstrations, 64 hexadecimal digits.

    Returns:
        The links' folders, robot first.

    Raises:
        InputError: if two links are between the same types of objects, or one can't be saved; see `save_link`.
    """
    folder = Path(folder)
    names: dict[str, str] = {}
    for link in chain.links:
        model, own = link.forward.model, link.interaction.name
        other = names.setdefault(link_name(model.parent_space.type, model.child_space.type), own)
        if other != own:
            raise InputError(
                f"library {folder}: {other} and {own} are between the same types of objects, and a library has one "
                "link for two types; give the objects types of their own"
            )
    saved = []
    for i, (name, link) in enumerate(zip(names, chain.links, strict=True)):
        if link.source != DEMONSTRATIONS:
            saved.append(copy_link(Path(link.source), name, folder))
            continue
        limits = (chain.command_lower, chain.command_upper, chain.hand_limit)
        command = LearnedCommand(chain.command, *limits, chain.command_origin)
        saved.append(save_link(link, folder, source, data_hash, command if i == 0 else None))
    return saved

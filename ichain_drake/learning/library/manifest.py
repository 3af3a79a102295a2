"""The manifest of a saved link: its form, its checksums, and the state spaces that it describes.

Where `origin` isn't null, the models take the parent's positions in its frame relative to the child's declared origin,
so that the link serves wherever the child is declared to be; limits of positions are those of where it was.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from ichain_drake.errors import InputError
from ichain_drake.files import json_value
from ichain_drake.learning.chain.models import ActionKind
from ichain_drake.learning.features import FeatureKind
from ichain_drake.learning.library.files import MANIFEST, is_weights_name, sha256
from ichain_drake.learning.library.form import Keyed, Nullable, find_misfit, is_form, refusal
from ichain_drake.state import Kind, Role, RoleKind, StateSpace, Variable

FORMAT = 2
"""Version of the format; one more whenever a reader of the earlier one would misread it. From 2 on with `origin`."""

TIME_CONVENTION = "states at t and t + 1 are one period apart; action next: the parent at t + 1, current: at t"

SHA256 = re.compile(r"[0-9a-f]{64}")
_NUMBERS = [float]
SPACE = {
    "type": str,
    "variables": [
        {
            "name": str,
            "unit": str,
            "kind": get_args(Kind),
            "role": Nullable({"kind": get_args(RoleKind), "frame": str, "axis": str, "of": str}),
            "lower": Nullable(float),
            "upper": Nullable(float),
        }
    ],
}
_MODEL = {
    "estimator": str,
    "features": get_args(FeatureKind),
    "action": get_args(ActionKind),
    "score": float,
    "residual_std": _NUMBERS,
    "samples": int,
    "kind": str,
    "file": is_weights_name,
}
_FORM = {
    "format": int,
    "interaction": str,
    "source": str,
    "period": float,
    "time": str,
    "parent": SPACE,
    "child": SPACE,
    "origin": Nullable({"frame": str, "position": _NUMBERS}),
    "targets": [str],
    "forward": _MODEL,
    "inverses": [_MODEL | {"aim": int, "parent_lower": _NUMBERS, "parent_upper": _NUMBERS}],
    "child_limit": _NUMBERS,
    "child_scale": _NUMBERS,
    "parent_lower": _NUMBERS,
    "parent_upper": _NUMBERS,
    "parent_scale": _NUMBERS,
    "command": Nullable(
        {
            "map": Nullable({"kind": str, "file": is_weights_name}),
            "lower": _NUMBERS,
            "upper": _NUMBERS,
            "hand_limit": _NUMBERS,
        }
    ),
    "robot_seconds": float,
    "versions": Keyed(str, str),
    "demonstrations_sha256": SHA256,
    "files": Keyed(is_weights_name, SHA256),
    "checksums": Keyed(str, SHA256),
}


def _used(content: Mapping[str, Any]) -> list[str]:
    used = [model["file"] for model in (content["forward"], *content["inverses"])]
    if content["command"] is not None and content["command"]["map"] is not None:
        used.append(content["command"]["map"]["file"])
    return used


@dataclass(frozen=True)
class ManifestForm:
    """What a manifest has to look like.

    Attributes:
        fields: see `find_misfit`; with `format`, `files` and `checksums`.
        version: of the format.
        used: names of the weight files that the contents mention.
    """

    fields: Mapping[str, Any]
    version: int
    used: Callable[[Mapping[str, Any]], list[str]]


LINK = ManifestForm(_FORM, FORMAT, _used)


def _checksum(value: Any) -> str:
    return sha256(json.dumps(value, sort_keys=True, allow_nan=False).encode())


def write_manifest(fields: Mapping[str, Any], where: str, form: ManifestForm = LINK) -> bytes:
    """A manifest as the bytes of its file.

    Args:
        fields: all but `format` and `checksums`.
        where: what to call the link in errors.
        form: that it must have.

    Raises:
        InputError: if a field hasn't the form that `read_manifest` wants, such as a NaN.
    """
    content = {"format": form.version, **fields}
    misfit = find_misfit(content | {"checksums": {}}, form.fields)
    if misfit:
        raise InputError(f"{where} can't be saved: {misfit[0]}: {misfit[1]}")
    content["checksums"] = {name: _checksum(value) for name, value in content.items()}
    return (json.dumps(content, indent=2, allow_nan=False) + "\n").encode()


def read_manifest(files: Mapping[str, bytes], folder: Path, form: ManifestForm = LINK) -> dict[str, Any]:
    """The manifest of a link, checked in itself and against the weight files beside it.

    Args:
        files: from `read_files`.
        folder: named in errors.
        form: that it must have.

    Raises:
        InputError: if it is truncated, of another format version, edited, or doesn't belong to the weight files;
            names the field or file.
    """
    where = str(folder / MANIFEST)
    try:
        content = json_value(files[MANIFEST], where)
    except InputError as error:
        raise InputError(f"{error}; save the link anew") from None
    version = content.get("format") if isinstance(content, dict) else None
    if version is not None and is_form(version, int) and version > form.version:
        raise InputError(
            f"{where}: format {version} is newer than {form.version}, the newest that this version reads; "
            "update ichain_drake or save the link with this version"
        )
    if version is not None and is_form(version, int) and version < form.version:
        if version < 1:
            raise InputError(f"{where}: format {version} is unknown; the first is 1: save the link anew")
        raise InputError(
            f"{where}: format {version} is older than {form.version}, the only one that this version reads: learn the "
            "link anew"
        )
    misfit = find_misfit(content, form.fields)
    if misfit:
        raise refusal(where, *misfit)
    for name, value in content.items():
        if name != "checksums" and content["checksums"].get(name) != _checksum(value):
            raise refusal(where, name, "does not match its checksum")
    _check_weights(content, form.used(content), files, folder)
    return content


def _check_weights(content: dict[str, Any], used: list[str], files: Mapping[str, bytes], folder: Path) -> None:
    for name in used:
        if used.count(name) > 1 or name not in content["files"]:
            raise refusal(str(folder / MANIFEST), "files", f"{name} is not there exactly once")
    for name in sorted({*files, *content["files"], *used} - {MANIFEST}):
        if name not in files:
            raise InputError(f"{folder / name}: is missing; save the link anew")
        if name not in used:
            raise InputError(f"{folder / name}: is no part of this link and is not opened; remove it")
        if sha256(files[name]) != content["files"][name]:
            raise InputError(
                f"{folder / name}: its sha256 is not the manifest's; the file is damaged or was edited: "
                "save the link anew"
            )


def space_fields(space: StateSpace) -> dict[str, Any]:
    """A state space's observable variables for a manifest; an infinite bound is null."""
    return {
        "type": space.type,
        "variables": [
            {
                "name": v.name,
                "unit": v.unit,
                "kind": v.kind,
                "role": v.role and {"kind": v.role.kind, "frame": v.role.frame, "axis": v.role.axis, "of": v.role.of},
                "lower": float(v.lower) if math.isfinite(v.lower) else None,
                "upper": float(v.upper) if math.isfinite(v.upper) else None,
            }
            for v in space.observable.variables
        ],
    }


def space_from(fields: Mapping[str, Any]) -> StateSpace:
    """The state space that `space_fields` described.

    Raises:
        InputError: if it can't be one, such as a doubled name.
    """
    variables = [
        Variable(
            v["name"],
            v["unit"],
            -math.inf if v["lower"] is None else v["lower"],
            math.inf if v["upper"] is None else v["upper"],
            v["kind"],
            v["role"] and Role(**v["role"]),
        )
        for v in fields["variables"]
    ]
    return StateSpace(fields["type"], tuple(variables))

"""Recordings on disk: one compressed `.npz` of plain arrays and a JSON table of contents; nothing is ever unpickled."""

from __future__ import annotations

import dataclasses
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ichain_drake.array_claims import check_claims
from ichain_drake.errors import InputError
from ichain_drake.files import read_whole, write_whole
from ichain_drake.graph import Interaction
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.visualization.recording import Readout, RecordedEpisode, Recording, Strip

FORMAT = "ichain-recording-2"
_MOST_BYTES = 2**28  # an hour of a large graph takes a tenth of it
_DAMAGE = Exception
"""What numpy and zipfile make of damaged archives: errors of many kinds, that of a tokenizer among them."""


def save_recording(recording: Recording, file: Path) -> None:
    """Write a recording, whole or not at all. The same recording gives the same bytes.

    Args:
        recording: what to write.
        file: where to, ending in `.npz`.

    Raises:
        InputError: if the ending differs or the file can't be written.
    """
    if file.suffix != ".npz":
        raise InputError(f"{file}: a recording ends in .npz")
    arrays: dict[str, NDArray[Any]] = {}
    episodes = []
    for i, episode in enumerate(recording.episodes):
        key = f"episode{i}"
        arrays[f"{key}.times"] = np.asarray(episode.times, dtype=float)
        for j, name in enumerate(recording.spaces):
            arrays[f"{key}.state{j}"] = np.asarray(episode.states[name], dtype=float)
        if episode.plant_positions is not None:
            arrays[f"{key}.plant_positions"] = np.asarray(episode.plant_positions, dtype=float)
        for j, readout in enumerate(episode.readouts.values()):
            arrays[f"{key}.readout{j}"] = np.array(readout.values, dtype=str if readout.is_text else float)
        for j, line in enumerate(episode.lines.values()):
            arrays[f"{key}.line{j}"] = np.asarray(line, dtype=float)
        for j, flags in enumerate(episode.active.values()):
            arrays[f"{key}.active{j}"] = np.asarray(flags, dtype=bool)
        for j, strip in enumerate(episode.strips.values()):
            arrays[f"{key}.strip{j}"] = np.asarray(strip.values, dtype=float)
        episodes.append(
            {
                "name": episode.name,
                "plant": episode.plant_positions is not None,
                "readouts": [[label, r.unit] for label, r in episode.readouts.items()],
                "lines": list(episode.lines),
                "active": list(episode.active),
                # As text, as JSON has no infinity.
                "strips": [[label, s.unit, str(s.lower), str(s.upper)] for label, s in episode.strips.items()],
            }
        )
    contents = {
        "format": FORMAT,
        "scenario": recording.scenario,
        "physics": recording.physics,
        "seed": recording.seed,
        "spaces": [[name, dataclasses.asdict(space)] for name, space in recording.spaces.items()],
        "episodes": episodes,
        "interactions": [e.name for e in recording.interactions],
    }
    stream = io.BytesIO()
    np.savez_compressed(stream, contents=np.array(json.dumps(contents)), **arrays)  # type: ignore[arg-type]
    write_whole(file, stream.getvalue())


def load_recording(file: str | Path) -> Recording:
    """Read a recording that `save_recording` wrote.

    Raises:
        InputError: if there is no such file, it is damaged or cut short, or a field is missing or misshaped; the
            message names the field.
    """
    file = Path(file)
    if not file.exists():
        raise InputError(f"{file}: there is no such recording")
    data = io.BytesIO(read_whole(file, "the recording", _MOST_BYTES))
    try:
        archive = np.load(data, allow_pickle=False)
        if isinstance(archive, np.lib.npyio.NpzFile):
            check_claims(data, str(file))
            archive = np.load(data, allow_pickle=False)
    except InputError:
        raise
    except _DAMAGE as error:
        raise InputError(f"{file}: not a recording, or cut short; record it again") from error
    if not isinstance(archive, np.lib.npyio.NpzFile):
        raise InputError(f"{file}: not a recording (a bare array); record it again")
    with archive:
        return _read(_Fields(file, archive))


class _Fields:
    """Reads the arrays of an archive by name, with errors that name the field."""

    def __init__(self, file: Path, archive: np.lib.npyio.NpzFile) -> None:
        self._file = file
        self._archive = archive

    def error(self, name: str, reason: str) -> InputError:
        return InputError(f"{self._file}: field {name} {reason}; record it again")

    def array(self, name: str, kinds: str = "f") -> NDArray[Any]:
        if name not in self._archive:
            raise self.error(name, "is missing")
        try:
            value = self._archive[name]
        except _DAMAGE as error:
            raise self.error(name, "is damaged") from error
        if value.dtype.kind not in kinds:
            raise self.error(name, f"has values of type {value.dtype}")
        return value


def _read(fields: _Fields) -> Recording:
    text = str(fields.array("contents", "U"))
    try:
        contents = json.loads(text)
        if contents["format"] != FORMAT:
            raise fields.error("contents", f"is of format {contents['format']!r}, not {FORMAT!r}")
        spaces = {name: _space(entry) for name, entry in contents["spaces"]}
        episodes = [_episode(fields, f"episode{i}", entry, spaces) for i, entry in enumerate(contents["episodes"])]
        edges = tuple(Interaction.parse(name) for name in contents["interactions"])
        seed = int(contents["seed"])
        return Recording(contents["scenario"], contents["physics"], seed, spaces, tuple(episodes), edges)
    except InputError:
        raise
    except Exception as error:
        raise fields.error("contents", f"is malformed ({type(error).__name__}: {error})") from error


def _space(entry: dict[str, Any]) -> StateSpace:
    variables = []
    for item in entry["variables"]:
        role = Role(**item["role"]) if item["role"] is not None else None
        variables.append(Variable(**{**item, "role": role}))
    return StateSpace(entry["type"], tuple(variables))


def _episode(fields: _Fields, key: str, entry: dict[str, Any], spaces: dict[str, StateSpace]) -> RecordedEpisode:
    readouts = {}
    for j, (label, unit) in enumerate(entry["readouts"]):
        values = fields.array(f"{key}.readout{j}", "fU")
        readouts[label] = Readout(values.tolist() if values.dtype.kind == "U" else values, unit)
    strips = {
        label: Strip(fields.array(f"{key}.strip{j}"), unit, float(lower), float(upper))
        for j, (label, unit, lower, upper) in enumerate(entry["strips"])
    }
    return RecordedEpisode(
        name=entry["name"],
        times=fields.array(f"{key}.times"),
        states={name: fields.array(f"{key}.state{j}") for j, name in enumerate(spaces)},
        plant_positions=fields.array(f"{key}.plant_positions") if entry["plant"] else None,
        readouts=readouts,
        lines={name: fields.array(f"{key}.line{j}") for j, name in enumerate(entry["lines"])},
        active={name: fields.array(f"{key}.active{j}", "b") for j, name in enumerate(entry["active"])},
        strips=strips,
    )

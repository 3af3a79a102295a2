"""Rows of an evaluation on disk, one line each as they come, so that whatever ends it keeps what was done."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ichain_drake.errors import InputError
from ichain_drake.files import json_value, read_whole, write_whole

_ABOUT = "about"


def rows_beside(report: Path) -> Path:
    """The file of a report's rows: `report.json` has `report.rows.jsonl`."""
    return report.with_name(f"{report.stem}.rows.jsonl")


class RowFile:
    """What was found so far, by id, in memory and on disk.

    The first line says what is evaluated; each further line is one finding. A line is written at once and reaches the
    disk before `add` returns; a line that a kill left half written is dropped when the file is read.

    Args:
        file: where to; None to keep it in memory alone.
        about: what is evaluated. Rows of another evaluation are never mixed in.
        resume: go on from what is in the file; otherwise it is begun anew.

    Raises:
        InputError: if the file can't be read or written, or is of another evaluation.
    """

    def __init__(
        self, file: Path | None = None, about: Mapping[str, Any] | None = None, *, resume: bool = False
    ) -> None:
        self.file = file
        self.found: dict[str, Any] = {}
        if file is None:
            return
        told = {_ABOUT: json.loads(json.dumps(about or {}))}
        try:
            lines = _lines(file) if resume and file.is_file() else []
            if lines and lines[0] != told:
                raise InputError(f"{file}: its rows are of another evaluation ({_difference(lines[0], told)}); leave "
                                 "--resume out to begin anew, or give another --report")  # fmt: skip
            self.found = {line["id"]: line["found"] for line in lines[1:]}
            file.parent.mkdir(parents=True, exist_ok=True)
            text = "".join(json.dumps(line, allow_nan=False) + "\n" for line in [told, *lines[1:]])
            write_whole(file, text.encode())
        except OSError as error:
            raise InputError(f"{file}: can't keep rows there ({error.strerror or error})") from None

    def add(self, found: Mapping[str, Any]) -> None:
        """Keep findings.

        Args:
            found: by id; plain data.

        Raises:
            InputError: if they can't be written.
        """
        self.found.update(found)
        if self.file is None:
            return
        try:
            with self.file.open("a") as stream:
                for key, value in found.items():
                    stream.write(json.dumps({"id": key, "found": value}, allow_nan=False) + "\n")
                stream.flush()
                os.fsync(stream.fileno())
        except OSError as error:
            raise InputError(f"{self.file}: can't keep rows there ({error.strerror or error})") from None

    def of(self, ids: Iterable[str]) -> list[Any]:
        """What was found for these ids, in their order; those without are left out."""
        return [self.found[key] for key in ids if key in self.found]


def _lines(file: Path) -> list[dict[str, Any]]:
    """The lines of a file up to the first that is not whole."""
    out: list[dict[str, Any]] = []
    for line in read_whole(file, "the rows kept there").split(b"\n"):
        try:
            entry = json_value(line, str(file))
        except InputError:
            break
        if not isinstance(entry, dict) or not (_is_row(entry) if out else _is_head(entry)):
            break
        out.append(entry)
    return out


def _is_head(entry: Mapping[str, Any]) -> bool:
    return set(entry) == {_ABOUT} and isinstance(entry[_ABOUT], dict)


def _is_row(entry: Mapping[str, Any]) -> bool:
    return set(entry) == {"id", "found"} and isinstance(entry["id"], str)


def _difference(old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    a, b = old[_ABOUT], new[_ABOUT]
    key = next((k for k in (*b, *a) if (k in a, a.get(k)) != (k in b, b.get(k))), _ABOUT)
    return f"{key}: {json.dumps(a.get(key))}, now {json.dumps(b.get(key))}"

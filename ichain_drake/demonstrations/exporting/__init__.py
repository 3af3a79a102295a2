"""Demonstrations in other people's formats: LeRobot, MCAP (extra `logs`)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ichain_drake.demonstrations.exporting.columns import by_columns
from ichain_drake.demonstrations.exporting.lerobot import lerobot_files
from ichain_drake.demonstrations.exporting.mcap_file import mcap_files
from ichain_drake.demonstrations.table import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.files import reason_of, write_whole

FORMATS = ("lerobot", "mcap")


def export_pieces(form: str, pieces: Sequence[Demonstration], folder: Path, task: str = "demonstration") -> list[Path]:
    """Write pieces in another format, with a `map.yaml` by which `ichain import` reads them back.

    Pieces that hold different columns go into folders of their own, named after the first piece of each.

    Args:
        form: a name of `FORMATS`.
        pieces: to write.
        folder: where to; it must not be there yet, or be empty.
        task: what they show, in a sentence (LeRobot).

    Returns:
        The folders that were written, each with a map.

    Raises:
        InputError: on an unknown format, a folder that holds something, two pieces of one name, or pieces that the
            format can't hold.
    """
    if form not in FORMATS:
        raise InputError(f"format {form!r:.40}: unknown; there are {', '.join(FORMATS)}")
    stems = [Path(p.name).stem for p in pieces]
    twice = next((s for s in stems if stems.count(s) > 1), None)
    if twice is not None or not pieces:
        raise InputError(f"two pieces are called {twice}; give each its own name" if pieces else "no piece is given")
    sets = by_columns(pieces)
    written = {}
    for columns, group in sets.items():
        place = folder if len(sets) == 1 else folder / Path(group[0].name).stem
        written[place] = lerobot_files(group, columns, task) if form == "lerobot" else mcap_files(group, columns)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise InputError(f"{folder}: holds something already; give another folder")
        for place, files in written.items():
            for name, content in files.items():
                (place / name).parent.mkdir(parents=True, exist_ok=True)
                write_whole(place / name, content, new=True)
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise InputError(f"{folder}: can't write there: {reason_of(error)}") from None
    return list(written)


__all__ = ["FORMATS", "export_pieces"]

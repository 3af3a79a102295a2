"""Where a run writes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from ichain_drake.errors import InputError
from ichain_drake.files import real_path, unused_folder
from ichain_drake.runs.paths.output import prepare_file, prepare_folder
from ichain_drake.visualization.rerun_file import require_rerun


@dataclass(frozen=True)
class RunFiles:
    """Where a run writes.

    Attributes:
        folder: for whatever is not named below.
        record: the playback; default `playback.html` in the folder.
        report: the report; `-` for stdout; default `report.json` in the folder.
        rerun: a recording for rerun; none by default.
    """

    folder: Path
    record: Path | None = None
    report: str | None = None
    rerun: Path | None = None

    @property
    def playback(self) -> Path:
        """File of the playback."""
        return self.record or self.folder / "playback.html"

    @property
    def _rerun(self) -> list[Path]:
        return [] if self.rerun is None else [self.rerun]

    @cached_property
    def demonstrations(self) -> Path:
        """Folder for what is recorded; that of an earlier run is left as it is."""
        return unused_folder(self.folder / "demonstrations")

    def check_apart(self, read: Sequence[Path] = ()) -> None:
        """See that nothing is written twice, or over what is read.

        Args:
            read: files that the run reads.

        Raises:
            InputError: naming the file; or if rerun is asked for and not installed.
        """
        if self.record is not None and self.record.suffix != ".html":
            raise InputError(f"--record {self.record}: a playback ends in .html")
        if self.rerun is not None:
            if self.rerun.suffix != ".rrd":
                raise InputError(f"--rerun {self.rerun}: a recording for rerun ends in .rrd")
            require_rerun()
        seen = {real_path(file): "is what the run reads" for file in read}
        report = [] if self.report == "-" else [Path(self.report) if self.report else self.folder / "report.json"]
        for file in (self.playback, *self._rerun, *report, self.folder / "paths.png", self.folder / "timeline.png"):
            place = real_path(file)
            if place in seen:
                raise InputError(f"{file}: {seen[place]}; give another name for what is written")
            if file.suffix in (".parquet", ".csv"):
                raise InputError(f"{file}: is named like a table, and what is written there is none; give another name")
            seen[place] = "is where something else of this run is written"

    def prepare(self) -> None:
        """Make sure that everything can be written before the work starts.

        Raises:
            InputError: naming the folder or file that can't.
        """
        prepare_folder(self.folder)
        for file in (self.playback, *self._rerun, self.folder / "paths.png", self.folder / "timeline.png"):
            prepare_file(file)
        if self.report != "-":
            prepare_file(Path(self.report) if self.report else self.folder / "report.json")

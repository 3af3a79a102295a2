"""A run's playback inside a notebook."""

from __future__ import annotations

import html
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from ichain_drake.errors import InputError
from ichain_drake.files import write_whole
from ichain_drake.runs.goals.run import GraphRun
from ichain_drake.runs.output import write_playback_of
from ichain_drake.runs.paths.result import PathRun


@dataclass(frozen=True)
class PlaybackPage:
    """A playback as one page that needs no other file, no server and no network.

    Attributes:
        content: the page (HTML).
        height: of its frame in a notebook [px].
    """

    content: str = field(repr=False)
    height: int = 560

    def write(self, file: str | Path) -> None:
        """Write it as a file that a browser opens.

        Raises:
            InputError: if the file can't be written.
        """
        write_whole(Path(file), self.content.encode())

    def _repr_html_(self) -> str:
        """What a notebook shows: the page in a frame of its own, so that styles and scripts don't meet."""
        page = html.escape(self.content, quote=True)
        return (
            f'<iframe title="playback" width="100%" height="{self.height}" style="border: 0" srcdoc="{page}"></iframe>'
        )


def show(run: PathRun | GraphRun, height: int = 560) -> PlaybackPage:
    """The playback of a run: as the last line of a notebook's cell it appears below the cell.

    Args:
        run: with something recorded.
        height: of the frame [px].

    Raises:
        InputError: if nothing was recorded yet.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "playback.html"
        if not write_playback_of(run, file):
            raise InputError(f"{run.scenario.name}: there is nothing to play yet; run it before it is shown")
        return PlaybackPage(file.read_text(encoding="utf-8"), height)

"""What `teach --browser` and `run --meshcat` do in the browser."""

from __future__ import annotations

import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ichain_drake.cli.console import Reporter
from ichain_drake.runs.browser_teaching import TeachingSession
from ichain_drake.runs.live import LiveRun
from ichain_drake.runs.paths.output import prepare_folder
from ichain_drake.scenarios import Scenario
from ichain_drake.scenarios.base import Progress
from ichain_drake.scenarios.seats import choose_seat
from ichain_drake.simulation.watching import watched_by


def teach_in_browser(scenario: Scenario, folder: Path, drive: str, *, opened: bool) -> None:
    """`ichain teach --browser`: a person demonstrates until she ends it.

    Args:
        scenario: what is demonstrated.
        folder: where pieces go, each as soon as it is kept.
        drive: name of the object to drive; empty for the scenario's choice.
        opened: whether to open a browser.

    Raises:
        InputError: on an object that nobody can drive, or a folder that can't be written.
    """
    seat = choose_seat(scenario, drive)
    prepare_folder(folder)
    reporter = Reporter()
    session = TeachingSession(scenario, seat, folder, reporter.note)
    announce(session.address, opened=opened)
    with reporter:
        pieces = session.run()
    for piece in pieces:
        print(f"written: {folder / piece.name}.parquet, {len(piece)} rows")
    if not pieces:
        print("no piece was kept")


@contextmanager
def shown_live(
    scenario: Scenario, say: Reporter, *, meshcat: bool, realtime: bool
) -> Iterator[tuple[LiveRun | None, Progress]]:
    """Show what runs inside in the browser, if asked to.

    Args:
        scenario: what runs.
        say: reports progress.
        meshcat: whether to show it.
        realtime: whether simulated seconds take as long as real ones.

    Yields:
        The live run, or None; and what to call with lines of progress.
    """
    if not meshcat:
        yield None, say
        return
    live = LiveRun(scenario, realtime=realtime)
    say.note(f"open in a web browser: {live.address}")

    def tell(line: str) -> None:
        say(line)
        live.say(line)

    try:
        with watched_by(live):
            yield live, tell
    finally:
        live.close()


def announce(address: str, *, opened: bool) -> None:
    """Say where to look, and open it if asked to and a browser is there."""
    there = opened and webbrowser.open(address)
    print(f"{'opened' if there else 'open in a web browser'}: {address}", flush=True)

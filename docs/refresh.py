"""Rewrites the tables of README and pages from what was measured: `python docs/refresh.py`; `--check` only compares.

A table stands between `<!-- TABLE_NAME: begin -->` and `<!-- TABLE_NAME: end -->`. What is printed there comes from a
report in `benchmarks/`:

    TABLE_SCOREBOARD           scoreboard.json, all rows
    TABLE_SCOREBOARD_KETTLE    scoreboard.json, the rows of one system
    TABLE_SYSTEMS              scoreboard.json, one line a system
    TABLE_RULES                rules.json, what each rule is worth
    TABLE_CONSTANTS            no report: the constants of learning and control that are in force
    TABLE_ANY_NAME             any_name.json: the text that its command printed

Under each table stand the library's version, the date, and the command that printed it. A table without a report is
left alone. Nothing is measured here: write a report with the command's `--report benchmarks/NAME.json`.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ichain_drake.runs.intervals import success_interval, success_words
from ichain_drake.scenarios.settings_list import list_constants, markdown_table

ROOT = Path(__file__).parent.parent
BLOCK = re.compile(r"<!-- TABLE_(\w+): begin -->\n(.*?)<!-- TABLE_\1: end -->", re.DOTALL)
COMMAND_ABOVE = re.compile(r"^    (ichain [^\n]+)\n\n\Z", re.MULTILINE)
SCOREBOARD, SYSTEMS, RULES, CONSTANTS = "SCOREBOARD", "SYSTEMS", "RULES", "CONSTANTS"
ABOUT = {  # where each system is described, and what it is asked for
    "car_game": ("car game", "docs/car_game.md", "follow three paths"),
    "hover_game": ("hovercraft", "docs/hover_game.md", "the same joystick, another game"),
    "car_racing": ("CarRacing of Gymnasium", "docs/car_racing.md", "the same joystick, nobody's game here"),
    "driving": ("driving", "docs/driving.md", "a wheel, a road car"),
    "ship": ("ship", "docs/ship.md", "the same wheel, a ship"),
    "water_dispenser": ("water dispenser", "docs/water_dispenser.md", "a cup of hot water"),
    "two_dispensers": ("two dispensers", "docs/water_dispenser.md", "hot water out of two machines"),
    "microwave": ("microwave", "docs/microwave.md", "hot food outside, door shut"),
    "kettle": ("bottle and kettle", "docs/kettle.md", "hot water back in the bottle"),
    "lidded_pot": ("lidded pot", "docs/lidded_pot.md", "water under a lid that one of two hands holds open"),
}


def pages(root: Path) -> list[Path]:
    """README and everything in `docs`."""
    return [root / "README.md", *sorted((root / "docs").glob("*.md"))]


def source(name: str, root: Path) -> Path:
    """The report that a table is printed from."""
    file = "scoreboard" if name.startswith(SCOREBOARD) or name == SYSTEMS else name.lower()
    return root / "benchmarks" / f"{file}.json"


def render(name: str, report: Mapping[str, Any]) -> str:
    """What stands between the markers.

    Args:
        name: of the table, without `TABLE_`.
        report: from its source.
    """
    if name == SYSTEMS:
        body = systems_table(report["table"])
    elif name == RULES:
        body = rules_table(report["ablation"])
    elif name.startswith(SCOREBOARD):
        system = name.removeprefix(SCOREBOARD).removeprefix("_").lower()
        body = scoreboard_table([line for line in report["table"] if system in ("", line["system"])])
    else:
        body = f"```\n{report['text'].rstrip()}\n```"
    said = f"ichain_drake {report['versions']['ichain_drake']}, {report['date']}: `{report['command']}`"
    return f"{body}\n\n{said}\n"


def scoreboard_table(lines: Sequence[Mapping[str, Any]]) -> str:
    """One row a line of the scoreboard."""
    head = (
        "system",
        "task",
        "physics",
        "fault",
        "success",
        "also",
        "steps",
        "replans",
        "silent",
        "error",
        "x oracle",
        "wall [s]",
    )
    rows = [
        (
            line["system"], line["task"], line["physics"], line["fault"], success([line]),
            str(line["failed_without"] or ""),
            figure(line["median_steps"], 0), figure(line["mean_replans"], 1), str(line["silent"]),
            f"{figure(line['mean_error'], 3)} {line['unit']}".strip(), figure(line["ratio_to_oracle"], 2),
            figure(line["wall_seconds"], 0),
        )
        for line in lines
    ]  # fmt: skip
    return markdown(head, rows)


def systems_table(lines: Sequence[Mapping[str, Any]]) -> str:
    """One row a system, without faults: successes over all tasks, errors from the smallest to the largest of a task."""
    rows = []
    for name in dict.fromkeys(line["system"] for line in lines):
        title, page, task = ABOUT.get(name, (name, "", ""))
        own = [line for line in lines if line["system"] == name and line["fault"] == "none"]
        by = {p: [line for line in own if line["physics"] == p] for p in ("ideal", "arm", "contact")}
        paths = [line for line in by["ideal"] if line["task"] != "goal" and line["mean_error"] is not None]
        ratios = [line["ratio_to_oracle"] for line in paths if line["ratio_to_oracle"] is not None]
        error = f"{span([line['mean_error'] for line in paths], 3)} {paths[0]['unit']}" if paths else ""
        error += f", {span(ratios, 2)} x" if ratios else ""
        rows.append((f"[{title}]({page})" if page else title, task, *(success(by[p]) for p in by), error))
    return markdown(("", "goal", "`ideal`", "`arm`", "`contact`", "error, beside the oracle's"), rows)


def rules_table(lines: Sequence[Mapping[str, Any]]) -> str:
    """One row a rule: how much worse the same trials are without it."""
    head = ("without", "pairs", "differ", "lost", "won", "silent", "steps", "replans", "rows that need it")
    rows = [
        (
            f"`{line['rule']}`", *(str(line[key]) for key in ("pairs", "differ", "lost", "won")),
            f"{line['silent']:+d}", figure(line["steps"], 3), f"{line['replans']:+.2f}", ", ".join(line["need"]),
        )
        for line in lines
    ]  # fmt: skip
    return markdown(head, rows)


def constants_table() -> str:
    """One row a constant: what it is, its unit and range, and why."""
    return f"{markdown_table(list_constants())}\n"


def success(lines: Sequence[Mapping[str, Any]]) -> str:
    """Successes of several lines, with Wilson's interval."""
    reached, runs = sum(line["reached"] for line in lines), sum(line["runs"] for line in lines)
    return success_words(reached, runs, success_interval(reached, runs)) if runs else ""


def figure(value: float | None, digits: int) -> str:
    """A number, or a dash."""
    return "-" if value is None else f"{value:.{digits}f}"


def span(values: Sequence[float], digits: int) -> str:
    """Smallest and largest."""
    low, high = (f"{f(values):.{digits}f}" for f in (min, max))
    return low if low == high else f"{low} to {high}"


def markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def tables(page: Path) -> Iterator[tuple[str, str, str]]:
    """Name and content of each table of a page, and the command that stands above it, empty if there is none."""
    text = page.read_text()
    for found in BLOCK.finditer(text):
        above = COMMAND_ABOVE.search(text[: found.start()])
        yield found[1], found[2], above[1] if above else ""


def differences(page: Path, root: Path) -> list[str]:
    """What is not as its report says, in words; tables without a report are passed over."""
    out = []
    for name, content, above in tables(page):
        file = source(name, root)
        where = f"{page.name}: TABLE_{name}"
        if name == CONSTANTS and content != constants_table():
            out.append(f"{where} is not what is in force: run `python docs/refresh.py`")
        if name == CONSTANTS or not file.is_file():
            continue
        report = json.loads(file.read_text())
        printed, now = report["versions"]["ichain_drake"], version("ichain_drake")
        if printed != now:
            out.append(f"{where} is of version {printed}, this is {now}: run `{report['command']}` anew")
        if above and above != report["command"]:
            out.append(f"{where}: above it stands `{above}`, but it was printed by `{report['command']}`")
        if content != render(name, report):
            out.append(f"{where} differs from {file.name}: run `python docs/refresh.py`")
    return out


def refresh(page: Path, root: Path) -> list[str]:
    """Rewrite a page's tables; names of those that have no report."""
    missing = []

    def new(found: re.Match[str]) -> str:
        file = source(found[1], root)
        if found[1] != CONSTANTS and not file.is_file():
            missing.append(found[1])
            return found[0]
        body = constants_table() if found[1] == CONSTANTS else render(found[1], json.loads(file.read_text()))
        return f"<!-- TABLE_{found[1]}: begin -->\n{body}<!-- TABLE_{found[1]}: end -->"

    text = page.read_text()
    after = BLOCK.sub(new, text)
    if after != text:
        page.write_text(after)
        print(f"rewritten: {page.relative_to(root)}")
    return missing


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """The command; returns its exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--check", action="store_true", help="only say what is stale; exit status 1 if anything is")
    check = parser.parse_args(arguments).check
    if check:
        stale = [line for page in pages(root) for line in differences(page, root)]
        print("\n".join(stale) or "every table that has a report is as it says")
        return 1 if stale else 0
    for page in pages(root):
        for name in refresh(page, root):
            print(f"left as it is: {page.name}: TABLE_{name}, since there is no {source(name, root).relative_to(root)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

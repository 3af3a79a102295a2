"""Tables of README and pages are what their reports say, by the library that is here."""

import importlib.util
import json
from importlib.metadata import version
from pathlib import Path

import pytest

from ichain_drake.runs.intervals import success_interval

ROOT = Path(__file__).parent.parent


def load():
    spec = importlib.util.spec_from_file_location("refresh", ROOT / "docs" / "refresh.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


refresh = load()
TABLES = [(page, name) for page in refresh.pages(ROOT) for name, _, _ in refresh.tables(page)]


@pytest.mark.parametrize(("page", "name"), TABLES, ids=lambda v: getattr(v, "name", v))
def test_a_table_is_what_its_report_says(page, name):
    if name != refresh.CONSTANTS and not refresh.source(name, ROOT).is_file():
        pytest.skip(f"there is no {refresh.source(name, ROOT).relative_to(ROOT)} to print TABLE_{name} from")
    assert [line for line in refresh.differences(page, ROOT) if f"TABLE_{name} " in f"{line} ".replace(":", " ")] == []


def test_markers_come_in_pairs():
    for page in refresh.pages(ROOT):
        text = page.read_text()
        assert text.count(": begin -->") == text.count(": end -->") == len(list(refresh.tables(page))), page.name


def line(system, task, physics, fault, reached, runs, **more):
    return {
        "row": f"{system}/{task}/{physics}/{fault}", "system": system, "task": task, "physics": physics, "fault": fault,
        "reached": reached, "runs": runs, "interval": success_interval(reached, runs), "median_steps": 300.0,
        "mean_replans": None, "silent": 0, "mean_error": 0.63, "unit": "px", "ratio_to_oracle": 1.05,
        "wall_seconds": 9.0, "failed_without": None,
    } | more  # fmt: skip


@pytest.fixture
def book(tmp_path):
    """A root with two pages and two reports."""
    (tmp_path / "docs").mkdir()
    (tmp_path / "benchmarks").mkdir()
    about = {"versions": {"ichain_drake": version("ichain_drake")}, "date": "2026-01-02"}
    lines = [
        line("car_game", "eight", "ideal", "none", 20, 20),
        line("car_game", "spiral", "ideal", "none", 19, 20, mean_error=0.7, ratio_to_oracle=1.1),
        line("car_game", "eight", "ideal", "noise", 3, 20),
        line(
            "kettle",
            "goal",
            "contact",
            "none",
            2,
            7,
            mean_error=0.0,
            unit="of range",
            ratio_to_oracle=None,
            failed_without=3,
        ),  # fmt: skip
    ]
    board = {**about, "command": "ichain scoreboard --trials 20", "table": lines}
    (tmp_path / "benchmarks" / "scoreboard.json").write_text(json.dumps(board))
    (tmp_path / "benchmarks" / "costs.json").write_text(
        json.dumps({**about, "command": "ichain benchmarks", "text": "a  b"})
    )
    worth = {
        "rule": "a_rule", "pairs": 5, "differ": 3, "lost": 2, "won": 0, "p": 0.5, "silent": 1, "steps": 1.25,
        "replans": 0.4, "need": ["kettle/goal/contact/none"],
    }  # fmt: skip
    (tmp_path / "benchmarks" / "rules.json").write_text(
        json.dumps({**about, "command": "ichain scoreboard --ablate", "table": lines, "ablation": [worth]})
    )
    (tmp_path / "README.md").write_text(
        "Before\n\n    ichain benchmarks\n\n<!-- TABLE_COSTS: begin -->\nold\n<!-- TABLE_COSTS: end -->\n"
        "<!-- TABLE_SYSTEMS: begin -->\n<!-- TABLE_SYSTEMS: end -->\n"
        "<!-- TABLE_RULES: begin -->\n<!-- TABLE_RULES: end -->\n"
        "<!-- TABLE_OTHER: begin -->\nkept\n<!-- TABLE_OTHER: end -->\n"
    )
    (tmp_path / "docs" / "kettle.md").write_text(
        "<!-- TABLE_SCOREBOARD_KETTLE: begin -->\n<!-- TABLE_SCOREBOARD_KETTLE: end -->\n"
    )
    return tmp_path


def test_tables_are_rewritten_with_version_date_and_command(book, capsys):
    assert refresh.main([], book) == 0
    said = capsys.readouterr().out
    assert "left as it is: README.md: TABLE_OTHER, since there is no benchmarks/other.json" in said
    readme = (book / "README.md").read_text()
    stamp = f"ichain_drake {version('ichain_drake')}, 2026-01-02: "
    assert f"```\na  b\n```\n\n{stamp}`ichain benchmarks`\n<!-- TABLE_COSTS: end -->" in readme
    assert "<!-- TABLE_OTHER: begin -->\nkept\n" in readme
    car = "follow three paths | 39/40 (.87-1.00) |  |  | 0.630 to 0.700 px, 1.05 to 1.10 x |"
    assert f"| [car game](docs/car_game.md) | {car}" in readme
    assert "| [bottle and kettle](docs/kettle.md) | hot water back in the bottle |  |  | 2/7 (.08-.64) |  |" in readme
    assert "| `a_rule` | 5 | 3 | 2 | 0 | +1 | 1.250 | +0.40 | kettle/goal/contact/none |" in readme
    kettle = (book / "docs" / "kettle.md").read_text()
    assert "| kettle | goal | contact | none | 2/7 (.08-.64) | 3 | 300 | - | 0 | 0.000 of range | - | 9 |" in kettle
    assert "car_game" not in kettle
    assert f"{stamp}`ichain scoreboard --trials 20`" in kettle
    assert refresh.main(["--check"], book) == 0
    before = readme
    refresh.main([], book)
    assert (book / "README.md").read_text() == before


@pytest.mark.parametrize(
    ("file", "change", "message"),
    [
        ("costs.json", {"text": "a  c"}, "README.md: TABLE_COSTS differs from costs.json"),
        (
            "costs.json",
            {"command": "ichain benchmarks --x"},
            "above it stands `ichain benchmarks`, but it was printed",
        ),
        ("scoreboard.json", {"versions": {"ichain_drake": "0.0.1"}}, "TABLE_SYSTEMS is of version 0.0.1, this is"),
        ("scoreboard.json", {"command": "ichain scoreboard"}, "kettle.md: TABLE_SCOREBOARD_KETTLE differs"),
    ],
)
def test_what_is_stale_is_said(book, capsys, file, change, message):
    refresh.main([], book)
    report = book / "benchmarks" / file
    report.write_text(json.dumps(json.loads(report.read_text()) | change))
    assert refresh.main(["--check"], book) == 1
    assert message in capsys.readouterr().out


def test_constants_that_are_no_longer_in_force(book):
    page = book / "docs" / "constants.md"
    page.write_text("<!-- TABLE_CONSTANTS: begin -->\n| `tracking.kept` |\n<!-- TABLE_CONSTANTS: end -->\n")
    assert refresh.differences(page, book) == [
        "constants.md: TABLE_CONSTANTS is not what is in force: run `python docs/refresh.py`"
    ]
    assert refresh.refresh(page, book) == []
    assert refresh.differences(page, book) == []
    assert "| `tracking.kept` | share |" in page.read_text()

"""What a person marks: read, checked line by line, and merged into flags and cuts."""

from dataclasses import replace
from pathlib import Path

import bath_log
import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.learning.discovery.cuts import cut_pieces
from ichain_drake.learning.discovery.marks import Mark, check_marks, make_marks, marked, read_marks, write_marks
from ichain_drake.runs.discovery_scores import joined
from ichain_drake.timing import TICK

PIECES = bath_log.pieces()
FIRST = len(PIECES[0])
LOG = joined(PIECES, "log.csv")
HEAD = "piece,interaction,from,to,active,name\n"


def read(text: str, folder: Path) -> list[Mark]:
    file = folder / "marks.csv"
    file.write_text(HEAD + text)
    return read_marks(file)


def test_they_come_back_as_they_were_written(tmp_path: Path) -> None:
    marks = [Mark("log.csv", "hand->lever", 2.0, 4.0, True), Mark("log.csv", "cut", 9.0, 9.0, False)]
    marks.append(Mark("log.csv", "cut", 12.0, 12.0, True, "open-tap"))
    write_marks(marks, tmp_path / "marks.csv")
    back = read_marks(tmp_path / "marks.csv")
    assert [replace(m, where="marks") for m in back] == marks
    assert back[1].where == f"{tmp_path / 'marks.csv'}: line 3"
    sent = [{"piece": "a", "interaction": "cut", "from": 1.0, "active": 1, "name": None}]
    assert make_marks(sent, "mark") == [Mark("a", "cut", 1.0, 1.0, True, "", "mark 1")]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("log.csv,hand->lever,a,2,1,", "line 2: column from: 'a' given; a number is needed"),
        ("log.csv,hand->lever,1,,1,", "line 2: column to: '' given"),
        ("log.csv,hand->lever,1,2,2,", "line 2: column active: 2 given; 1 is active, 0 is not"),
        ("log.csv,hand->lever,3,2,1,", "line 2: it ends at 2 s, before it begins at 3 s"),
        ("log.csv,hand->lever,1,2,1,x", "line 2: a name is for a cut"),
        ("log.csv,cut,1,,1,a/b", "line 2: name 'a/b': give letters, digits"),
        ("log,hand->lever,1,2,1,", "line 2: there is no recording 'log'; there are log.csv"),
        ("log.csv,lever->hand,1,2,1,", "line 2: 'lever->hand' is no interaction of the graph; it has hand->lever"),
        ("log.csv,hand->lever,1,9999,1,", "line 2: 1 to 9999 s, but log.csv lasts from 0 to "),
        ("log.csv,hand->lever,1.17,1.18,1,\n", "line 2: log.csv has no row from 1.17 to 1.18 s"),
        ("log.csv,hand->lever,1,5,1,\nlog.csv,hand->lever,4,6,0,", "line 3: it says the opposite of .*: line 2 on"),
        ("log.csv,cut,5,,1,a\nlog.csv,cut,9,,1,a", "line 3: the name a is given at .*: line 2, too"),
    ],
)
def test_each_mistake_is_one_line(line: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message) as caught:
        check_marks(read(line, tmp_path), [LOG], bath_log.GRAPH)
    assert "\n" not in str(caught.value)


def test_a_table_without_its_columns_is_refused(tmp_path: Path) -> None:
    (tmp_path / "marks.csv").write_text("piece,interaction,from,to\nlog.csv,a->b,1,2\n")
    with pytest.raises(InputError, match="column active is missing; its columns are piece, interaction, from, to,"):
        read_marks(tmp_path / "marks.csv")


def test_times_of_a_clock_that_goes_back_say_nothing() -> None:
    back = replace(LOG, table=LOG.table.assign(time=np.r_[LOG.table["time"][:50], LOG.table["time"][:-50]]))
    with pytest.raises(InputError, match=r"the clock of log.csv goes back"):
        check_marks([Mark("log.csv", "hand->lever", 1.0, 2.0, True)], [back], bath_log.GRAPH)


def test_marks_become_flags_and_leave_the_rest_open() -> None:
    marks = [Mark("log.csv", "hand->lever", 2.0, 4.0, True), Mark("log.csv", "hand->lever", 5.0, 6.0, False)]
    flags = marked(LOG, [*marks, Mark("other.csv", "lever->tank", 0.0, 9.0, True)]).table["hand->lever"]
    assert flags[6:13].eq(1).all()
    assert flags[15:19].eq(0).all()
    assert flags.notna().sum() == 7 + 4
    known = replace(LOG, table=LOG.table.assign(**{"hand->lever": 0.0}))
    assert marked(known, marks).table["hand->lever"].sum() == 7  # what was marked counts more
    assert marked(LOG, []) is LOG


def test_cuts_are_moved_joined_and_named() -> None:
    found = [c.row for c in cut_pieces([LOG], bath_log.GRAPH).cuts]
    told = [
        Mark("log.csv", "cut", 0.0, 0.0, True, "first"),
        Mark("log.csv", "cut", found[0] * TICK, found[0] * TICK, False),  # moved by two rows
        Mark("log.csv", "cut", (found[0] + 2) * TICK, (found[0] + 2) * TICK, True, "second"),
        Mark("log.csv", "cut", found[1] * TICK, found[1] * TICK, False),  # joined
        Mark("log.csv", "cut", found[2] * TICK, found[2] * TICK, True, "third"),  # named
    ]
    cut = cut_pieces([LOG], bath_log.GRAPH, marks=told)
    assert [c.row for c in cut.cuts] == [found[0] + 2, *found[2:]]
    assert [p.name for p in cut.pieces] == ["first.csv", "second.csv", "third.csv", "log-part04.csv"]
    assert cut.begins == tuple(("log.csv", row) for row in (0, found[0] + 2, *found[2:]))
    assert cut.cuts[0].why == "marked by a person"
    assert cut.cuts[1].why.startswith("reset")


def test_what_a_gap_keeps_apart_is_not_joined() -> None:
    time = TICK * np.arange(FIRST)
    time[20:] += 5.0
    log = replace(LOG, table=LOG.table[:FIRST].assign(time=time))
    with pytest.raises(InputError, match=r"marks: log.csv can't be joined at 11.67 s: gap of 5.333 s"):
        cut_pieces([log], bath_log.GRAPH, marks=[Mark("log.csv", "cut", time[20], time[20], False)])

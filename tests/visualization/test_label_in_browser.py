"""A person marks a long recording in a real browser; what is saved becomes flags and pieces."""

import json
import re
import subprocess
import sys
from pathlib import Path

import bath_log
import pytest
from patience import until

from ichain_drake.cli.main import main
from ichain_drake.demonstrations import read_folder
from ichain_drake.learning.discovery.marks import read_marks

PIECES = bath_log.pieces()
FIRST = len(PIECES[0])
HAND, TAP = (e.name for e in bath_log.GRAPH.interactions)


class Page:
    """The page, as a person uses it."""

    def __init__(self, browser, address: str) -> None:
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.keys import Keys

        self.browser, self.chains, self.keys = browser, ActionChains, Keys
        browser.driver.set_window_size(1200, 900)  # other tests leave it small
        browser.open(address)

    def canvas(self, panel: int):
        return self.browser.driver.find_elements("css selector", "canvas")[panel]

    def drag(self, panel: int, edge: str, first: int, last: int) -> None:
        """Along a lane (the strip below them for no edge), from the middle of a row to that of another of the piece."""
        canvas = self.canvas(panel)
        lane = self.browser.js("return ichainData.interactions.indexOf(arguments[0])", edge) if edge else 3
        # Not below the bar, which stays on top.
        self.browser.js("window.scrollTo(0, arguments[0].getBoundingClientRect().top + scrollY - 200)", canvas)
        rows = self.browser.js(
            "return arguments[0].closest('section').innerText.match(/rows (\\d+) to (\\d+)/)", canvas
        )
        width = self.browser.js("return arguments[0].getBoundingClientRect().width", canvas)
        step = (width - 170) / (int(rows[2]) - int(rows[1]) + 1)
        x, y = 170 + (first + 0.5) * step - canvas.size["width"] / 2, lane * 18 + 8 - canvas.size["height"] / 2
        act = self.chains(self.browser.driver).move_to_element_with_offset(canvas, round(x), round(y))
        act.click_and_hold().move_by_offset(round((last - first) * step), 0).release().perform()

    def press(self, key: str) -> None:
        self.chains(self.browser.driver).send_keys(key).perform()

    def click(self, panel: int, text: str) -> None:
        (button,) = self.browser.driver.find_elements(
            "xpath", f"(//section)[{panel + 1}]//button[contains(., '{text}')]"
        )
        button.click()

    def name(self, panel: int, text: str) -> None:
        field = self.browser.driver.find_elements("css selector", "section input")[panel]
        field.send_keys(text + self.keys.ENTER)

    def said(self) -> str:
        return self.browser.js("return ichain.said()")


@pytest.fixture(scope="module")
def marked(browser, tmp_path_factory):
    """Two marks, one of them partly taken back, a cut that is moved, one that is joined, one more, and names."""
    folder = tmp_path_factory.mktemp("marked")
    bath_log.write_log(PIECES[:3], folder)
    words = ["label", str(folder / "log.csv"), "--marks", str(folder / "marks.csv"), "--browser", "--no-open"]
    command = [sys.executable, "-m", "ichain_drake", *words, "--robot", "hand", "-o", str(folder / "demos")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as program:
        try:
            line = program.stdout.readline()
            browser.complaints()  # those about pages of other tests are theirs
            page = Page(browser, re.search(r"http://127\.0\.0\.1:\d+/", line)[0])
            seen = {"panels": browser.js("return document.querySelectorAll('section').length")}
            page.drag(0, HAND, 5, 14)
            page.press("1")
            page.drag(0, HAND, 10, 14)
            page.press(page.keys.DELETE)
            page.drag(1, TAP, 3, 8)
            page.press("0")
            page.press("s")
            until(lambda: "2 marks saved" in page.said())
            page.click(1, "later")
            page.click(2, "join")
            page.drag(0, "", 20, 20)
            page.press("c")
            page.name(0, "reach/out")
            page.press("s")
            until(lambda: "NOT SAVED" in page.said())
            seen["refused"] = page.said()
            browser.driver.find_elements("css selector", "section input")[0].clear()
            page.name(0, "reach")
            seen["complaints"] = browser.complaints()
            page.press(page.keys.ESCAPE)
            said = program.stdout.read()
            status = program.wait()
            yield folder, status, said, seen
        finally:
            program.kill()


def test_marks_are_saved_as_they_were_made(marked) -> None:
    folder, status, _, seen = marked
    assert (status, seen["panels"], seen["complaints"]) == (0, 3, [])
    assert "name 'reach/out': give letters, digits" in seen["refused"]
    marks = read_marks(folder / "marks.csv")
    flags = [(m.interaction, round(3 * m.first), round(3 * m.last), m.active) for m in marks if m.interaction != "cut"]
    assert sorted(flags) == [("hand->lever", 5, 9, True), ("lever->tank", FIRST + 3, FIRST + 8, False)]
    cuts = {round(3 * m.first): (m.active, m.name) for m in marks if m.interaction == "cut"}
    joined_at = FIRST + len(PIECES[1])
    assert cuts == {
        0: (True, "reach"), 20: (True, ""), FIRST: (False, ""), FIRST + 1: (True, ""), joined_at: (False, "")
    }  # fmt: skip


def test_they_become_flags_and_pieces(marked, tmp_path: Path) -> None:
    folder, _, said, _ = marked
    pieces = {p.name: p for p in read_folder(folder / "demos")}
    assert {n: len(p) for n, p in pieces.items()} == {
        "reach.parquet": 20,
        "log-part02.parquet": FIRST + 1 - 20,
        "log-part03.parquet": len(PIECES[1]) + len(PIECES[2]) - 1,
    }
    flags = pieces["reach.parquet"].table["hand->lever"]
    assert flags[5:10].eq(1).all() and flags.notna().sum() == 5  # noqa: PT018
    assert "cuts.json" in said
    assert json.loads((folder / "demos" / "cuts.json").read_text())["pieces"]["reach"] == 20
    graph = tmp_path / "graph.yaml"
    assert main(["discover", str(folder / "demos"), "-o", str(graph), "--robot", "hand"]) == 0  # not cut again

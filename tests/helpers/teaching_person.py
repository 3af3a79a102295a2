"""Somebody at the browser: opens a page of `ichain`, holds keys, moves a gamepad that isn't there, presses buttons."""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

from patience import PATIENCE, until

GAMEPAD = """
window.pad = {index: 0, connected: true, id: 'simulated', axes: [0, 0, 0, 0],
  buttons: Array.from({length: 17}, () => ({value: 0, pressed: false}))};
navigator.getGamepads = () => [window.pad, null, null, null];
const start = performance.now();
window.wiggling = setInterval(() => {
  const t = (performance.now() - start) / 1000;
  pad.axes = [0.5 * Math.sin(1.1 * t) + 0.35 * Math.sin(2.9 * t), -0.5 - 0.35 * Math.sin(0.8 * t), 0, 0];
}, 40);
"""


class Program:
    """A running `ichain` command that serves a page."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.log = folder / f"{arguments[0]}.log"
        self.output = folder / f"{arguments[0]}.out"
        with self.log.open("w") as log, self.output.open("w") as output:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "ichain_drake", *arguments],
                stdout=output,
                stderr=log,
                env=os.environ | {"OMP_NUM_THREADS": "1"},
            )
        self.address = until(lambda: re.search(r"http://127\.0\.0\.1:\d+/", self.said()))[0]

    def said(self) -> str:
        return self.output.read_text() + self.log.read_text()

    def wait(self) -> int:
        return self.process.wait(timeout=PATIENCE)


class Person:
    """Uses the page in a browser (`Browser` of conftest.py)."""

    def __init__(self, browser, program: Program) -> None:
        from selenium.webdriver.common.action_chains import ActionChains  # noqa: PLC0415  (an optional package)
        from selenium.webdriver.common.keys import Keys  # noqa: PLC0415

        self.driver, self.program = browser.driver, program
        self.actions, self.keys = (lambda: ActionChains(self.driver)), Keys
        self.look()

    def look(self) -> None:
        """Open the page, small: the picture is drawn without a graphics card."""
        self.driver.set_window_size(520, 420)
        self.driver.get(self.program.address)
        # The panel may be there before Meshcat's controls are: a key pressed in between is nobody's.
        until(lambda: self.driver.execute_script("return Object.keys(viewer.gui_controllers).length > 0"))
        until(lambda: self.status().get("state") in ("idle", "recording", "running"))

    def leave(self) -> None:
        self.driver.get("about:blank")

    def status(self) -> dict:
        script = "return typeof ichainLive === 'object' && ichainLive.watching ? ichainLive.status : {}"
        return self.driver.execute_script(script)

    def press(self, key: str) -> None:
        self.actions().send_keys(key).perform()

    def hold(self, key: str, seconds: float) -> None:
        self.actions().key_down(key).perform()
        time.sleep(seconds)
        self.actions().key_up(key).perform()

    def value(self, label: str) -> str:
        return self.status().get("values", {}).get(label, "")

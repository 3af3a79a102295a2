"""Gamepads as browsers have them, in a real one: other mappings, none, unplugged, and what a page may not do."""

import json

import pytest
from pydrake.geometry import Sphere
from teaching_person import until

from ichain_drake.visualization.controls import Axis, Controls, PageButton
from ichain_drake.visualization.live_page import LivePage

FIREFOX = """
window.pad = {id: "of Firefox on Linux", index: 0, connected: true, mapping: "", timestamp: 1,
  axes: [0, 0, 0, 0, 0, 0, 0, 0],
  buttons: Array.from({length: 11}, () => ({value: 0, pressed: false, touched: false}))};
navigator.getGamepads = () => [window.pad, null, null, null];
"""
NONE = "navigator.getGamepads = () => [null, null, null, null];"
INSECURE = """
Object.defineProperty(window, "isSecureContext", {value: false});
Object.defineProperty(Navigator.prototype, "getGamepads", {value: undefined});
"""
NO_SOCKET = """
window.WebSocket = class extends WebSocket { constructor() { super("ws://127.0.0.1:9/"); } };
"""


@pytest.fixture(scope="module")
def controls(meshcat):
    meshcat.SetObject("ball", Sphere(0.1))
    return Controls(meshcat, [Axis("steer", ("KeyA", "KeyD"), ("left", "right"), 0)], [PageButton("go", "KeyG", "", 6)])


@pytest.fixture
def opened(browser, meshcat, controls):
    """Opens the page in a browser in which a script has run first; gives a function that runs more."""
    page = LivePage(meshcat, "title", controls.instructions(), controls.page_keys())
    page.show("idle", "waiting")
    added = []

    def open_after(script):
        command = browser.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": script})
        added.append(command["identifier"])
        browser.driver.get(page.address)
        until(lambda: browser.js("return typeof ichainLive === 'object' && ichainLive.status.state === 'idle'"))
        return browser.js

    yield open_after
    for identifier in added:
        browser.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", {"identifier": identifier})
    browser.driver.get("about:blank")
    page.close()


def gamepad_line(js):
    rows = js("return Array.from(document.querySelectorAll('#ichain-live .values tr'), r => r.textContent)")
    return next((row for row in rows if row.startswith("gamepad")), "")


def alarm(js):
    return js("return document.querySelector('#ichain-live .alarm').textContent")


def test_a_pad_of_firefox_on_linux_reads_as_any_other(opened, meshcat, controls):
    js = opened(FIREFOX)
    seen = json.loads(js("return JSON.stringify(navigator.getGamepads()[0])"))
    assert (len(seen["axes"]), len(seen["buttons"]), seen["mapping"]) == (4, 17, "standard")
    assert [b["value"] for b in seen["buttons"]] == [0.0] * 17  # also of triggers that have not been moved yet
    js("pad.axes = [0.5, 0, -1, 0.25, 0, -1, 0, 1];")
    seen = json.loads(js("return JSON.stringify(navigator.getGamepads()[0])"))
    assert seen["axes"] == [0.5, 0, 0.25, 0]
    assert [k for k, b in enumerate(seen["buttons"]) if b["value"]] == [13]  # the cross, down; triggers rest
    js("pad.axes = [0.5, 0, 1, 0, 0, -1, 0, 0];")
    until(lambda: controls.read()[0] > 0.4)
    until(lambda: controls.pressed() == ["go"])  # the left trigger
    until(lambda: "of Firefox on Linux" in gamepad_line(js))


def test_none_and_one_that_is_unplugged(opened, controls):
    js = opened(FIREFOX)
    until(lambda: "of Firefox" in gamepad_line(js))
    js("pad.axes = [0.9, 0, -1, 0, 0, -1, 0, 0];")
    until(lambda: controls.read()[0] > 0.8)
    js("window.pad = null")
    until(lambda: "the gamepad is gone" in alarm(js))
    until(lambda: controls.read()[0] == 0.0)  # what it held last is let go
    js("dispatchEvent(new KeyboardEvent('keydown', {code: 'KeyA'}))")
    until(lambda: "gone" not in alarm(js))


def test_no_gamepad_says_how_to_wake_one(opened):
    js = opened(NONE)
    until(lambda: "press one of its buttons" in gamepad_line(js))
    assert "gamepad" not in alarm(js)


def test_a_page_from_another_machine_says_what_the_browser_forbids(opened):
    js = opened(INSECURE)
    until(lambda: "plain http from another machine" in gamepad_line(js))


def test_a_scene_out_of_reach_is_said(opened):
    js = opened(NO_SOCKET)
    until(lambda: "is out of reach from this browser: forward that port, too" in alarm(js))

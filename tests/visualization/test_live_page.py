"""The server behind a live page: what it hands out, and what it says when it can't."""

import gc
import json
import re
import threading
import urllib.error
import urllib.request
import weakref

import pytest
from patience import PATIENCE
from pydrake.geometry import Meshcat, MeshcatParams

from ichain_drake.errors import IchainError
from ichain_drake.visualization import live_page
from ichain_drake.visualization.controls import Axis, Controls, PageButton, key_name
from ichain_drake.visualization.live_page import LivePage, _page


@pytest.fixture
def page(meshcat):
    page = LivePage(meshcat, "a <title>", [[["R"], "record </script>", ""]], {"KeyA": ["x", 1]})
    yield page
    page.close()


def fetch(address):
    with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(address, timeout=PATIENCE) as reply:
        return reply.read().decode(errors="replace")


def test_hands_out_meshcats_page_with_the_panel(page, meshcat):
    text = fetch(page.address)
    assert json.dumps(meshcat.ws_url()) in text
    assert "a &lt;title&gt;" in text
    assert text.count("record </script>") == 0
    assert "ichain-live" in text


def test_relays_the_rest_from_meshcat(page):
    (script,) = re.findall(r'<script type="text/javascript" src="([^"]+)">', fetch(page.address))
    assert "MeshCat" in fetch(page.address + script)
    with pytest.raises(urllib.error.HTTPError) as refused:
        fetch(f"{page.address}nothing")
    assert refused.value.code == 404
    refused.value.close()


def test_says_what_was_shown_last(page):
    page.show("recording", "on", {"piece": "a"}, "late")
    assert json.loads(fetch(f"{page.address}ichain/status")) == {
        "state": "recording", "text": "on", "values": {"piece": "a"}, "alarm": "late",
    }  # fmt: skip
    assert not page.watched  # asked, but no browser is connected to the scene


def test_no_thread_of_the_server_is_the_last_to_hold_the_scene(monkeypatch):
    """Meshcat ends the process if another thread than the main one deletes it."""
    meshcat = Meshcat(MeshcatParams(host="127.0.0.1"))
    page, held = LivePage(meshcat, "a title"), weakref.ref(meshcat)
    address, asked, go_on = f"{page.address}slow.js", threading.Event(), threading.Event()

    def slow(address):
        asked.set()
        assert go_on.wait(PATIENCE)
        return b"late", "text/plain"

    monkeypatch.setattr(live_page, "_fetch", slow)
    replies = []
    browser = threading.Thread(target=lambda: replies.append(fetch(address)))
    browser.start()
    assert asked.wait(PATIENCE)
    page.close()
    gc.disable()  # which may run in any thread
    try:
        del page, meshcat
        assert held() is None
    finally:
        gc.enable()
        go_on.set()
        browser.join()
    assert replies == ["late"]


def test_another_form_of_meshcats_page_is_refused():
    with pytest.raises(IchainError, match="of another form than known"):
        _page("<html><body></body></html>", "ws://127.0.0.1:1", {"title": ""})


def test_controls_read_sliders_and_say_their_keys(meshcat):
    axis = Axis("steering", ("ArrowLeft", "ArrowRight"), ("left", "right"), 0)
    controls = Controls(meshcat, [axis], [PageButton("go", "KeyG", "drive on", 2)])
    assert controls.read() == pytest.approx([0.0])
    meshcat.SetSliderValue("steering", -0.5)
    assert controls.read() == pytest.approx([-0.5])
    assert controls.device == "keys"
    controls.let_go()
    assert controls.read() == pytest.approx([0.0])
    assert controls.pressed() == []
    assert controls.page_keys() == {"ArrowLeft": ["steering", -1], "ArrowRight": ["steering", 1]}
    assert controls.instructions() == [
        [["←", "→"], "steering: left, right", "left stick sideways"],
        [["G"], "drive on", "button 2"],
    ]
    assert key_name("Escape") == "Esc"

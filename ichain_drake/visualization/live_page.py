"""The page that a person looks at while something runs: Meshcat's own, with instructions, state and alarms on top.

Meshcat has no text, and its sliders know only single key strokes. A small server on this machine therefore hands out
Meshcat's page with our panel added to it. The scene itself goes from Drake to the browser as always; the panel asks
this server for its contents, and its asking is the sign that somebody looks.
"""

from __future__ import annotations

import html
import json
import time
import urllib.error
import urllib.request
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from pydrake.geometry import Meshcat

from ichain_drake.errors import IchainError
from ichain_drake.visualization.page_server import Content, PageServer

_CONNECT = "url = location.toString();"
_PAD = 2  # place of the gamepad's part in a line of instructions
_SILENCE = 2.5  # [s] a page asks four times a second


class LivePage:
    """Serves the page on 127.0.0.1 until closed.

    Args:
        meshcat: whose scene it shows.
        title: of the page.
        instructions: lines of [keys, text, gamepad]; see `Controls.instructions`.
        keys: held keys, code -> [slider, direction]; see `Controls.page_keys`.

    Raises:
        IchainError: if this Drake's page has another form than known.
    """

    def __init__(
        self,
        meshcat: Meshcat,
        title: str,
        instructions: Sequence[Sequence[Any]] = (),
        keys: Mapping[str, Sequence[Any]] | None = None,
    ) -> None:
        self._meshcat: Meshcat | None = meshcat
        origin = meshcat.web_url().rstrip("/")
        config = {
            "title": title,
            "instructions": list(instructions),
            "keys": dict(keys or {}),
            "pads": any(len(line) > _PAD and line[_PAD] for line in instructions),
            "socket": meshcat.ws_url(),
        }
        self._answers = _Answers(_page(_fetch(f"{origin}/")[0].decode(), meshcat.ws_url(), config), origin)
        shown, told = self._answers.shown, self._answers.told
        self._server = PageServer({"/": shown, "/index.html": shown, "/ichain/status": told}, self._answers.relayed)

    @property
    def address(self) -> str:
        """URL to open in a browser."""
        return self._server.address

    @property
    def watched(self) -> bool:
        """Whether a browser shows the page now: one that is closed, hidden or cut off does not."""
        asked = time.monotonic() - self._answers.asked < _SILENCE
        return asked and self._meshcat is not None and self._meshcat.GetNumActiveConnections() > 0

    def show(self, state: str, text: str, values: Mapping[str, str] | None = None, alarm: str = "") -> None:
        """What the panel says from now on.

        Args:
            state: `idle`, `recording`, `running`, `waiting` or `ended`; decides its color.
            text: the state in words.
            values: further lines, by label.
            alarm: what needs attention; empty for nothing.
        """
        content = {"state": state, "text": text, "values": dict(values or {}), "alarm": alarm}
        self._answers.status = json.dumps(content).encode()

    def close(self) -> None:
        """Stop serving, and hold the scene no longer: whoever holds the page may be deleted in any thread."""
        self._server.close()
        self._meshcat = None


class _Answers:
    """What the server hands out. Its threads hold this and no scene: only the main thread may end a Meshcat."""

    def __init__(self, page: bytes, origin: str) -> None:
        self._page, self._origin = page, origin
        self.status = b"{}"
        self.asked = 0.0  # when, by the monotonic clock

    def shown(self) -> Content:
        return self._page, "text/html; charset=utf-8"

    def told(self) -> Content:
        self.asked = time.monotonic()
        return self.status, "application/json"

    def relayed(self, path: str) -> Content | int:
        """The viewer's script and the scene's meshes come from Meshcat's own server."""
        try:
            return _fetch(self._origin + path)
        except urllib.error.HTTPError as error:
            return error.code
        except OSError:
            return 502


def _fetch(address: str) -> tuple[bytes, str]:
    # Never by way of a proxy: the address is on this machine.
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    with opener.open(address, timeout=10) as reply:
        return reply.read(), reply.headers.get("Content-Type", "application/octet-stream")


def _page(page: str, socket: str, config: dict[str, Any]) -> bytes:
    """Meshcat's page with the panel, connected to Meshcat's socket."""
    if page.count(_CONNECT) != 1 or page.count("</body>") != 1:
        raise IchainError("Drake's Meshcat serves a page of another form than known; use the tested Drake version")
    assets = files("ichain_drake.visualization.page")
    data = json.dumps(config).replace("<", "\\u003c")
    tail = "".join(
        [
            f"<style>{assets.joinpath('live.css').read_text(encoding='utf-8')}</style>\n",
            f"<script>const ichainConfig = {data};\n",
            *(assets.joinpath(name).read_text(encoding="utf-8") for name in ("element.js", "gamepad.js", "live.js")),
            "</script>\n",
        ]
    )
    page = page.replace(_CONNECT, f"url = {json.dumps(socket)};")
    page = page.replace("<title>Drake MeshCat</title>", f"<title>{html.escape(config['title'])}</title>")
    return page.replace("</body>", tail + "</body>").encode()

"""The page that a person looks at while something runs: Meshcat's own, with instructions, state and alarms on top.

Meshcat has no text, and its sliders know only single key strokes. A small server on this machine therefore hands out
Meshcat's page with our panel added to it. The scene itself goes from Drake to the browser as always; the panel asks
this server for its contents, and its asking is the sign that somebody looks.
"""

from __future__ import annotations

import html
import json
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Mapping, Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any

from pydrake.geometry import Meshcat

from ichain_drake.errors import IchainError

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
        self._meshcat = meshcat
        self._origin = meshcat.web_url().rstrip("/")
        config = {
            "title": title,
            "instructions": list(instructions),
            "keys": dict(keys or {}),
            "pads": any(len(line) > _PAD and line[_PAD] for line in instructions),
            "socket": meshcat.ws_url(),
        }
        self._page = _page(_fetch(f"{self._origin}/")[0].decode(), meshcat.ws_url(), config)
        self._status = b"{}"
        self._asked = 0.0
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), self._handler())
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """URL to open in a browser."""
        return f"http://127.0.0.1:{self._server.server_address[1]}/"

    @property
    def watched(self) -> bool:
        """Whether a browser shows the page now: one that is closed, hidden or cut off does not."""
        return time.monotonic() - self._asked < _SILENCE and self._meshcat.GetNumActiveConnections() > 0

    def show(self, state: str, text: str, values: Mapping[str, str] | None = None, alarm: str = "") -> None:
        """What the panel says from now on.

        Args:
            state: `idle`, `recording`, `running`, `waiting` or `ended`; decides its color.
            text: the state in words.
            values: further lines, by label.
            alarm: what needs attention; empty for nothing.
        """
        content = {"state": state, "text": text, "values": dict(values or {}), "alarm": alarm}
        self._status = json.dumps(content).encode()

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def _handler(self) -> type[BaseHTTPRequestHandler]:
        page = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self) -> None:  # noqa: N802 - the base class's name
                path = self.path.partition("?")[0]
                if path == "/ichain/status":
                    page._asked = time.monotonic()
                    self._reply(page._status, "application/json")
                elif path in ("/", "/index.html"):
                    self._reply(page._page, "text/html; charset=utf-8")
                else:
                    self._relay(path)

            def _relay(self, path: str) -> None:
                """The viewer's script and the scene's meshes come from Meshcat's own server."""
                try:
                    content, kind = _fetch(page._origin + path)
                except urllib.error.HTTPError as error:
                    self.send_error(error.code)
                except OSError:
                    self.send_error(502)
                else:
                    self._reply(content, kind)

            def _reply(self, content: bytes, kind: str) -> None:
                try:
                    self.send_response(200)
                    self.send_header("Content-Type", kind)
                    self.send_header("Content-Length", str(len(content)))
                    self.send_header("Cache-Control", "no-store")
                    self.end_headers()
                    self.wfile.write(content)
                except OSError:  # whoever asked has left
                    self.close_connection = True

            def log_message(self, format: str, *args: Any) -> None:
                """Requests are nobody's concern."""

        return Handler


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

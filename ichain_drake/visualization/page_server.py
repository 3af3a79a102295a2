"""A small server on this machine: hands out pages to a browser, and takes from them what a person did."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from ichain_drake.files import MOST_JSON

Content = tuple[bytes, str]
"""What a request is answered with, and its MIME type."""


class PageServer:
    """Serves on 127.0.0.1 until closed, in a thread of its own.

    Args:
        pages: by path, what makes the answer to each request.
        other: answers requests for any other path; None where there is nothing.
        takes: by path, what takes the JSON of a page and gives back JSON. Only pages of this server may send any:
            others can neither name its address as theirs nor send this type unasked.
    """

    def __init__(
        self,
        pages: Mapping[str, Callable[[], Content]],
        other: Callable[[str], Content | int] = lambda path: 404,
        takes: Mapping[str, Callable[[Any], Any]] | None = None,
    ) -> None:
        self._pages, self._other, self._takes = dict(pages), other, dict(takes or {})
        self._server = ThreadingHTTPServer(("127.0.0.1", 0), self._handler())
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """URL to open in a browser."""
        return f"http://127.0.0.1:{self._server.server_address[1]}/"

    def close(self) -> None:
        """Stop serving."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
        # Whoever made the answers, with a scene perhaps that only the main thread may end, is held no longer.
        self._pages, self._takes, self._other = {}, {}, lambda path: 404

    def _handler(self) -> type[BaseHTTPRequestHandler]:
        server = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self) -> None:  # noqa: N802 - the base class's name
                path = self.path.partition("?")[0]
                make = server._pages.get(path)
                answer = make() if make is not None else server._other(path)
                if isinstance(answer, int):
                    self.send_error(answer)
                else:
                    self._reply(*answer)

            def do_POST(self) -> None:  # noqa: N802 - the base class's name
                take = server._takes.get(self.path)
                size = self.headers.get("Content-Length", "")
                own = self.headers.get("Host") == server.address.split("/")[2]
                if take is None:
                    return self._refuse(404)
                if not own or self.headers.get("Content-Type") != "application/json":
                    return self._refuse(403)
                if not size.isdecimal() or int(size) > MOST_JSON:
                    return self._refuse(413)
                try:
                    sent = json.loads(self.rfile.read(int(size)))
                except (ValueError, RecursionError):
                    return self._refuse(400)
                return self._reply(json.dumps(take(sent)).encode(), "application/json")

            def _refuse(self, status: int) -> None:
                self.close_connection = True  # what it sent was not read
                self.send_error(status)

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

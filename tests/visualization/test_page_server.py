"""The server of pages: what it takes, and from whom."""

import gc
import http.client
import json
import weakref
from typing import Any

import pytest
from patience import PATIENCE

from ichain_drake.visualization.page_server import PageServer

JSON = {"Content-Type": "application/json"}


@pytest.fixture
def server():
    taken: list[Any] = []
    opened = PageServer({"/": lambda: (b"page", "text/html")}, takes={"/save": lambda x: taken.append(x) or len(taken)})
    opened.taken = taken  # type: ignore[attr-defined]
    yield opened
    opened.close()


def ask(server: PageServer, method: str, path: str, body: str | None = None, **headers: str) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection(server.address.split("/")[2], timeout=PATIENCE)
    connection.request(method, path, body, headers={k.replace("_", "-"): v for k, v in headers.items()})
    reply = connection.getresponse()
    answer = reply.status, reply.read()
    connection.close()
    return answer


def test_pages_are_handed_out_and_what_they_send_is_taken(server: PageServer) -> None:
    assert ask(server, "GET", "/") == (200, b"page")
    assert ask(server, "GET", "/?again") == (200, b"page")
    assert ask(server, "GET", "/nothing")[0] == 404
    assert ask(server, "POST", "/save", json.dumps([1]), Content_Type="application/json") == (200, b"1")
    assert server.taken == [[1]]  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("path", "body", "headers", "status"),
    [
        ("/other", "[]", {"Content_Type": "application/json"}, 404),
        ("/save", "[]", {"Content_Type": "text/plain"}, 403),  # which any page may send anywhere
        ("/save", "[]", {"Content_Type": "application/json", "Host": "evil.example"}, 403),
        ("/save", "[", {"Content_Type": "application/json"}, 400),
        ("/save", "[]", {"Content_Type": "application/json", "Content_Length": "99999999999"}, 413),
    ],
)
def test_pages_of_others_and_what_is_none_are_refused(
    path: str, body: str, headers: dict[str, str], status: int, server: PageServer
) -> None:
    assert ask(server, "POST", path, body, **headers)[0] == status
    assert server.taken == []  # type: ignore[attr-defined]


def test_who_made_its_pages_is_not_held_once_it_is_closed() -> None:
    class Maker:
        def __init__(self) -> None:
            self.server = PageServer({"/": self.make}, lambda path: self.make(), {"/save": self.take})

        def make(self) -> tuple[bytes, str]:
            return b"", ""

        def take(self, sent: Any) -> Any:
            return sent

    maker = Maker()
    held = weakref.ref(maker)
    maker.server.close()
    gc.disable()  # which may run in any thread
    try:
        del maker
        assert held() is None
    finally:
        gc.enable()

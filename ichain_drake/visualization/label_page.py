"""The page on which a person marks recordings: timelines of columns, statuses and cuts, and what goes back from it."""

from __future__ import annotations

import html
import json
from collections.abc import Callable, Mapping
from importlib.resources import files
from typing import Any

from ichain_drake.visualization.page_server import PageServer

_ASSETS = ("element.js", "label.js")


class LabelPage:
    """Serves the page on 127.0.0.1 until closed.

    Args:
        content: what it shows:
            `title`; `notice`, what needs attention at first; `interactions`, their names;
            `logs`, each with `name`, `times` [s], `columns` (`label`, `low`, `high`, `values`), per interaction
            stretches of rows `[first, last]` that are `on` or `open`, and `cuts` (`row`, `why`, `sure`, `fixed`);
            `marks`, lines of an earlier session.
        save: is given the marks whenever the person saves; gives back what to say, or raises InputError.
        end: is called when the person ends.
    """

    def __init__(
        self, content: Mapping[str, Any], save: Callable[[list[dict[str, Any]]], str], end: Callable[[], None]
    ) -> None:
        page = label_page(content)
        self._save, self._end = save, end
        self._server = PageServer(
            {"/": lambda: (page, "text/html; charset=utf-8")},
            takes={"/ichain/save": self._saved, "/ichain/end": self._ended},
        )

    @property
    def address(self) -> str:
        """URL to open in a browser."""
        return self._server.address

    def close(self) -> None:
        """Stop serving."""
        self._server.close()

    def _saved(self, rows: Any) -> dict[str, str]:
        if not isinstance(rows, list) or not all(isinstance(r, dict) for r in rows):
            return {"error": "the page sent no marks"}
        try:
            return {"text": self._save(rows)}
        except ValueError as error:  # InputError is one
            return {"error": str(error)}

    def _ended(self, _: Any) -> dict[str, str]:
        self._end()
        return {}


def label_page(content: Mapping[str, Any]) -> bytes:
    """The page as UTF-8; it fetches nothing."""
    assets = files("ichain_drake.visualization.page")
    style, *scripts = (assets.joinpath(n).read_text(encoding="utf-8") for n in ("label.css", *_ASSETS))
    data = json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return (
        '<!doctype html><html lang="en"><meta charset="utf-8"><link rel="icon" href="data:,">'
        f"<title>{html.escape(str(content['title']))}</title><style>{style}</style><body><script>\n"
        f"const ichainData = {data};\n{''.join(scripts)}</script></body></html>\n"
    ).encode()

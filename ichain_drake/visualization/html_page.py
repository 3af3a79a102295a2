"""One self-contained HTML page from Meshcat's scene: the recording compressed inside, inflated by the browser."""

from __future__ import annotations

import base64
import gzip
import html
import json
import re
import struct
from importlib.resources import files
from typing import Any

from pydrake.geometry import Meshcat

from ichain_drake.errors import IchainError

# How Drake's static page feeds each command of the scene to the viewer.
_COMMAND = re.compile(
    r'fetch\("data:application/octet-binary;base64,([^"]*)"\)\s*'
    r"\.then\(res => res\.arrayBuffer\(\)\)\s*"
    r"\.then\(buffer => viewer\.handle_command_bytearray\(new Uint8Array\(buffer\)\)\);\s*"
)


def playback_page(meshcat: Meshcat, animation: bytes, log: dict[str, Any], title: str) -> bytes:
    """The page as UTF-8.

    Args:
        meshcat: holds the scene as it is before playing.
        animation: `set_animation` command (msgpack).
        log: what the page shows beside the scene, see `page_log`.
        title: of the page.

    Raises:
        IchainError: if this Drake writes static pages of a form that is not known here.
    """
    page = meshcat.StaticHtml()
    commands = [base64.b64decode(m.group(1)) for m in _COMMAND.finditer(page)]
    if not commands or page.count("</body>") != 1:
        raise IchainError(
            "Drake's Meshcat writes static pages of another form than known; use the tested Drake version"
        )
    page = _COMMAND.sub("", page)
    # Drake's own page sends the commands in this order too; the animation comes last, as it binds to what they made.
    records = [json.dumps(log, separators=(",", ":")).encode(), *commands, animation]
    packed = gzip.compress(b"".join(struct.pack("<I", len(r)) + r for r in records), compresslevel=9, mtime=0)
    assets = files("ichain_drake.visualization.page")
    tail = "".join(
        [
            f"<style>{assets.joinpath('playback.css').read_text(encoding='utf-8')}</style>\n",
            '<script type="application/octet-stream" id="ichain-recording">\n',
            base64.b64encode(packed).decode(),
            "\n</script>\n",
            *(
                f"<script>{assets.joinpath(name).read_text(encoding='utf-8')}</script>\n"
                for name in ("element.js", "panel.js", "playback.js")
            ),
        ]
    )
    page = page.replace("<title>Drake MeshCat</title>", f"<title>{html.escape(title)}</title>")
    return page.replace("</body>", tail + "</body>").encode()

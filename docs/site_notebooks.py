"""Notebooks as pages of the site: text, code and whatever outputs they hold. Used by `mkdocs.yml`.

In the repository they hold none; `.ci/run` executes them in its own checkout before it builds the site.
"""

import base64
import html
import json
import re
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

NOTEBOOKS = Path(__file__).parent.parent / "notebooks"
FENCE = "~" * 8
FRAME = re.compile(r'srcdoc="([^"]*)"')


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add a page for each notebook, and the pictures and playbacks that it shows."""
    for notebook in sorted(NOTEBOOKS.glob("*.ipynb")):
        text, shown = page_of(json.loads(notebook.read_text(encoding="utf-8")), notebook.stem)
        files.append(File.generated(config, f"tutorials/{notebook.stem}.md", content=text))
        for name, content in shown.items():
            files.append(File.generated(config, f"tutorials/{name}", content=content))
    return files


def page_of(notebook: dict[str, Any], name: str) -> tuple[str, dict[str, bytes]]:
    """A notebook as Markdown, with the files that it shows.

    Args:
        notebook: its JSON (format 4).
        name: what the files' names begin with.
    """
    parts: list[str] = []
    shown: dict[str, bytes] = {}
    for number, cell in enumerate(notebook["cells"]):
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append(f"{FENCE} python\n{source}\n{FENCE}")
        for i, output in enumerate(cell["outputs"]):
            parts.append(_output(output, f"{name}_{number}_{i}", shown))
    return "\n\n".join(part for part in parts if part), shown


def _output(output: dict[str, Any], name: str, shown: dict[str, bytes]) -> str:
    """One output as Markdown; what is a file of its own goes into `shown`."""
    if output["output_type"] == "stream":
        return f"{FENCE} text\n{''.join(output['text']).rstrip()}\n{FENCE}" if output["name"] == "stdout" else ""
    data = {kind: "".join(value) for kind, value in output.get("data", {}).items()}
    if "image/png" in data:
        shown[f"{name}.png"] = base64.b64decode(data["image/png"])
        return f"![output]({name}.png)"
    frame = FRAME.search(data.get("text/html", ""))
    if frame:  # megabytes: a file of its own that only the frame loads
        shown[f"{name}.html"] = html.unescape(frame[1]).encode()
        return data["text/html"].replace(frame[0], f'src="{name}.html" loading="lazy"')
    if "text/html" in data:
        return re.sub(r"<style.*?</style>|\n\s*", "", data["text/html"], flags=re.DOTALL)
    return f"{FENCE} text\n{data['text/plain']}\n{FENCE}" if "text/plain" in data else ""

"""What a library holds, for other people's programs: learned parts as ONNX, or as C (extra `onnx`)."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from ichain_drake.errors import InputError
from ichain_drake.files import reason_of, write_whole
from ichain_drake.learning.library.files import is_graph_name, link_folder, link_name, safe_name
from ichain_drake.learning.library.saved import SavedLink
from ichain_drake.learning.library.saved_graph import SavedGraph
from ichain_drake.learning.portable.c_source import c_source
from ichain_drake.learning.portable.interaction import effect_bytes, passive_bytes, status_bytes
from ichain_drake.learning.portable.link import forward_bytes, inverse_bytes

Form = Literal["onnx", "c"]
"""Of a model in a file."""


def export_item(library: Path, name: str, folder: Path, form: Form = "onnx") -> list[Path]:
    """Write the models of a saved link or graph as ONNX files, in double precision, or as C sources of the same.

    A link gives `forward.onnx` and an `inverse-<k>.onnx` for each inverse; a graph gives for each interaction
    `<parent>-<child>.status.onnx` and `.effect.onnx`, and for each object but the robot `<object>.passive.onnx`.
    Tables in and out are states, a row a sample; each file's metadata tells their variables and units. In C each file
    is one function of its name, such as `forward.c`, for one row; its first comment tells the same.

    Args:
        library: the library's folder.
        name: of the link or graph in it.
        folder: where to; it is made if it isn't there, files of the same names are not replaced.
        form: what is written.

    Returns:
        The files.

    Raises:
        InputError: on an unknown name, a damaged link or graph, a model that ONNX has no form of here, a file that is
            there already, or if the extra is not installed.
    """
    read = link_folder(library, name)
    contents = _graph(SavedGraph.read(read)) if is_graph_name(name) else _link(SavedLink.read(read))
    if form == "c":
        stems = {file: file.removesuffix(".onnx") for file in contents}
        contents = {f"{stems[file]}.c": c_source(text, stems[file]).encode() for file, text in contents.items()}
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{folder}: can't make the folder: {reason_of(error)}") from None
    taken = next((folder / n for n in contents if (folder / n).exists()), None)
    if taken is not None:
        raise InputError(f"{taken}: is there already and is not overwritten; give another folder")
    for file, content in contents.items():
        write_whole(folder / file, content, new=True)
    return [folder / file for file in contents]


def _link(saved: SavedLink) -> dict[str, bytes]:
    link, _ = saved.described()
    inverses = {f"inverse-{k}.onnx": inverse_bytes(i.model) for k, i in enumerate(link.inverses)}
    return {"forward.onnx": forward_bytes(link.forward.model), **inverses}


def _graph(saved: SavedGraph) -> dict[str, bytes]:
    model = saved.known(saved.graph())
    files: dict[str, bytes] = {}
    for edge in model.graph.interactions:
        stem = link_name(edge.parent, edge.child)
        files[f"{stem}.status.onnx"] = status_bytes(model, edge)
        files[f"{stem}.effect.onnx"] = effect_bytes(model, edge)
    for name, passive in model.passive.items():
        files[f"{safe_name(name)}.passive.onnx"] = passive_bytes(passive)
    return files


__all__ = [
    "Form",
    "c_source",
    "effect_bytes",
    "export_item",
    "forward_bytes",
    "inverse_bytes",
    "passive_bytes",
    "status_bytes",
]

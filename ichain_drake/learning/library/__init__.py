"""The interaction library: learned links and graphs on disk as a manifest and plain arrays, reused across scenarios."""

from ichain_drake.learning.chain.command import LearnedCommand
from ichain_drake.learning.library.browse import LinkSummary, check_library, list_library, show_link
from ichain_drake.learning.library.browse_graphs import GraphSummary, list_graphs, show_graph
from ichain_drake.learning.library.files import graph_name, is_graph_name, link_name
from ichain_drake.learning.library.graphs import load_fitting, load_graph, save_graph
from ichain_drake.learning.library.load import load_command, load_link, load_links
from ichain_drake.learning.library.parts import load_parts
from ichain_drake.learning.library.save import save_chain, save_link
from ichain_drake.learning.library.transfer import add_to_library

__all__ = [
    "GraphSummary",
    "LearnedCommand",
    "LinkSummary",
    "add_to_library",
    "check_library",
    "graph_name",
    "is_graph_name",
    "link_name",
    "list_graphs",
    "list_library",
    "load_command",
    "load_fitting",
    "load_graph",
    "load_link",
    "load_links",
    "load_parts",
    "save_chain",
    "save_graph",
    "save_link",
    "show_graph",
    "show_link",
]

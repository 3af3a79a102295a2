"""The interaction library: learned links on disk as a manifest and plain arrays, reused across scenarios."""

from ichain_drake.learning.command import LearnedCommand
from ichain_drake.learning.library.browse import LinkSummary, check_library, list_library, show_link
from ichain_drake.learning.library.files import link_name
from ichain_drake.learning.library.load import load_command, load_link, load_links
from ichain_drake.learning.library.save import save_chain, save_link
from ichain_drake.learning.library.transfer import add_to_library

__all__ = [
    "LearnedCommand",
    "LinkSummary",
    "add_to_library",
    "check_library",
    "link_name",
    "list_library",
    "load_command",
    "load_link",
    "load_links",
    "save_chain",
    "save_link",
    "show_link",
]

"""What saved links and graphs share: a folder as it was read, complete and unharmed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

from ichain_drake.errors import InputError
from ichain_drake.learning.library.files import MANIFEST, read_files
from ichain_drake.learning.library.form import refusal
from ichain_drake.learning.library.manifest import ManifestForm, read_manifest


@dataclass(frozen=True)
class SavedItem(ABC):
    """A folder of a library as it was read, but not yet compared with a graph.

    Attributes:
        folder: where it is.
        manifest: checked fields, see `ichain_drake.learning.library.manifest`.
        files: contents by file name.
    """

    what: ClassVar[str]
    """What it is called in errors."""

    form: ClassVar[ManifestForm]
    """Of its manifest."""

    folder: Path
    manifest: Mapping[str, Any]
    files: Mapping[str, bytes]

    @classmethod
    def read(cls, folder: Path) -> Self:
        """Read a folder.

        Raises:
            InputError: if anything in it is missing, damaged, edited, foreign or of a newer format.
        """
        files = read_files(folder)
        manifest = read_manifest(files, folder, cls.form)
        name = cls.folder_name(manifest)
        if folder.resolve().name != name:
            raise InputError(f"{folder}: the {cls.what} in it is {name}; give the folder that name")
        return cls(folder, manifest, files)

    @staticmethod
    @abstractmethod
    def folder_name(manifest: Mapping[str, Any]) -> str:
        """The name that a folder with this manifest has.

        Args:
            manifest: checked fields.
        """

    @abstractmethod
    def verify(self) -> None:
        """Build its models, for a graph as the manifest describes it.

        Raises:
            InputError: if that fails; names the file or field.
        """

    @property
    def size(self) -> int:
        """Of all its files [bytes]."""
        return sum(len(data) for data in self.files.values())

    def _refusal(self, path: str, what: str) -> InputError:
        return refusal(str(self.folder / MANIFEST), path, what)

"""Where the model files are, and a parser that finds them without a network."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import PackageMap, Parser
from pydrake.multibody.plant import MultibodyPlant

from ichain_drake.errors import InputError

if TYPE_CHECKING:
    from pydrake.visualization import ModelVisualizer

PACKAGE_NAME = "ichain_drake_models"


def models_path() -> Path:
    """The folder of the model files: inside the package in an installed wheel, else the checkout's `models/`.

    Raises:
        InputError: if neither holds a `package.xml`.
    """
    package = Path(__file__).resolve().parent.parent
    for folder in (package / "models", package.parent / "models"):
        if (folder / "package.xml").is_file():
            return folder
    raise InputError(f"no model files in {package / 'models'} or {package.parent / 'models'}; reinstall ichain_drake")


def package_map() -> PackageMap:
    """A package map in which `package://ichain_drake_models/...` is our folder, and nothing needs a download."""
    packages = PackageMap.MakeEmpty()
    packages.Add(PACKAGE_NAME, str(models_path()))
    return packages


def model_visualizer(**keywords: Any) -> ModelVisualizer:
    """Drake's `ModelVisualizer`, which finds our models: `model_visualizer().AddModels(url=...)`, then `.Run()`.

    Args:
        keywords: of `ModelVisualizer`, such as `visualize_frames=True`.
    """
    from pydrake.visualization import ModelVisualizer  # noqa: PLC0415 - brings Matplotlib with it

    visualizer = ModelVisualizer(**keywords)
    visualizer.package_map().AddMap(package_map())
    return visualizer


def model_parser(plant: MultibodyPlant, scene_graph: SceneGraph | None = None) -> Parser:
    """A parser for the plant that resolves `package://ichain_drake_models/...`."""
    parser = Parser(plant) if scene_graph is None else Parser(plant, scene_graph)
    parser.package_map().AddMap(package_map())
    return parser


def resolve_model(file: str, where: str) -> str:
    """The path of a model file given as a `package://ichain_drake_models/` address or as a path.

    Args:
        file: the address or path.
        where: what to name in the error, such as `body stick`.

    Raises:
        InputError: if there is no such file.
    """
    prefix = f"package://{PACKAGE_NAME}/"
    path = models_path() / file.removeprefix(prefix) if file.startswith(prefix) else Path(file)
    if not path.is_file():
        raise InputError(f"{where}: there is no model file {file!r} (looked at {path})")
    return str(path)

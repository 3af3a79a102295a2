"""Scenarios that are no part of this package: a class in a file, or in a module, that the user names.

Importing a file or a module runs it, like any Python script. So this is for what a person names herself, on the command
line or in her code; nothing that is read from data (a library, a report) ever comes here.
"""

from __future__ import annotations

import inspect
import re
import sys
import traceback
from importlib import import_module
from pathlib import Path
from types import ModuleType

from ichain_drake.errors import InputError
from ichain_drake.scenarios.base import Scenario


def is_own(name: str) -> bool:
    """Whether a scenario's name is a file or a module rather than one of this package's: `x.py`, `x.py:C`, `x:C`."""
    return ":" in name or name.endswith(".py")


def own_scenario(name: str) -> type[Scenario]:
    """The scenario class that a file or a module defines.

    Args:
        name: `path/to/file.py`, or `path/to/file.py:Class` where it defines several, or `package.module:Class`. The
            folder of a file, or for a module the working directory, is searched for what it imports.

    Raises:
        InputError: if it can't be imported, or it isn't clear which class is meant, or that class is no complete
            scenario.
    """
    where, _, wanted = name.rpartition(":") if re.search(r":\w*$", name) else (name, "", "")
    module = _file(Path(where)) if where.endswith(".py") else _module(where)
    kind = _named(module, wanted, where) if wanted else _only(module, where)
    if inspect.isabstract(kind):
        missing = ", ".join(sorted(kind.__abstractmethods__))
        raise InputError(f"{where}: {kind.__name__} lacks {missing}")
    if not re.fullmatch(r"\w+", str(getattr(kind, "name", ""))):
        raise InputError(f"{where}: {kind.__name__} needs a name, such as name = 'my_scenario': letters, digits and _")
    return kind


def _file(file: Path) -> ModuleType:
    if not file.is_file():
        raise InputError(f"{file}: there is no such file")
    if not file.stem.isidentifier():
        raise InputError(f"{file}: a file that is imported has letters, digits and _ in its name; rename it")
    module = _imported(file.stem, str(file), file.resolve().parent)
    if Path(module.__file__ or "").resolve() != file.resolve():
        raise InputError(f"{file}: another module is called {file.stem}; rename the file")
    return module


def _module(name: str) -> ModuleType:
    if not all(part.isidentifier() for part in name.split(".")):
        raise InputError(f"{name!r} is no module; name your scenario as file.py, file.py:Class or package.module:Class")
    return _imported(name, name, Path.cwd())


def _imported(module: str, where: str, folder: Path) -> ModuleType:
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    try:
        return import_module(module)
    except (Exception, SystemExit) as error:
        raise InputError(f"{where}: can't be imported: {_explain(error)}") from error


def _explain(error: BaseException) -> str:
    """What went wrong, and the line."""
    if isinstance(error, SyntaxError):
        return f"{error.filename}, line {error.lineno}: {error.msg}"
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "importlib" not in f.filename]
    place = f"{frames[-1].filename}, line {frames[-1].lineno}: " if len(frames) > 1 else ""
    return f"{place}{type(error).__name__}: {' '.join(str(error).split())}"


def _named(module: ModuleType, wanted: str, where: str) -> type[Scenario]:
    kind = getattr(module, wanted, None)
    if not (isinstance(kind, type) and issubclass(kind, Scenario)):
        raise InputError(
            f"{where}: it has no class {wanted} made from GraphScenario or PathScenario; "
            f"name one that it has, as in {where}:ClassName"
        )
    return kind


def _only(module: ModuleType, where: str) -> type[Scenario]:
    """Its one scenario; what it imports from elsewhere does not count, nor what it only builds others on."""
    own = [
        v for v in vars(module).values()
        if isinstance(v, type) and issubclass(v, Scenario) and v.__module__ == module.__name__
    ]  # fmt: skip
    complete = [v for v in own if not inspect.isabstract(v)]
    if len(complete) > 1:
        raise InputError(f"{where}: it has several scenarios; say which, as in {where}:{complete[0].__name__}")
    if not own:
        raise InputError(f"{where}: it has no class made from GraphScenario or PathScenario; name a file that has one")
    return (complete or own)[0]

"""Scripts that stand in for a person know no border of an interaction: where it is, is what is to be learned."""

import ast
import dataclasses
import importlib
import pkgutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import ichain_drake
from ichain_drake.objects.region import GATE

ROOT = Path(ichain_drake.__file__).parent
SCRIPTS = sorted(f for name in ("demonstrations.py", "teleoperation.py") for f in (ROOT / "systems").rglob(name))


def dataclasses_of(package: str) -> Iterator[type]:
    module = importlib.import_module(f"ichain_drake.{package}")
    for found in pkgutil.walk_packages(module.__path__, f"{module.__name__}."):
        if "gymnasium" in found.name or found.name.endswith("car_racing.game"):
            continue  # an extra
        yield from (v for v in vars(importlib.import_module(found.name)).values() if dataclasses.is_dataclass(v))


def gates() -> set[str]:
    """Names of what decides where an interaction begins: fields marked so, and whatever gives a region."""
    names = {"half", "margin"}
    for kind in [*dataclasses_of("objects"), *dataclasses_of("systems")]:
        names |= {f.name for f in dataclasses.fields(kind) if f.metadata.get(GATE)}
        for name, member in vars(kind).items():
            if callable(member) and not name.startswith("_"):
                hints = getattr(member, "__annotations__", {})
                if "Region" in str(hints.get("return", "")):
                    names.add(name)
    return names


def read(file: Path) -> set[str]:
    """Attributes that a script reads, but for those of itself, and the commands to its hand, which give the hand."""
    own = {"self", "hand"}
    return {
        n.attr
        for n in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(n, ast.Attribute)
        and not isinstance(n.value, ast.Call)
        and not (isinstance(n.value, ast.Name) and n.value.id in own)
    }


def test_the_gates_are_found() -> None:
    assert {"reach", "room", "half", "margin", "pour_region", "catch_region", "plate_region", "grasp"} <= gates()


@pytest.mark.parametrize("file", SCRIPTS, ids=lambda f: str(f.relative_to(ROOT)))
def test_no_script_reads_a_gate(file: Path) -> None:
    assert not read(file) & gates()

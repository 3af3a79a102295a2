"""Mutation run: break the code in one place at a time, and see whether the tests beside it notice.

    python tests/mutation.py --sample 100 --seed 1

Needs the extra `mutation` (cosmic-ray, whose operators and machinery these are) and a suite that passes. Works on a
copy, so that the tree is left alone whenever it is stopped. Places are drawn at random, then one of the changes that
are possible there: another arithmetic or comparison operator, a number, a condition, a skipped loop. Changes of
annotations and decorators are left out, as are those that no test could miss (arithmetic as bitwise operators).

A mutated module is tested by the file that mirrors it, `tests/a/test_b.py` for `ichain_drake/a/b.py`, by near ones that
import it and by others of its folder; then by small runs from end to end. A mutant is killed if a test fails, or does
not come to an end within the time limit.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast_from_path
from cosmic_ray.mutating import mutate_and_test
from cosmic_ray.plugins import get_operator, operator_names
from cosmic_ray.work_item import MutationSpec, TestOutcome

ROOT = Path(__file__).parents[1]
COPIED = ("ichain_drake", "tests", "models", "examples", "pyproject.toml")
PACKAGES = ("learning", "control", "runs")
END_TO_END = ("tests/runs/goals/test_lamp.py", "tests/control/execution/test_executor.py")
MOST_FILES = 6  # of those beside a module: what all of them miss, end-to-end runs are the better judge of
_ARITHMETIC, _ORDER = "Add|Sub|Mul|Div", "Lt|LtE|Gt|GtE|Eq|NotEq"
OPERATORS = re.compile(
    rf"core/(ReplaceBinaryOperator_({_ARITHMETIC}|Pow|Mod|FloorDiv)_({_ARITHMETIC})"
    r"|ReplaceBinaryOperator_Bit(Or_BitAnd|And_BitOr)"
    rf"|ReplaceComparisonOperator_(({_ORDER})_({_ORDER})|Is_IsNot|IsNot_Is)"
    r"|ReplaceUnaryOperator_(Delete_USub|Delete_Invert|Delete_Not|USub_UAdd)"
    r"|AddNot|Replace(True|False|And|Or|Break|Continue)With\w+|NumberReplacer|ZeroIterationForLoop)"
)


def annotations(source: str) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Where annotations are: nothing reads most of them at run time."""
    found = []
    for node in ast.walk(ast.parse(source)):
        parts = [getattr(node, "annotation", None), getattr(node, "returns", None)]
        for part in (p for p in parts if isinstance(p, ast.expr)):
            found.append(((part.lineno, part.col_offset), (part.end_lineno or 0, part.end_col_offset or 0)))
    return found


def mutants(module: Path) -> dict[tuple[int, int], list[MutationSpec]]:
    """Possible changes of a module by place."""
    tree, skipped = get_ast_from_path(module), annotations(module.read_text())
    places: dict[tuple[int, int], list[MutationSpec]] = {}
    for name in filter(OPERATORS.fullmatch, operator_names()):
        operator = get_operator(name)()
        spans = [span for node in ast_nodes(tree) for span in operator.mutation_positions(node)]
        for k, (start, end) in enumerate(spans):
            if not any(first <= tuple(start) < last for first, last in skipped):
                spec = MutationSpec(module, name, k, tuple(start), tuple(end))
                places.setdefault(tuple(start), []).append(spec)
    return places


def tests_of(module: Path) -> list[str]:
    """Test files of a module, those that mirror it first; both relative to the tree."""
    dotted = ".".join(module.with_suffix("").parts).removesuffix(".__init__")
    mirror = Path("tests", *module.parts[1:-1], f"test_{module.stem}.py")
    files = sorted(Path("tests").rglob("test_*.py"))
    imports = re.compile(rf"\b{re.escape(dotted)}\b(?!\.)")
    near = [f for f in files if f != mirror and f.parts[1] in (*PACKAGES, "learned_graph")]
    direct = [f for f in near if imports.search(f.read_text())]
    folder = [f for f in files if f.parent == mirror.parent]
    found = dict.fromkeys(([mirror] if mirror.exists() else []) + direct + folder)
    return list(dict.fromkeys([*map(str, list(found)[:MOST_FILES]), *END_TO_END]))


def run(sample: int, seed: int, limit: float, packages: tuple[str, ...]) -> Iterator[dict[str, object]]:
    """Test so many mutants, drawn by place; the present folder is a copy of the tree."""
    modules = sorted(f for p in packages for f in Path("ichain_drake", *p.split("/")).rglob("*.py"))
    drawn = random.Random(seed)
    places = [found for module in modules for found in mutants(module).values()]
    for found in drawn.sample(places, min(sample, len(places))):
        spec = drawn.choice(found)
        began, files = time.monotonic(), tests_of(Path(spec.module_path))
        command = f"{sys.executable} -m pytest -x -q --no-header {' '.join(files)}"
        result = mutate_and_test([spec], command, limit)
        killed, said = result.test_outcome == TestOutcome.KILLED, result.output or ""
        if killed and said != "timeout" and not re.search(r"\d+ (failed|error)", said):
            raise SystemExit(f"no test ran: {command}\n{said}")
        yield {
            "place": f"{spec.module_path}:{spec.start_pos[0]}:{spec.start_pos[1]}",
            "operator": spec.operator_name.removeprefix("core/"),
            "outcome": "timeout" if killed and said == "timeout" else str(result.test_outcome.value),
            "change": [x for x in (result.diff or "").splitlines() if re.match(r"[+-](?![+-])", x)],
            "tests": files,
            "seconds": round(time.monotonic() - began, 1),
        }


def main() -> None:
    """Run, print a line a mutant and the score."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=100, help="mutants")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    parser.add_argument("--limit", type=float, default=300.0, help="time for one mutant's tests [s]")
    parser.add_argument("--packages", nargs="+", default=list(PACKAGES), help="such as learning or runs/goals")
    parser.add_argument("--report", type=Path, help="JSON file of all rows")
    options = parser.parse_args()
    report, rows = options.report and options.report.absolute(), []
    with tempfile.TemporaryDirectory() as folder:
        for name in COPIED:
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
            copy(ROOT / name, Path(folder, name))
        os.chdir(folder)
        os.environ |= {"PYTHONPATH": folder, "OMP_NUM_THREADS": "1"}
        try:
            for row in run(options.sample, options.seed, options.limit, tuple(options.packages)):
                rows.append(row)
                print(
                    f"{row['outcome']:9} {row['seconds']:6} s  {row['place']}  {'  '.join(row['change'])}", flush=True
                )
                if report:
                    report.write_text(json.dumps(rows, indent=1))
        finally:
            os.chdir(ROOT)
    dead = sum(row["outcome"] != "survived" for row in rows)
    late = sum(row["outcome"] == "timeout" for row in rows)
    print(f"{dead} of {len(rows)} mutants killed: {dead / max(1, len(rows)):.2f}; {late} of them by the time limit")


if __name__ == "__main__":
    main()

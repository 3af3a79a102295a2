"""Mutation run: break the code in one place at a time, and see whether the tests that reach it notice.

    python tests/mutation.py --sample 400 --seed 1 --jobs 2 --report mutants.json

Needs the extra `mutation` (cosmic-ray, whose operators these are, and pytest-cov) and a suite that passes. Works on
copies, so that the tree is left alone whenever it is stopped; with `--resume` it goes on from the report. Places are
drawn at random, then one of the changes that are possible there: another arithmetic or comparison operator, a number,
a condition, a skipped loop. Annotations, decorators and guards (`strict=`) are left out, as are changes that no test
could miss (arithmetic as bitwise operators).

The suite runs once, with the lines that each test reaches noted (`--coverage FILE` keeps that for the next time). A
mutant's tests are those that reach its line, the ones beside its module first and then the quick ones, as many as fit
into `--budget` seconds. It is killed if one of them fails or they don't come to an end in time. A line that no test
reaches is a mutant that survived.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import importlib
import json
import multiprocessing
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue
from typing import Any
from xml.etree import ElementTree

import coverage
from cosmic_ray.ast import ast_nodes, get_ast_from_path
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).parents[1]
COPIED = (
    "ichain_drake", "tests", "models", "examples", "docs", "benchmarks", "notebooks",
    "README.md", "CHANGELOG.md", "LICENSE", "mkdocs.yml", "pyproject.toml",
)  # fmt: skip
PACKAGES = ("learning", "control", "runs")
WARM = ("numpy", "scipy.optimize", "scipy.spatial", "sklearn.base", "pandas", "pydrake.multibody.plant", "hypothesis")
"""What most tests import and no mutant changes: loaded once, before the processes that run tests are forked."""

_ARITHMETIC, _ORDER = "Add|Sub|Mul|Div", "Lt|LtE|Gt|GtE|Eq|NotEq"
OPERATORS = re.compile(
    rf"core/(ReplaceBinaryOperator_({_ARITHMETIC}|Pow|Mod|FloorDiv)_({_ARITHMETIC})"
    r"|ReplaceBinaryOperator_Bit(Or_BitAnd|And_BitOr)"
    rf"|ReplaceComparisonOperator_(({_ORDER})_({_ORDER})|Is_IsNot|IsNot_Is)"
    r"|ReplaceUnaryOperator_(Delete_USub|Delete_Invert|Delete_Not|USub_UAdd)"
    r"|AddNot|Replace(True|False|And|Or|Break|Continue)With\w+|NumberReplacer|ZeroIterationForLoop)"
)
Mutant = tuple[str, int, int, str, int]
"""Module, line, column, operator, and which of the operator's places in the module."""


def left_out(source: str) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Where annotations, decorators and `strict=` are: what they say is read by people and checkers, or is a guard."""
    found = []
    for node in ast.walk(ast.parse(source)):
        parts = [
            getattr(node, "annotation", None),
            getattr(node, "returns", None),
            *getattr(node, "decorator_list", ()),
        ]
        if isinstance(node, ast.keyword) and node.arg == "strict":
            parts.append(node.value)
        for part in (p for p in parts if isinstance(p, ast.expr)):
            found.append(((part.lineno, part.col_offset), (part.end_lineno or 0, part.end_col_offset or 0)))
    return found


def mutants(module: Path) -> dict[tuple[int, int], list[Mutant]]:
    """Possible changes of a module by place."""
    tree = get_ast_from_path(module)
    places: dict[tuple[int, int], list[Mutant]] = {}
    for name in filter(OPERATORS.fullmatch, operator_names()):
        operator = get_operator(name)()
        spans = [span for node in ast_nodes(tree) for span in operator.mutation_positions(node)]
        for k, (start, _end) in enumerate(spans):
            places.setdefault(tuple(start), []).append((str(module), *start, name, k))
    return places


def drawn(sample: int, seed: int, packages: tuple[str, ...]) -> list[Mutant]:
    """Mutants of so many places, without those that are left out; the same for the same tree and seed."""
    modules = sorted(f for p in packages for f in Path("ichain_drake", *p.split("/")).rglob("*.py"))
    chance = random.Random(seed)
    places = [found for module in modules for found in mutants(module).values()]
    chosen = [chance.choice(found) for found in chance.sample(places, min(sample, len(places)))]
    skipped = {m[0]: left_out(Path(m[0]).read_text()) for m in chosen}
    return [m for m in chosen if not any(first <= m[1:3] < last for first, last in skipped[m[0]])]


class Reached:
    """Which tests reach a line, and how long each takes: of one run of the whole suite in the present folder."""

    def __init__(self, kept: Path, jobs: int) -> None:
        times = kept.with_suffix(".xml")
        if not (kept.exists() and times.exists()):
            sources = ",".join(f"ichain_drake/{name}" for name in PACKAGES)
            Path("coverage.ini").write_text(f"[run]\nsource={sources}\nrelative_files=true\ndata_file={kept}\n")
            command = [sys.executable, "-m", "pytest", "-q", f"-n{jobs}", "--dist=loadfile", f"--junitxml={times}"]
            noted = ["--cov", "--cov-config=coverage.ini", "--cov-context=test", "--cov-report="]
            subprocess.run([*command, *noted], check=False)  # a test that fails is left out below
        self.data = coverage.CoverageData(str(kept))
        self.data.read()
        self.seconds: dict[str, float] = {}
        self.red: set[str] = set()
        for case in ElementTree.parse(times).iter("testcase"):
            file = case.get("classname", "").replace(".", "/") + ".py"
            name = f"{file}::{case.get('name')}"
            self.seconds[name] = float(case.get("time", 0))
            if case.find("failure") is not None or case.find("error") is not None:
                self.red.add(name)

    def tests(self, mutant: Mutant, budget: float) -> list[str]:
        """Tests of the mutant's line, the likely and quick ones first, as many as fit into the budget."""
        module, line = mutant[0], mutant[1]
        noted = self.data.contexts_by_lineno(module)
        spanned = next((n for n in range(line, 0, -1) if n in noted), line)  # a statement is noted by its first line
        found = {c.split("|")[0] for c in noted.get(spanned, []) if c}
        own, part = f"test_{Path(module).stem}.py", Path(module).parts[1:-1]
        if not found:  # run on import alone: whoever uses its module, or the modules beside it; and its own tests
            own_tests = {test for test in self.seconds if Path(test.partition("::")[0]).name == own}
            beside = [f for f in self.data.measured_files() if Path(f).parent == Path(module).parent]
            for used in ([module], beside):
                every = (self.data.contexts_by_lineno(f).values() for f in used)
                found = found or {c.split("|")[0] for lines in every for contexts in lines for c in contexts if c}
            found |= own_tests

        def order(test: str) -> tuple[int, float]:
            file = Path(test.partition("::")[0])
            near = 0 if file.name == own else 1 if file.parts[1:-1] == part else 2
            return near, self.seconds[test]

        chosen: list[str] = []
        for test in sorted(found & self.seconds.keys() - self.red, key=order):
            if not chosen or budget > self.seconds[test]:
                chosen.append(test)
                budget -= self.seconds[test]
        return chosen


def _suite(folder: str, tests: list[str], log: str) -> None:
    """In a process of its own: run tests of the copy in `folder`; its exit status is pytest's."""
    os.chdir(folder)
    sys.path.insert(0, folder)
    os.environ |= {"PYTHONPATH": folder, "OMP_NUM_THREADS": "1", "PYTEST_XDIST_WORKER": "gw0"}
    sys.dont_write_bytecode = True
    with Path(log).open("w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
        import pytest

        # What pieces are recorded is shared by all mutants, as by the workers of xdist: beside the folder of a run.
        plain = ["-x", "-q", "--no-header", "-p", "no:cacheprovider", "-p", "no:xdist", "-p", "no:cov"]
        status = pytest.main([*plain, f"--basetemp={folder}/shared/run", *tests])
        sys.stdout.flush()
        os._exit(int(status))


def tested(mutant: Mutant, tests: list[str], folder: Path, limit: float) -> dict[str, Any]:
    """Try one mutant in a copy, which is as before afterwards."""
    module, line, column, operator, which = mutant
    file, began = folder / module, time.monotonic()
    before = file.read_text()
    after = mutate_code(before.encode(), get_operator(operator)(), which)
    after = after.decode() if isinstance(after, bytes) else after
    diff = difflib.unified_diff(before.splitlines(), (after or before).splitlines(), n=0, lineterm="")
    outcome, said = "survived", ""
    if tests:
        (folder / "shared").mkdir(exist_ok=True)
        for learned in (folder / "shared").glob("*_model.pickle"):
            learned.unlink()  # with other code it is another one
        file.write_text(after or before)
        log = folder / "log.txt"
        child = multiprocessing.get_context("fork").Process(target=_suite, args=(str(folder), tests, str(log)))
        child.start()
        child.join(limit)
        log_text = log.read_text(errors="replace")
        outcome = {0: "survived", None: "timeout", 5: "no test ran"}.get(child.exitcode, "killed")
        imported = not re.search("ERROR collecting|ImportError while loading conftest", log_text)
        if child.exitcode == 4 and imported:  # not even imported is killed; not found is not
            outcome = "no test ran"
        if child.exitcode is None:
            child.kill()
            child.join()
        said = "\n".join(log_text.splitlines()[-3:])
        file.write_text(before)
    return {
        "place": f"{module}:{line}:{column}",
        "operator": f"{operator.removeprefix('core/')}/{which}",
        "outcome": outcome,
        "change": [x for x in diff if re.match(r"[+-](?![+-])", x)],
        "tests": len(tests),
        "said": said if outcome != "survived" else "",
        "seconds": round(time.monotonic() - began, 1),
    }


def run(options: argparse.Namespace, rows: list[dict[str, Any]], folder: Path) -> Iterator[dict[str, Any]]:
    """Test mutants in copies of the tree below `folder`; those of `rows` are done."""
    copies = [folder / str(k) for k in range(options.jobs)]
    for place in copies:
        for name in COPIED:
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
            copy(ROOT / name, place / name)
        for cached in place.rglob("__pycache__"):
            shutil.rmtree(cached)  # made by the second, so that a changed file could pass for its forerunner
    os.chdir(copies[0])
    os.environ["PYTHONPATH"] = str(copies[0])
    reached = Reached(options.coverage or folder / "coverage.data", options.jobs)
    for name in (*WARM, "pytest"):
        importlib.import_module(name)
    done = {(row["place"], row["operator"]) for row in rows}
    wanted = drawn(options.sample, options.seed, tuple(options.packages))
    left = [m for m in wanted if (f"{m[0]}:{m[1]}:{m[2]}", f"{m[3].removeprefix('core/')}/{m[4]}") not in done]
    print(f"{len(wanted)} mutants, {len(done)} of them done", flush=True)
    free: Queue[Path] = Queue()
    for place in copies:
        free.put(place)

    def one(mutant: Mutant) -> dict[str, Any]:
        place = free.get()
        try:
            return tested(mutant, reached.tests(mutant, options.budget), place, 3 * options.budget + 60)
        finally:
            free.put(place)

    with ThreadPoolExecutor(options.jobs) as pool:
        yield from pool.map(one, left)


def main() -> None:
    """Run, print a line a mutant and the score."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=100, help="places that are drawn")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    parser.add_argument("--jobs", type=int, default=1, help="mutants at a time")
    parser.add_argument("--budget", type=float, default=40.0, help="of a mutant's tests, as they took without it [s]")
    parser.add_argument("--packages", nargs="+", default=list(PACKAGES), help="such as learning or runs/goals")
    parser.add_argument("--coverage", type=Path, help="file of the lines that tests reach; made where there is none")
    parser.add_argument("--report", type=Path, help="JSON file of all rows")
    parser.add_argument("--resume", action="store_true", help="go on from the report")
    options = parser.parse_args()
    report = options.report and options.report.absolute()
    options.coverage = options.coverage and options.coverage.absolute()
    rows = json.loads(report.read_text()) if options.resume and report and report.exists() else []
    with tempfile.TemporaryDirectory() as folder:
        try:
            for row in run(options, rows, Path(folder).resolve()):
                rows.append(row)
                change = "  ".join(row["change"])
                print(f"{row['outcome']:11} {row['seconds']:6} s  {row['place']}  {change}", flush=True)
                if report:
                    report.write_text(json.dumps(rows, indent=1))
        finally:
            os.chdir(ROOT)
    dead = sum(row["outcome"] in ("killed", "timeout") for row in rows)
    late = sum(row["outcome"] == "timeout" for row in rows)
    print(f"{dead} of {len(rows)} mutants killed: {dead / max(1, len(rows)):.2f}; {late} of them by the time limit")


if __name__ == "__main__":
    main()

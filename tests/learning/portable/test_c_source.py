"""What is written as C gives, compiled, what it gives here."""

import ctypes
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from linked_library import CHAIN, HASH, LINK
from portable_models import ESTIMATORS, RNG, X, Y, frozen_bytes

from ichain_drake.cli.main import main
from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionModel
from ichain_drake.learning.chain.models import InverseModel
from ichain_drake.learning.frozen import freeze
from ichain_drake.learning.library import save_chain
from ichain_drake.learning.portable import effect_bytes, forward_bytes, inverse_bytes, passive_bytes, status_bytes
from ichain_drake.learning.portable.c_source import c_source
from ichain_drake.learning.portable.graph import OnnxGraph

pytest.importorskip("onnx", reason="onnx is missing: pip install 'ichain_drake[onnx]'")
COMPILER = shutil.which("cc")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler")


class Compiled:
    """A function in C; called with arrays by name, it gives its outputs by name."""

    def __init__(self, source: str, function: str, folder: Path) -> None:
        (folder / f"{function}.c").write_text(source)
        strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
        command = [str(COMPILER), *strict, "-o", f"{function}.so", f"{function}.c", "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        self._called = getattr(ctypes.CDLL(str(folder / f"{function}.so")), function)
        head = source.partition(f"void {function}(")[2].partition(")")[0]
        self._arguments = re.findall(r"(const )?double (\w+)\[(\d+)\]", head)
        assert len(self._arguments) == head.count("[")

    def __call__(self, **given: np.ndarray) -> dict[str, np.ndarray]:
        arrays = {
            name: np.array(given[name.removesuffix("_in")], dtype=float) if const else np.zeros(int(size))
            for const, name, size in self._arguments
        }
        assert all(a.shape == (int(size),) for a, (_, _, size) in zip(arrays.values(), self._arguments, strict=True))
        self._called(*(a.ctypes.data_as(ctypes.c_void_p) for a in arrays.values()))
        return {name.removesuffix("_out"): arrays[name] for const, name, _ in self._arguments if not const}


@pytest.mark.parametrize("name", ESTIMATORS)
@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
def test_every_kind_of_model_gives_the_same(name: str, tmp_path: Path) -> None:
    model = freeze(ESTIMATORS[name].fit(X, Y))
    function = Compiled(c_source(frozen_bytes(model), "model"), "model", tmp_path)
    for row in RNG.normal(size=(20, 3)) * 1.5:
        np.testing.assert_allclose(function(x=row)["y"], model.batch(row[None])[0], rtol=1e-12, atol=1e-12)


def test_a_link_takes_and_gives_states(tmp_path: Path) -> None:
    (link,) = CHAIN.links
    forward = Compiled(c_source(forward_bytes(link.forward.model), "forward"), "forward", tmp_path)
    inverse: InverseModel = link.best_inverse.model
    backward = Compiled(c_source(inverse_bytes(inverse), "inverse-0"), "inverse_0", tmp_path)
    for c, p, q in RNG.normal(size=(10, 3, 2)):
        found = forward(child=c, parent=p, parent_next=q)["child_next"]
        np.testing.assert_allclose(found, link.forward.model.predict(c[None], p[None], q[None])[0], atol=1e-12)
        found = backward(child=c, wanted=q)["parent"]
        np.testing.assert_allclose(found, inverse(c[None], q[None])[0], atol=1e-12)


def test_the_parts_of_a_graph_take_and_give_states(dispenser_model: InteractionModel, tmp_path: Path) -> None:
    graph, rows = dispenser_model.graph, {}
    for name in graph.objects:
        low, high = dispenser_model.low[name], dispenser_model.high[name]
        rows[name] = RNG.uniform(low, high, (6, len(low)))
    for number, edge in enumerate(graph.interactions):
        source = c_source(status_bytes(dispenser_model, edge), f"status{number}")
        function, decided = Compiled(source, f"status{number}", tmp_path), dispenser_model.decide(edge, rows)
        for k in range(6):
            found = function(**{n: r[k] for n, r in rows.items()})
            np.testing.assert_allclose(found["decision"], decided[k], rtol=1e-9, atol=1e-9)
            assert 0.0 <= found["probability"][0] <= 1.0
    edge = graph.interactions[0]
    effect = Compiled(c_source(effect_bytes(dispenser_model, edge), "effect"), "effect", tmp_path)
    moved = rows[edge.parent] + 0.01
    changes = dispenser_model.effect(edge, rows, moved)
    passive = dispenser_model.passive[edge.child]
    alone = Compiled(c_source(passive_bytes(passive), "passive"), "passive", tmp_path)
    for k in range(6):
        state = rows[edge.child][k]
        found = effect(parent=rows[edge.parent][k], parent_next=moved[k], child=state)["change"]
        np.testing.assert_allclose(found, changes[k], atol=1e-9)
        found = alone(state=state)["next_state"]
        np.testing.assert_allclose(found, passive.settle(state[None], passive(state[None]))[0], atol=1e-12)


def test_names_that_are_words_of_c_can_be_arguments(tmp_path: Path) -> None:
    graph = OnnxGraph("switch")
    graph.output("exp", graph("Exp", graph.join([graph.input("switch", 1), graph.input("k", 2)])), 3)
    function = Compiled(c_source(graph.to_bytes({"model": "*/ int"}), "a-b.c"), "a_b_c", tmp_path)
    np.testing.assert_allclose(function(switch=[1.0], k=[0.0, -1.0])["exp"], np.exp([1.0, 0.0, -1.0]))


def test_links_of_a_library_as_sources(tmp_path: Path) -> None:
    save_chain(CHAIN, tmp_path / "lib", "a test", HASH)
    given = ["library", "export", LINK, "--library", str(tmp_path / "lib"), "-o", str(tmp_path / "out"), "--form", "c"]
    assert main(given) == 0
    files = {f.name for f in (tmp_path / "out").iterdir()}
    assert "forward.c" in files
    assert all(name.endswith(".c") for name in files)
    text = (tmp_path / "out" / "forward.c").read_text()
    assert "void forward(const double child_in[2]" in text
    assert '"unit": "m"' in text


def test_an_operator_without_a_form_is_told() -> None:
    graph = OnnxGraph("other")
    graph.output("y", graph("Softmax", graph.input("x", 2)), 2)
    with pytest.raises(InputError, match="a model with Softmax can't be written as C"):
        c_source(graph.to_bytes({}), "y")

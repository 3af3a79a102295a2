"""Building an ONNX graph, node by node: tables of a row a sample, in double precision."""

from __future__ import annotations

import importlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ichain_drake.errors import InputError

_OPSET = 18  # from it on, sums and extremes take their axes as inputs
_IR = 9  # what readers of that opset know
_FLOAT32, _INT64, _DOUBLE = 1, 7, 11  # numbers of ONNX's types


class OnnxGraph:
    """A graph that grows; what its methods return and take are names of tables, shape (n, width).

    Args:
        name: of it.

    Raises:
        InputError: if the extra `onnx` is not installed; says what to install.
    """

    def __init__(self, name: str) -> None:
        try:
            self._onnx = importlib.import_module("onnx")
            self._numpy = importlib.import_module("onnx.numpy_helper")
        except ImportError:
            raise InputError("writing ONNX needs onnx; install it with `pip install 'ichain_drake[onnx]'`") from None
        self._name = name
        self._nodes: list[Any] = []
        self._constants: list[Any] = []
        self._inputs: list[Any] = []
        self._outputs: list[Any] = []

    def input(self, name: str, width: int) -> str:
        """A table that comes from outside."""
        self._inputs.append(self._onnx.helper.make_tensor_value_info(name, _DOUBLE, ["n", width]))
        return name

    def output(self, name: str, table: str, width: int) -> None:
        """A table that goes outside."""
        self._nodes.append(self._onnx.helper.make_node("Identity", [table], [name]))
        self._outputs.append(self._onnx.helper.make_tensor_value_info(name, _DOUBLE, ["n", width]))

    def constant(self, value: ArrayLike) -> str:
        """An array that stays, of numbers in double precision or of whole numbers."""
        array = np.asarray(value)
        array = array.astype(np.int64 if array.dtype.kind in "iu" else np.float64)
        name = f"constant:{len(self._constants)}"
        self._constants.append(self._numpy.from_array(np.ascontiguousarray(array).reshape(array.shape), name))
        return name

    def __call__(self, kind: str, *inputs: str | ArrayLike, **attributes: Any) -> str:
        """A node with one output; inputs that are no names are constants.

        Args:
            kind: ONNX's name of the operator.
            inputs: its inputs.
            attributes: the operator's.
        """
        names = [i if isinstance(i, str) else self.constant(i) for i in inputs]
        out = f"{kind}:{len(self._nodes)}"
        self._nodes.append(self._onnx.helper.make_node(kind, names, [out], **attributes))
        return out

    def columns(self, table: str, indices: ArrayLike) -> str:
        """Some columns, by whole numbers from 0, shape (n, len(indices))."""
        return self("Gather", table, np.array(indices, dtype=np.int64).reshape(-1), axis=1)

    def join(self, tables: Sequence[str]) -> str:
        """Tables side by side."""
        return tables[0] if len(tables) == 1 else self("Concat", *tables, axis=1)

    def rows(self, like: str, width: int, values: ArrayLike) -> str:
        """The same row for every row of another table, shape (n, len(values)).

        Args:
            like: the other table.
            width: its width.
            values: of the row.
        """
        row = np.asarray(values, dtype=float)
        return self("Add", self("MatMul", like, np.zeros((width, len(row)))), row)

    def numbers(self, truth: str, *, whole: bool = False) -> str:
        """0 and 1 for no and yes; `whole` for whole numbers."""
        return self("Cast", truth, to=_INT64 if whole else _DOUBLE)

    def smallest(self, table: str, count: int) -> tuple[str, str]:
        """The smallest entries of each row, and their places, shape (n, count) each."""
        names = [f"TopK:{len(self._nodes)}:{what}" for what in ("values", "places")]
        inputs = [table, self.constant(np.array([count]))]
        self._nodes.append(self._onnx.helper.make_node("TopK", inputs, names, axis=1, largest=0))
        return names[0], names[1]

    def spread_over(self, like: str, row: ArrayLike) -> str:
        """A row of whole numbers, the same for every row of another table, shape (n, len(row))."""
        whole = np.asarray(row, dtype=np.int64)[None, :]
        shape = self("Concat", self("Shape", like, start=0, end=1), np.array([whole.shape[1]]), axis=0)
        return self("Expand", whole, shape)

    def wrapped(self, angle: str) -> str:
        """Angles brought back to [-pi, pi)."""
        shifted = self("Add", angle, np.float64(np.pi))
        turns = self("Floor", self("Div", shifted, np.float64(2 * np.pi)))
        return self("Sub", self("Sub", shifted, self("Mul", turns, np.float64(2 * np.pi))), np.float64(np.pi))

    def single(self, kind: str, table: str) -> str:
        """An operator that runtimes know in single precision only: its result is good to 1e-7."""
        return self("Cast", self(kind, self("Cast", table, to=_FLOAT32)), to=_DOUBLE)

    def rounded(self, table: str) -> str:
        """Numbers as single precision holds them, in double."""
        return self("Cast", self("Cast", table, to=_FLOAT32), to=_DOUBLE)

    def to_bytes(self, about: Mapping[str, Any]) -> bytes:
        """The finished model, checked.

        Args:
            about: what it is, kept in its metadata under `ichain_drake` as JSON.
        """
        helper = self._onnx.helper
        graph = helper.make_graph(self._nodes, self._name, self._inputs, self._outputs, self._constants)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", _OPSET)], ir_version=_IR)
        model.producer_name = "ichain_drake"
        helper.set_model_props(model, {"ichain_drake": json.dumps(about)})
        self._onnx.checker.check_model(model, full_check=True)
        return bytes(model.SerializeToString())

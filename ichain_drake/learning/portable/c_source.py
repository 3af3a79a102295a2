"""An exported model as C: one function without dependencies, memory of its own or state, for one row a call.

What is written is read off the ONNX graph, node by node, so that both say the same; shapes are those that the graph has
for one row.
"""

from __future__ import annotations

import importlib
import json
import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ichain_drake.errors import InputError

_TYPES = {"f8": "double", "f4": "float", "i8": "long long", "b1": "int"}
_UNARY = {
    "Identity": "{0}", "Abs": "fabs({0})", "Cos": "cos({0})", "Sin": "sin({0})", "Exp": "exp({0})",
    "Sqrt": "sqrt({0})", "Reciprocal": "1.0 / {0}", "Floor": "floor({0})", "Relu": "fmax({0}, 0.0)",
    "Sigmoid": "1.0 / (1.0 + exp(-{0}))", "Tanh": "tanh({0})", "Erf": "erf({0})", "Cast": "{0}", "Unsqueeze": "{0}",
    "Expand": "{0}",
}  # fmt: skip
_BINARY = {
    "Add": "{0} + {1}", "Sub": "{0} - {1}", "Mul": "{0} * {1}", "Div": "{0} / {1}", "Min": "fmin({0}, {1})",
    "Max": "fmax({0}, {1})", "Equal": "{0} == {1}", "Greater": "{0} > {1}", "Less": "{0} < {1}",
    "LessOrEqual": "{0} <= {1}", "Where": "{0} ? {1} : {2}",
}  # fmt: skip


def c_source(content: bytes, function: str) -> str:
    """C99 source of `void function(const double input_in[], ..., double output_out[], ...)`.

    Args:
        content: a model as `forward_bytes` and its like give it.
        function: name of the function; other characters than letters and digits become underscores.

    Raises:
        InputError: if the extra `onnx` is not installed, or on an operator that has no form here.
    """
    try:
        onnx = importlib.import_module("onnx")
        reference = importlib.import_module("onnx.reference")
        numpy_helper = importlib.import_module("onnx.numpy_helper")
    except ImportError:
        raise InputError("writing C needs onnx; install it with `pip install 'ichain_drake[onnx]'`") from None
    model = onnx.load_model_from_string(content)
    constants = {c.name: np.asarray(numpy_helper.to_array(c)) for c in model.graph.initializer}
    about = {p.key: p.value for p in model.metadata_props}
    inputs = {i.name: i.type.tensor_type.shape.dim[1].dim_value for i in model.graph.input}
    outputs = [o.name for o in model.graph.output]
    needed = set(outputs)
    nodes: list[Any] = []
    for node in reversed(model.graph.node):  # what nothing is made of is left out
        if needed & set(node.output):
            nodes.insert(0, node)
            needed |= set(node.input)
    names = [name for node in nodes for name in node.output]
    whole = onnx.ModelProto()
    whole.CopyFrom(model)
    for name in set(names) - set(outputs):
        whole.graph.output.append(onnx.ValueInfoProto(name=name))
    row = {name: np.zeros((1, width)) for name, width in inputs.items()}
    asked = [o.name for o in whole.graph.output]
    values = dict(zip(asked, reference.ReferenceEvaluator(whole).run(asked, row), strict=True)) | row | constants
    ends = dict.fromkeys(inputs, "_in") | dict.fromkeys(outputs, "_out")
    writer = _Writer({n: np.asarray(v) for n, v in values.items()}, ends)
    body = [line for node in nodes for line in writer.node(node, onnx.helper.get_attribute_value)]
    used = set(re.findall(r"\w+", " ".join(body)))
    tables = [writer.constant(name, value) for name, value in constants.items() if writer.name(name) in used]
    given = [f"const double {writer.name(n)}[{w}]" for n, w in inputs.items()]
    given += [f"double {writer.name(n)}[{values[n].size}]" for n in outputs]
    said = json.dumps(json.loads(about.get("ichain_drake", "{}")), indent=1).replace("*/", "* /")
    name = re.sub(r"\W", "_", function, flags=re.ASCII)
    lines = [f"/* {said} */", "#include <math.h>", "#include <string.h>", "", *tables, ""]
    return "\n".join([*lines, f"void {name}({', '.join(given)})", "{", *body, "}", ""])


class _Writer:
    """Statements for nodes whose tensors have known shapes.

    Args:
        values: every tensor, at one row.
        outside: what is put behind the names of those that are arguments: so none is a word of C.
    """

    def __init__(self, values: dict[str, NDArray[Any]], outside: dict[str, str]) -> None:
        self._values, self._outside = values, outside

    def name(self, tensor: str) -> str:
        """In C."""
        name = re.sub(r"\W", "_", tensor, flags=re.ASCII)
        return f"{name}{self._outside[tensor]}" if tensor in self._outside else f"v_{name}"

    def _type(self, tensor: str) -> str:
        return _TYPES[self._values[tensor].dtype.str[1:]]

    def constant(self, name: str, value: NDArray[Any]) -> str:
        """A table of the model's own."""
        numbers = ", ".join(repr(v).replace("inf", "INFINITY") for v in value.ravel().tolist())
        return f"static const {self._type(name)} {self.name(name)}[{value.size}] = {{{numbers}}};"

    def node(self, node: Any, read: Callable[[Any], Any]) -> Iterator[str]:
        """Lines of one node.

        Raises:
            InputError: on an operator that has no form here.
        """
        for out in node.output:
            if out not in self._outside:
                yield f"  {self._type(out)} {self.name(out)}[{max(self._values[out].size, 1)}];"
        attributes = {a.name: read(a) for a in node.attribute}
        kind, (out, *_), inputs = node.op_type, node.output, list(node.input)
        if kind in _UNARY or kind in _BINARY:
            yield self._by_entry({**_UNARY, **_BINARY}[kind], inputs[:1] if kind in _UNARY else inputs, out)
        elif kind == "Shape":
            numbers = self._values[out].tolist()
            yield from (f"  {self.name(out)}[{k}] = {number};" for k, number in enumerate(numbers))
        elif kind == "TopK":
            yield self._smallest(inputs[0], *node.output)
        elif kind in ("MatMul", "ReduceSum", "ReduceMax", "Concat", "Gather", "GatherElements"):
            yield from getattr(self, f"_{kind.lower()}")(inputs, out, attributes)
        else:
            raise InputError(f"a model with {kind} can't be written as C")

    def _by_entry(self, form: str, inputs: Sequence[str], out: str) -> str:
        """An expression for every entry, inputs broadcast."""
        shape = self._values[out].shape
        if self._values[inputs[0]].size == self._values[out].size:  # as Unsqueeze: the same entries in order
            size = self._values[out].size
            if all(self._values[i].size in (1, size) for i in inputs):
                terms = [f"{self.name(i)}[{'k' if self._values[i].size == size else '0'}]" for i in inputs]
                return f"  for (int k = 0; k < {size}; ++k) {self.name(out)}[k] = {form.format(*terms)};"
        loops = "".join(f"for (int i{d} = 0; i{d} < {n}; ++i{d}) " for d, n in enumerate(shape))
        terms = [f"{self.name(i)}[{_place(self._values[i].shape, len(shape))}]" for i in inputs]
        return f"  {loops}{self.name(out)}[{_place(shape, len(shape))}] = {form.format(*terms)};"

    def _matmul(self, inputs: Sequence[str], out: str, attributes: object) -> Iterator[str]:
        rows, inner = self._values[inputs[0]].shape
        columns = self._values[inputs[1]].shape[1]
        a, b, c = (self.name(n) for n in (*inputs, out))
        yield f"  for (int i = 0; i < {rows}; ++i) for (int j = 0; j < {columns}; ++j) {{"
        term = f"{a}[i * {inner} + k] * {b}[k * {columns} + j]"
        yield f"    double s = 0.0; for (int k = 0; k < {inner}; ++k) s += {term};"
        yield f"    {c}[i * {columns} + j] = s; }}"

    def _reduce(self, inputs: Sequence[str], out: str, start: str, step: str) -> Iterator[str]:
        shape, (axis,) = self._values[inputs[0]].shape, self._values[inputs[1]].tolist()
        before, size, after = _around(shape, axis)
        a = f"{self.name(inputs[0])}[(i * {size} + k) * {after} + j]"
        yield f"  for (int i = 0; i < {before}; ++i) for (int j = 0; j < {after}; ++j) {{"
        yield f"    double s = {start}; for (int k = 0; k < {size}; ++k) {step.format(a)};"
        yield f"    {self.name(out)}[i * {after} + j] = s; }}"

    def _reducesum(self, inputs: Sequence[str], out: str, attributes: object) -> Iterator[str]:
        return self._reduce(inputs, out, "0.0", "s += {0}")

    def _reducemax(self, inputs: Sequence[str], out: str, attributes: object) -> Iterator[str]:
        return self._reduce(inputs, out, "-INFINITY", "s = fmax(s, {0})")

    def _concat(self, inputs: Sequence[str], out: str, attributes: dict[str, Any]) -> Iterator[str]:
        before, size, after = _around(self._values[out].shape, attributes["axis"])
        start = 0
        for name in inputs:
            wide = self._values[name].shape[attributes["axis"]]
            yield (
                f"  for (int i = 0; i < {before}; ++i) memcpy({self.name(out)} + (i * {size} + {start}) * {after}, "
                f"{self.name(name)} + i * {wide * after}, {wide * after} * sizeof(*{self.name(out)}));"
            )
            start += wide

    def _gather(self, inputs: Sequence[str], out: str, attributes: dict[str, Any]) -> Iterator[str]:
        before, size, after = _around(self._values[inputs[0]].shape, attributes.get("axis", 0))
        count = self._values[inputs[1]].size
        a, index, c = (self.name(n) for n in (*inputs, out))
        yield (
            f"  for (int i = 0; i < {before}; ++i) for (int k = 0; k < {count}; ++k) for (int j = 0; j < {after}; ++j) "
            f"{c}[(i * {count} + k) * {after} + j] = {a}[(i * {size} + {index}[k]) * {after} + j];"
        )

    def _gatherelements(self, inputs: Sequence[str], out: str, attributes: dict[str, Any]) -> Iterator[str]:
        """Along the last axis of a single row."""
        a, index, c = (self.name(n) for n in (*inputs, out))
        yield f"  for (int k = 0; k < {self._values[out].size}; ++k) {c}[k] = {a}[{index}[k]];"

    def _smallest(self, table: str, values: str, places: str) -> str:
        size, count = self._values[table].size, self._values[values].size
        a, v, p = (self.name(n) for n in (table, values, places))
        return f"""  for (int k = 0; k < {count}; ++k) {{
    int best = -1;
    for (int i = 0; i < {size}; ++i) {{
      int taken = 0;
      for (int m = 0; m < k; ++m) taken |= {p}[m] == i;
      if (!taken && (best < 0 || {a}[i] < {a}[best])) best = i;
    }}
    {v}[k] = {a}[best]; {p}[k] = best;
  }}"""


def _around(shape: tuple[int, ...], axis: int) -> tuple[int, int, int]:
    """Number of entries before an axis, along it, and behind it."""
    axis %= len(shape)
    return int(np.prod(shape[:axis], dtype=int)), shape[axis], int(np.prod(shape[axis + 1 :], dtype=int))


def _place(shape: tuple[int, ...], dimensions: int) -> str:
    """Index of an entry of a tensor that is broadcast over so many loops."""
    terms, stride = [], 1
    for k in range(1, len(shape) + 1):
        if shape[-k] > 1:
            terms.append(f"i{dimensions - k} * {stride}")
        stride *= shape[-k]
    return " + ".join(terms) or "0"

"""A change that only ever goes one way goes no other as ONNX, either."""

import numpy as np
import pytest

from ichain_drake.learning.effects.fitted import Regression
from ichain_drake.learning.frozen.polynomial import Polynomial
from ichain_drake.learning.passive import PassiveDynamics, PassiveVariable
from ichain_drake.learning.portable import passive_bytes
from ichain_drake.state import StateSpace, Variable

pytest.importorskip("onnx", reason="onnx is missing: pip install 'ichain_drake[onnx]'")
runtime = pytest.importorskip("onnxruntime", reason="onnxruntime is missing: pip install 'ichain_drake[dev]'")


@pytest.mark.parametrize("sign", [1, -1, 0])
def test_what_goes_one_way_goes_no_other(sign: int) -> None:
    line = Polynomial.from_terms(np.ones((1, 1), dtype=np.int64), np.full((1, 1), 0.1), np.zeros(1))
    drift = Regression((0,), line, 0.0, None, None, 0.0, sign, "polynomial", 0.0, 0.0, 1.0, 9, 3, 1.0)
    passive = PassiveDynamics(
        StateSpace("tank", (Variable("water"),)), (PassiveVariable("learned", drift=drift, inputs=(0,)),)
    )
    state = np.array([[-0.5], [0.0], [0.5]])
    session = runtime.InferenceSession(passive_bytes(passive), providers=["CPUExecutionProvider"])
    after = session.run(None, {"state": state})[0]
    np.testing.assert_allclose(after, passive(state), atol=1e-12)
    assert (after - state)[:, 0].tolist() == pytest.approx([-0.05 * (sign <= 0), 0.0, 0.05 * (sign >= 0)])

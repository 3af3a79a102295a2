"""Learning one link: recovers what made the data, chooses the right view of it, refuses what can't be learned."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration, collect_transitions
from ichain_drake.demonstrations.transitions import Transitions
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.chain.link import (
    EstimatorSpec,
    ForwardSpec,
    InverseSpec,
    best_by_score,
    fit_forward,
    fit_inverse,
)
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

TWO = StateSpace("two", (Variable("a"), Variable("b")))
EDGE = Interaction("r", "c")
GRAPH = InteractionGraph({"r": TWO, "c": TWO}, [EDGE])
A, B = np.array([[0.9, 0.2], [-0.1, 0.7]]), np.array([[0.5, 0.1], [0.0, -0.4]])
LINEAR = EstimatorSpec("polynomial", {"degree": 1, "alphas": [1e-6]})


def linear_data(rows: int = 200, noise: float = 0.0) -> Transitions:
    """child(t + 1) = A child(t) + B parent(t + 1)."""
    rng = np.random.default_rng(0)
    parent, child = rng.uniform(-1, 1, (rows, 2)), np.zeros((rows, 2))
    for k in range(1, rows):
        child[k] = A @ child[k - 1] + B @ parent[k] + noise * rng.standard_normal(2)
    columns = {"r.a": parent[:, 0], "r.b": parent[:, 1], "c.a": child[:, 0], "c.b": child[:, 1]}
    table = pd.DataFrame({"time": TICK * np.arange(rows), **columns})
    return collect_transitions([Demonstration(table)], GRAPH, EDGE)


def test_a_linear_forward_model_is_recovered() -> None:
    fitted = fit_forward(linear_data(), ForwardSpec(LINEAR, "raw", "next"), EDGE)
    _, by_child, by_parent, by_next = fitted.model.linearize(*[np.full((1, 2), v) for v in (0.1, 0.3, -0.2)])
    np.testing.assert_allclose(by_child[0], A, atol=1e-6)
    np.testing.assert_allclose(by_next[0], B, atol=1e-6)
    np.testing.assert_array_equal(by_parent, 0.0)
    assert fitted.score > 1 - 1e-9
    assert fitted.samples == 199


def test_a_linear_inverse_model_is_recovered() -> None:
    data = linear_data()
    fitted = fit_inverse(data, InverseSpec(LINEAR, "raw"), (0, 1), EDGE)
    np.testing.assert_allclose(fitted.model(data.child, data.child_next), data.parent_next, atol=1e-6)
    assert fitted.score > 1 - 1e-9


def test_an_inverse_that_aims_further_learns_from_the_later_state() -> None:
    """Part of the answer is then unknowable (what the parent does in the second tick), but not all of it."""
    data = linear_data()
    fitted = fit_inverse(data, InverseSpec(LINEAR, "raw", aim=2), (0, 1), EDGE)
    later, usable = data.child_ahead(2)
    assert fitted.samples == usable.sum() == 198
    residual = fitted.model(data.child, later) - data.parent_next
    assert 0.05 < residual[usable].std() < data.parent_next.std()


def test_the_parent_at_t_plus_1_is_the_better_action() -> None:
    """The paper's finding (sec. III), on data in which it is true."""
    scored = [fit_forward(linear_data(noise=0.01), ForwardSpec(LINEAR, "raw", a), EDGE) for a in ("current", "next")]  # type: ignore[arg-type]
    assert best_by_score(scored) is scored[1]
    assert scored[1].score > 0.99
    assert scored[0].score < 0.5


@pytest.mark.parametrize("name", ["polynomial", "LinearRegression", "gaussian_process"])
def test_the_residual_is_that_of_rows_left_out(name: str) -> None:
    parameters = {} if name == "LinearRegression" else {"degree": 1}
    fitted = fit_forward(linear_data(600, noise=0.05), ForwardSpec(EstimatorSpec(name, parameters)), EDGE)
    np.testing.assert_allclose(fitted.residual_std, 0.05, rtol=0.15)


@pytest.mark.parametrize(
    ("rows", "spec", "message"),
    [
        (8, EstimatorSpec("polynomial", {"degree": 3}), r"7 transitions are too few for polynomial\(degree=3\)"),
        (20, EstimatorSpec("polynomial", {"degree": 5}), "n_samples = 19 for degree 5"),
        (40, EstimatorSpec("polynomial", {"degree": 0}), "degree 0: give a whole number"),
        (40, EstimatorSpec("Ridge", {"alpha": "much"}), r"Ridge\(alpha='much'\): .*alpha"),
        (40, EstimatorSpec("KNeighborsRegressor", {"n_neighbors": 99}), "KNeighborsRegressor"),
        (40, EstimatorSpec("polynomal"), "no estimator 'polynomal'; did you mean polynomial"),
        (40, EstimatorSpec("polynomial", {"power": 2}), "polynomial has no parameter 'power'"),
    ],
)
def test_what_can_not_be_fitted_is_refused_with_the_links_name(rows: int, spec: EstimatorSpec, message: str) -> None:
    data = linear_data(rows)
    with pytest.raises(InputError, match=f"^r->c, forward model: .*{message}"):
        fit_forward(data, ForwardSpec(spec), EDGE)
    with pytest.raises(InputError, match=f"^r->c, inverse model: .*{message}"):
        fit_inverse(data, InverseSpec(spec), (0, 1), EDGE)


@pytest.mark.parametrize(
    ("text", "name", "parameters"),
    [
        ("polynomial", "polynomial", {}),
        (" polynomial(degree=2) ", "polynomial", {"degree": 2}),
        ("mlp(hidden_layer_sizes=(8, 8), alpha=1e-3, activation='tanh')", "mlp",
         {"hidden_layer_sizes": (8, 8), "alpha": 1e-3, "activation": "tanh"}),
        ("Ridge()", "Ridge", {}),
        ("polynomial(clip=None, alphas=[-1.0])", "polynomial", {"clip": None, "alphas": [-1.0]}),
    ],
)  # fmt: skip
def test_estimators_are_read_from_text(text: str, name: str, parameters: dict[str, object]) -> None:
    spec = EstimatorSpec.parse(text)
    assert (spec.name, spec.parameters) == (name, parameters)
    assert EstimatorSpec.parse(str(spec)) == spec


@pytest.mark.parametrize(
    "text",
    [
        "", "polynomial(", "polynomial(2)", "polynomial(degree=open('x'))", "polynomial(degree=1 if True else 2)",
        "__import__('os').system('true')", "os.system", "polynomial(degree=x)", "[polynomial]", "a; b",
        "polynomial(**{'degree': 2})", "polynomial(degree={[]: 1})", "polynomial(degree=" + "(" * 500 + ")" * 500 + ")",
    ],
)  # fmt: skip
def test_anything_but_literals_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="write name or name"):
        EstimatorSpec.parse(text)


def test_what_does_not_change_counts_for_no_score() -> None:
    """Half of the variance of the one that does is unknowable; the other, which stands still, is told exactly."""
    data = linear_data(noise=0.3)
    still = replace(data, child=data.child * [1.0, 0.0], child_next=data.child_next * [1.0, 0.0])
    fitted = fit_forward(still, ForwardSpec(LINEAR, "raw", "next"), EDGE)
    left = fitted.residual_std[0] ** 2 / (still.child_next - still.child)[:, 0].var()
    assert fitted.score == pytest.approx(1.0 - left, abs=1e-9)
    nothing = replace(still, child=0.0 * still.child, child_next=0.0 * still.child)
    assert fit_forward(nothing, ForwardSpec(LINEAR, "raw", "next"), EDGE).score == 1.0

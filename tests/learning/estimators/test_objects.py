"""Estimator objects where names go, what can't be frozen, and what estimators warn of."""

import inspect
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sklearn.ensemble import BaggingRegressor
from sklearn.exceptions import ConvergenceWarning
from sklearn.linear_model import LogisticRegression, Ridge, RidgeCV
from sklearn.multioutput import MultiOutputRegressor
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import MinMaxScaler, StandardScaler

import ichain_drake as ic
from ichain_drake.errors import InputError
from ichain_drake.learning import InteractionSpec
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.estimators import make_estimator
from ichain_drake.learning.estimators.trial import try_out
from ichain_drake.learning.estimators.warned import EstimatorWarning, collected_warnings
from ichain_drake.learning.library.save import spec_text
from ichain_drake.learning.spec import spec_of
from ichain_drake.systems.car_game.scenario import CarGame


def test_an_object_goes_where_a_name_goes() -> None:
    pipeline = make_pipeline(StandardScaler(), Ridge(alpha=2.0))
    candidates = ic.LinkCandidates(forward=(Ridge(alpha=2.0), pipeline), inverse="polynomial(degree=3)")  # type: ignore[arg-type]
    ridge, scaled = candidates.forward
    assert str(ridge) == "Ridge(alpha=2.0)"
    assert scaled.name == "Pipeline"
    assert ridge.make().alpha == 2.0 and ridge.make() is not ridge.make()
    assert [s.name for s in candidates.inverse] == ["polynomial"]
    spec = InteractionSpec(effect_estimators=[pipeline], status_estimators=[LogisticRegression(C=3.0)])  # type: ignore[arg-type]
    assert str(spec.status_estimators[0]) == "LogisticRegression(C=3.0)"


def test_a_chain_is_learned_and_saved_with_objects_and_with_a_generator_of_pieces(tmp_path: Path) -> None:
    scenario = CarGame("learning.samples=60", "ideal")
    candidates = {"*": ic.LinkCandidates(forward=(make_pipeline(StandardScaler(), Ridge()),), features=("raw",))}
    pieces = scenario.record_demonstrations()
    assert inspect.isgenerator(pieces)
    chain = ic.learn_chain(pieces, scenario.graph, "car", ("x", "y"), candidates)
    ic.save_chain(chain, str(tmp_path / "library"), "car_game", "0" * 64)
    assert {link.name for link in ic.list_library(str(tmp_path / "library"))}
    links = ic.load_links(str(tmp_path / "library"), scenario.graph, ["hand", "joystick", "car"], ("x", "y"))
    x = np.zeros((1, len(scenario.graph.objects["car"].observable)))
    parent = np.zeros((1, len(scenario.graph.objects["joystick"].observable)))
    before, after = (c.forward.model.predict(x, parent, parent) for c in (chain.links[1], links["joystick->car"]))
    np.testing.assert_array_equal(before, after)


def test_a_list_of_both_kinds_goes_into_learn() -> None:
    scenario = CarGame("learning.samples=60", "ideal")
    pieces = list(scenario.record_demonstrations())
    model = ic.learn(scenario, pieces, estimators=[make_pipeline(StandardScaler(), Ridge())])
    assert model.chain is not None
    assert {link.forward.spec.estimator.name for link in model.chain.links} == {"Pipeline"}
    spec = spec_of([LogisticRegression(C=3.0), "Ridge(alpha=2.0)", "box"])
    assert [str(s) for s in spec.effect_estimators] == ["Ridge(alpha=2.0)"]
    assert [s.name for s in spec.status_estimators] == ["LogisticRegression", "box"]
    assert spec_of(Ridge()).status_estimators == InteractionSpec().status_estimators
    for given, message in (
        ({"estimators": [BaggingRegressor()]}, "BaggingRegressor can't be frozen"),
        ({"estimators": Ridge}, "is no estimator"),
        ({"estimators": 3}, "is no estimator"),
        ({"estimators": [Ridge()], "spec": {}}, "given twice"),
        ({"spec": [Ridge()]}, "spec is of type list, LinkCandidates by interaction name needed"),
    ):
        with pytest.raises(InputError, match=message):
            ic.learn(scenario, pieces, **given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("estimator", "message"),
    [
        (MultiOutputRegressor("Ridge"), "MultiOutputRegressor(estimator='Ridge')"),
        (BaggingRegressor(), "BaggingRegressor(): BaggingRegressor can't be frozen; what can be: Pipelines of"),
        (make_pipeline(MinMaxScaler(), Ridge()), "can be"),
        (RidgeCV(alphas=[]), "RidgeCV(alphas=[]): it can't be fitted with these parameters (AttributeError: "),
        (Ridge(alpha=-1), "Ridge(alpha=-1): "),
        (LogisticRegression(), "it is no regressor"),
        (Ridge, "is no estimator; give a name such as"),
        (3, "is no estimator"),
    ],
)
def test_what_can_not_be_used_is_refused_at_once_in_one_line(estimator: Any, message: str) -> None:
    with pytest.raises(InputError) as caught:
        ic.LinkCandidates(forward=(estimator,))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    if "frozen" in str(caught.value):
        assert "GradientBoostingRegressor" in str(caught.value)  # the list


def test_a_regressor_is_no_classifier() -> None:
    with pytest.raises(InputError, match="it is no classifier"):
        InteractionSpec(status_estimators=(Ridge(),))  # type: ignore[arg-type]


def test_the_text_of_an_object_is_one_that_can_be_read_back() -> None:
    for estimator in (Ridge(alpha=3.0), make_pipeline(StandardScaler(), Ridge())):
        text = spec_text(EstimatorSpec.of(estimator), "here")
        assert EstimatorSpec.parse(text).name == type(estimator).__name__


@pytest.mark.parametrize("name", ["polynomial", "gaussian_process"])
def test_a_degree_that_is_far_too_high_is_refused_before_any_work(name: str) -> None:
    x = np.random.default_rng(0).normal(size=(500, 8))
    with pytest.raises(InputError, match="n_samples = 500 for degree 60"):
        make_estimator(name, degree=60).fit(x, x[:, 0])
    with pytest.raises(InputError, match="for degree 60"):
        try_out(make_estimator(name, degree=60))


def test_warnings_of_fits_become_one_line() -> None:
    said: list[str] = []
    x = np.random.default_rng(0).normal(size=(60, 2))
    with collected_warnings(said.append):
        for _ in range(3):
            MLPRegressor(max_iter=2, random_state=0).fit(x, x[:, 0])
        warnings.warn("plain", RuntimeWarning, stacklevel=1)
    (line,) = said
    assert line.startswith("estimators warned 4 times: ConvergenceWarning: Stochastic Optimizer")
    assert "(3 times); RuntimeWarning: plain" in line
    with pytest.warns(EstimatorWarning, match="estimators warned") as seen, collected_warnings():
        warnings.warn("slow", ConvergenceWarning, stacklevel=1)
        with collected_warnings():
            warnings.warn("slow", ConvergenceWarning, stacklevel=1)
    assert len(seen) == 1
    with pytest.warns(DeprecationWarning, match="old"), collected_warnings(said.append):
        warnings.warn("old", DeprecationWarning, stacklevel=1)
    assert len(said) == 1


def test_every_public_function_takes_a_path_as_text_too() -> None:
    found = 0
    for name in ic.__all__:
        function = getattr(ic, name)
        if not inspect.isfunction(function) or function.__module__.startswith("ichain_drake.demonstrations"):
            continue
        for parameter in inspect.signature(function).parameters.values():
            annotation = str(parameter.annotation).replace("pathlib.", "")
            if "Path" in annotation.replace("|", " ").split():
                found += 1
                assert "str" in annotation, f"{name}({parameter.name}: {annotation})"
    assert found > 3

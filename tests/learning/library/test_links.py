"""A saved link comes back as it was, to the last bit, and is found by what it connects."""

import tempfile
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import Interaction, InteractionGraph
from ichain_drake.learning.chain.chain import LearnedChain, LearnedLink, LinkCandidates, learn_chain
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.library import (
    add_to_library,
    check_library,
    link_name,
    list_library,
    load_command,
    load_link,
    load_links,
    save_chain,
    save_link,
    show_link,
)
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

HASH = "0123456789abcdef" * 4
HAND = StateSpace("hand", (Variable("x", "m", -0.9, 0.9), Variable("y", "m")))
STICK = StateSpace("joystick", (Variable("tilt", "rad", hidden=True), Variable("a", lower=-1.0), Variable("b")))
CAR = StateSpace(
    "car",
    (
        Variable("x", "px", role=Role("position", "screen", "x")),
        Variable("y", "px", role=Role("position", "screen", "y")),
        Variable("heading", "rad", -3.2, 3.2, "angle", Role("orientation", "screen", "z")),
    ),
)
GRAPH = InteractionGraph({"robot": HAND, "stick": STICK, "toy": CAR}, ["robot->stick", "stick->toy"])
NAMES = ("robot", "stick", "toy")
ESTIMATORS = {
    "polynomial": EstimatorSpec("polynomial", {"degree": 3, "alphas": (0.01, 1.0)}),
    "gaussian_process": EstimatorSpec("gaussian_process", {"degree": 1, "max_iter": 4}),
    "kernel": EstimatorSpec("kernel_ridge", {"gamma": None}),
    "trees": EstimatorSpec("extra_trees", {"n_estimators": 6}),
    "network": EstimatorSpec("mlp", {"hidden_layer_sizes": [6], "activation": "tanh", "max_iter": 15}),
    "neighbours": EstimatorSpec("nearest_neighbours", {"n_neighbors": 4}),
    "stacked": EstimatorSpec("GradientBoostingRegressor", {"n_estimators": 5, "random_state": 0}),
}


def piece(seed: int, n: int = 40) -> Demonstration:
    rng = np.random.default_rng(seed)
    hand = np.cumsum(rng.normal(size=(n, 2)), axis=0)
    stick = hand + 0.05 * rng.normal(size=(n, 2))
    heading = np.cumsum(0.3 * stick[:, 0])
    way = np.column_stack([np.cos(heading), np.sin(heading)]) * (1 + stick[:, 1:] ** 2)
    car = np.column_stack([np.cumsum(way, axis=0), (heading + np.pi) % (2 * np.pi) - np.pi])
    # The hand ends a tick off what it was told: there is a command map to learn.
    command = np.roll(hand, -1, axis=0) * 1.3 + 0.2
    table = {"time": np.arange(n) * TICK}
    for name, space, states in (("robot", HAND, hand), ("command", HAND, command), ("stick", STICK, stick)):
        table |= {f"{name}.{v}": states[:, i] for i, v in enumerate(space.observable.names)}
    table |= {f"toy.{v}": car[:, i] for i, v in enumerate(CAR.names)}
    return Demonstration(pd.DataFrame(table))


def learn(estimator: str = "polynomial", seed: int = 0, **options: object) -> LearnedChain:
    spec = ESTIMATORS[estimator]
    candidates = {"*": LinkCandidates((spec,), (spec,), forward_actions=("both",), aims=(1, 2))}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # few iterations on purpose
        return learn_chain([piece(seed)], GRAPH, "toy", ("x", "y"), candidates, {"stick->toy": 12.5}, **options)  # type: ignore[arg-type]


def assert_same(a: LearnedLink, b: LearnedLink, seed: int) -> None:
    """Every field but the source, and every prediction, bit by bit."""
    rng = np.random.default_rng(seed)
    n_child, n_parent = len(a.forward.model.child_space), len(a.forward.model.parent_space)
    child, before, after = (2 * rng.normal(size=(30, n)) for n in (n_child, n_parent, n_parent))
    assert (a.interaction, a.robot_seconds) == (b.interaction, b.robot_seconds)
    for name in ("child_limit", "child_scale", "parent_lower", "parent_upper", "parent_scale"):
        assert np.array_equal(getattr(a, name), getattr(b, name))
    assert len(a.inverses) == len(b.inverses)
    for mine, other in ((a.forward, b.forward), *zip(a.inverses, b.inverses, strict=True)):
        assert mine.spec == other.spec
        assert (mine.score, mine.samples) == (other.score, other.samples)
        assert np.array_equal(mine.residual_std, other.residual_std)
        assert mine.model.frozen.kind == other.model.frozen.kind
    assert np.array_equal(a.forward.model.predict(child, before, after), b.forward.model.predict(child, before, after))
    for x, y in zip(
        a.forward.model.linearize(child, before, after), b.forward.model.linearize(child, before, after), strict=True
    ):
        assert np.array_equal(x, y)
    assert np.array_equal(a.forward.model.spread(child, before, after), b.forward.model.spread(child, before, after))
    for row in zip(child, before, after, strict=True):
        assert np.array_equal(a.forward.model.predict_row(*row), b.forward.model.predict_row(*row))
    for mine, other in zip(a.inverses, b.inverses, strict=True):
        wanted = child[:, list(mine.model.targets)] + 0.1
        assert np.array_equal(mine.model(child, wanted), other.model(child, wanted))
        assert np.array_equal(mine.model(child[:1], wanted[:1]), other.model(child[:1], wanted[:1]))


@pytest.mark.parametrize("kind", ESTIMATORS)
@settings(max_examples=2, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_loaded_links_predict_the_same_to_the_last_bit(kind: str, seed: int) -> None:
    chain = learn(kind, seed)
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder)
        save_chain(chain, library, "a test", HASH)
        links = load_links(library, GRAPH, NAMES, ("x", "y"))
        command = load_command(library, GRAPH, NAMES)
        assert check_library(library) == []
    assert list(links) == ["robot->stick", "stick->toy"]
    assert kind in {link.forward.model.frozen.kind for link in links.values()}
    for link in chain.links:
        loaded = links[link.interaction.name]
        assert loaded.source == folder
        assert_same(link, loaded, seed)
    assert chain.command is not None and command is not None and command.map is not None
    rows = np.random.default_rng(seed).normal(size=(9, 2))
    assert np.array_equal(command.map.batch(rows), chain.command.batch(rows))
    assert np.array_equal(command.lower, chain.command_lower)
    assert np.array_equal(command.upper, chain.command_upper)
    assert np.array_equal(command.hand_limit, chain.hand_limit)


def test_loaded_links_are_taken_as_known(tmp_path: Path) -> None:
    first = learn()
    save_chain(first, tmp_path, "a test", HASH)
    again = learn("trees", 5, known=load_links(tmp_path, GRAPH, NAMES[:2], ("a", "b")))
    assert again.links[0].source == str(tmp_path)
    assert_same(first.links[0], again.links[0], 1)
    assert again.links[1].source == "demonstrations"
    assert again.links[1].forward.spec.estimator.name == "extra_trees"


def test_a_link_is_found_by_types_not_by_names(tmp_path: Path) -> None:
    save_chain(learn(), tmp_path, "a test", HASH)
    other = InteractionGraph(
        {"gripper": HAND, "lever": STICK, "lamp": StateSpace("lamp", (Variable("on"),))},
        ["gripper->lever", "lever->lamp"],
    )
    links = load_links(tmp_path, other, other.chain("lamp"), ("on",))
    assert list(links) == ["gripper->lever"]
    assert links["gripper->lever"].interaction == Interaction("gripper", "lever")
    nothing = InteractionGraph({"foot": StateSpace("foot", (Variable("x"),)), "toy": CAR}, ["foot->toy"])
    assert load_links(tmp_path, nothing, ("foot", "toy"), ("x", "y")) == {}
    assert load_command(tmp_path, nothing, ("foot", "toy")) is None


def test_other_bounds_fit_and_are_those_of_the_graph(tmp_path: Path) -> None:
    save_chain(learn(), tmp_path, "a test", HASH)
    wide = replace(HAND, variables=(Variable("x", "m", -5.0, 5.0), Variable("y", "m")))
    graph = InteractionGraph({"robot": wide, "stick": STICK}, ["robot->stick"])
    link, command = load_link(tmp_path / "hand-joystick", graph, graph.interactions[0], [0, 1])
    assert link.forward.model.parent_space.upper[0] == 5.0
    assert command is not None


def test_a_link_saved_alone_has_no_command(tmp_path: Path) -> None:
    link = learn().links[0]
    folder = save_link(link, tmp_path / "new" / "library", "a test", HASH)
    assert folder == tmp_path / "new" / "library" / "hand-joystick"
    loaded, command = load_link(folder, GRAPH, link.interaction, [0, 1])
    assert command is None
    assert_same(link, loaded, 0)


def test_saving_twice_gives_the_same_bytes_and_leaves_nothing_beside(tmp_path: Path) -> None:
    contents = []
    for seed in (1, 0, 0):  # the second replaces the first as a whole
        save_chain(learn("gaussian_process" if seed else "polynomial", seed), tmp_path, "a test", HASH)
        contents.append({f.relative_to(tmp_path): f.read_bytes() for f in tmp_path.rglob("*") if f.is_file()})
    assert contents[1] == contents[2] != contents[0]
    assert sorted(f.name for f in tmp_path.iterdir()) == ["hand-joystick", "joystick-car"]


def test_list_and_show(tmp_path: Path) -> None:
    chain = learn("kernel")
    save_chain(chain, tmp_path, "a test", HASH)
    (tmp_path / "README.md").write_text("for people")
    (tmp_path / ".git").mkdir()
    first, second = list_library(tmp_path)
    assert (first.name, second.name) == ("hand-joystick", "joystick-car")
    assert show_link(tmp_path, "joystick-car") == second
    assert second.parent == "joystick: a [1], b [1]"
    assert second.child == "car: x [px], y [px], heading [rad]"
    assert (second.interaction, second.source, second.targets) == ("stick->toy", "a test", ("x", "y"))
    assert second.forward.startswith("kernel_ridge(gamma=None), features")
    assert len(second.inverses) == len(chain.links[1].inverses)
    assert second.forward_score == chain.links[1].forward.score
    assert second.inverse_score == chain.links[1].best_inverse.score
    assert (second.samples, second.robot_seconds) == (39, 12.5)
    assert set(second.versions) == {"python", "drake", "scikit-learn", "numpy", "ichain_drake"}
    assert second.demonstrations_sha256 == HASH
    assert second.size == sum(f.stat().st_size for f in (tmp_path / "joystick-car").iterdir())
    assert list_library(tmp_path / ".git") == check_library(tmp_path / ".git") == []


def test_add_a_library_and_a_link(tmp_path: Path) -> None:
    old, new, third = (tmp_path / name for name in ("old", "new", "third"))
    save_chain(learn(seed=0), old, "old", HASH)
    save_chain(learn(seed=1), new, "new", HASH)
    assert add_to_library(old / "joystick-car", third) == ["joystick-car"]
    assert add_to_library(new, third) == ["hand-joystick", "joystick-car"]
    assert [link.source for link in list_library(third)] == ["new", "new"]
    add_to_library(old / "hand-joystick", third)
    assert [link.source for link in list_library(third)] == ["old", "new"]
    assert check_library(third) == []
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="empty: holds no saved link"):
        add_to_library(tmp_path / "empty", third)


def test_add_is_all_or_nothing(tmp_path: Path) -> None:
    save_chain(learn(), tmp_path / "bad", "a test", HASH)
    (tmp_path / "bad" / "joystick-car" / "forward.npz").write_bytes(b"")
    with pytest.raises(InputError, match="forward.npz: its sha256"):
        add_to_library(tmp_path / "bad", tmp_path / "library")
    assert not (tmp_path / "library").exists()


def test_a_reused_link_keeps_its_origin(tmp_path: Path) -> None:
    driving, ship = tmp_path / "driving", tmp_path / "ship"
    save_chain(learn(seed=0), driving, "driving", HASH)
    known = load_links(driving, GRAPH, NAMES[:2], ("a", "b"))
    mixed = learn(seed=3, known=known)
    other_hash = "f" * 64
    save_chain(mixed, ship, "ship", other_hash)
    assert [(s.source, s.demonstrations_sha256) for s in list_library(ship)] == [
        ("driving", HASH),
        ("ship", other_hash),
    ]
    # Into the library that it came from: only what was learned anew is replaced.
    before = (driving / "hand-joystick").stat().st_ino
    save_chain(mixed, driving, "ship", other_hash)
    assert [s.source for s in list_library(driving)] == ["driving", "ship"]
    assert (driving / "hand-joystick").stat().st_ino == before
    (driving / "hand-joystick").rename(tmp_path / "gone")
    with pytest.raises(
        InputError, match="link hand-joystick: the library that it came from, .*driving, doesn't have it"
    ):
        save_chain(mixed, ship, "ship", other_hash)


@given(st.tuples(st.text(min_size=1), st.text(min_size=1)), st.tuples(st.text(min_size=1), st.text(min_size=1)))
def test_names_are_safe_and_differ(a: tuple[str, str], b: tuple[str, str]) -> None:
    assert (link_name(*a) == link_name(*b)) == (a == b)
    assert set(link_name(*a)) <= set("%-_abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789")


words = st.text(st.characters(exclude_characters="."), min_size=1, max_size=8).filter(lambda w: "->" not in w)
variables = st.builds(
    Variable,
    words,
    st.text(max_size=4),
    st.floats(max_value=0.0, allow_nan=False),
    st.floats(min_value=0.0, allow_nan=False),
    st.sampled_from(["real", "binary", "integer"]),  # the model's inputs have no angle
    st.none() | st.builds(Role, st.sampled_from(["position", "orientation", "amount", "level"]), words, words),
)
spaces = st.builds(
    lambda name, items: (name, items), words, st.tuples(variables, variables).filter(lambda v: v[0].name != v[1].name)
)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(parent=spaces, child=spaces)
def test_any_names_units_kinds_and_roles_survive(parent: tuple, child: tuple) -> None:
    def respaced(link: LearnedLink, hand: StateSpace, stick: StateSpace) -> LearnedLink:
        change: Callable = lambda scored: replace(  # noqa: E731
            scored, model=replace(scored.model, child_space=stick, parent_space=hand)
        )
        return replace(link, forward=change(link.forward), inverses=tuple(change(i) for i in link.inverses))

    spaces = StateSpace(*parent), StateSpace(*child)
    graph = InteractionGraph(dict(zip("pc", spaces, strict=True)), ["p->c"])
    with tempfile.TemporaryDirectory() as folder:
        saved = save_link(respaced(RAW, *spaces), Path(folder), "a test", HASH)
        assert saved.parent == Path(folder)
        link, _ = load_link(saved, graph, graph.interactions[0], [0, 1])
        assert check_library(Path(folder)) == []
    assert np.array_equal(link.child_scale, RAW.child_scale)


def _raw_link() -> LearnedLink:
    """A link of plain variables: its models don't depend on roles or kinds."""
    link = learn().links[0]
    assert link.forward.spec.features in {"none", "raw"}
    return link


RAW = _raw_link()

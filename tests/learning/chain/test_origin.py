"""What is moved with its declared frame needs no new sample: links are learned relative to the child's origin."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ichain_drake.control.tracking.move_to import RobotLevel
from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph, Origin
from ichain_drake.learning.chain.chain import LearnedChain, LinkCandidates, learn_chain
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.library import load_command, load_links, save_chain, show_link
from ichain_drake.learning.library.files import MANIFEST, sha256
from ichain_drake.state import Role, StateSpace, Variable
from ichain_drake.timing import TICK

ARM = StateSpace(
    "arm", (Variable("u", "m", role=Role("position", "floor", "y")), Variable("turn", "rad", -4, 4, "angle"))
)
PEDAL = StateSpace("pedal", (Variable("p"),))
NAMES = ("left", "foot")
HERE, THERE = Origin("floor", (9.0, 0.3, 0.0)), Origin("floor", (7.0, -0.2, 1.0))


def graph(origin: Origin | None) -> InteractionGraph:
    return InteractionGraph({"left": ARM, "foot": PEDAL}, ["left->foot"], {} if origin is None else {"foot": origin})


def learn(origin: Origin | None, at: float, degree: int = 2) -> LearnedChain:
    """The pedal is a crooked function of how far the arm is from it; the arm falls short of what it is told."""
    rng = np.random.default_rng(3)
    told = at + rng.uniform(-0.1, 0.1, 60)
    reached = np.concatenate([[at], at + 0.8 * (told[:-1] - at)])
    turn = rng.uniform(-1, 1, 60)
    table = {
        "time": TICK * np.arange(60),
        "left.u": reached,
        "left.turn": turn,
        "command.u": told,
        "command.turn": np.roll(turn, -1),
        "foot.p": 5.0 * (reached - at) + 20.0 * (reached - at) ** 2 + 0.1 * np.cos(turn),
    }
    spec = EstimatorSpec("polynomial", {"degree": degree})
    candidates = {"*": LinkCandidates((spec,), (spec,), features=("none",), forward_actions=("next",))}
    return learn_chain([Demonstration(pd.DataFrame(table))], graph(origin), "foot", ("p",), candidates)


def test_a_moved_child_is_predicted_and_commanded_from_saved_models(tmp_path: Path) -> None:
    save_chain(learn(HERE, 0.3), tmp_path, "a test", "0" * 64)
    moved = graph(THERE)
    link = load_links(tmp_path, moved, NAMES, ("p",))["left->foot"]
    command = load_command(tmp_path, moved, NAMES)
    fresh = learn(THERE, -0.2)
    before, after = np.array([[-0.2, 0.0]]), np.array([[-0.15, 0.4]])
    none = np.zeros((1, 1))
    new = fresh.links[0]
    np.testing.assert_allclose(
        link.forward.model.predict(none, before, after), new.forward.model.predict(none, before, after), atol=1e-9
    )
    for mine, other in zip(
        link.forward.model.linearize(none, before, after),
        new.forward.model.linearize(none, before, after),
        strict=True,
    ):
        np.testing.assert_allclose(mine, other, atol=1e-7)
    wanted = np.array([[0.3]])
    np.testing.assert_allclose(link.inverses[0].model(none, wanted), new.inverses[0].model(none, wanted), atol=1e-9)
    np.testing.assert_allclose([link.parent_lower, link.parent_upper], [new.parent_lower, new.parent_upper], atol=1e-12)
    assert command is not None and command.map is not None
    limit = np.full(2, 0.5)
    robot = RobotLevel(ARM, limit, command.map, command.lower, command.upper, command.origin)
    told = robot.decide(np.array([[-0.2, 0.0]]), np.array([[-0.16, 0.1]]))
    np.testing.assert_allclose(told, [[-0.15, 0.1]], atol=1e-6)  # it falls short by a fifth
    two = robot.decide(np.tile([-0.2, 0.0], (2, 1)), np.tile([-0.16, 0.1], (2, 1)))
    np.testing.assert_allclose(two, np.tile(told, (2, 1)), atol=1e-12)


def test_models_are_the_same_wherever_they_are_learned() -> None:
    here, there = learn(HERE, 0.3).links[0], learn(THERE, -0.2).links[0]
    rows = np.array([[0.05, 1.0, 0.0]])
    np.testing.assert_allclose(
        here.forward.model.frozen.batch(rows), there.forward.model.frozen.batch(rows), rtol=1e-6, atol=1e-9
    )
    assert here.forward.score == pytest.approx(there.forward.score)
    np.testing.assert_allclose(here.parent_upper - there.parent_upper, [0.5, 0.0], atol=1e-12)


def test_unmoved_it_loads_to_the_last_bit(tmp_path: Path) -> None:
    chain = learn(HERE, 0.3)
    save_chain(chain, tmp_path, "a test", "0" * 64)
    link = load_links(tmp_path, graph(HERE), NAMES, ("p",))["left->foot"]
    saved, rows = chain.links[0], np.random.default_rng(0).uniform(-1, 1, (20, 2))
    none = np.zeros((20, 1))
    assert np.array_equal(link.forward.model.predict(none, rows, rows), saved.forward.model.predict(none, rows, rows))
    assert np.array_equal(link.inverses[0].model(none, none), saved.inverses[0].model(none, none))
    assert np.array_equal(link.parent_upper, saved.parent_upper)
    assert "declared origin in frame 'floor', then at 9, 0.3, 0" in show_link(tmp_path, "arm-pedal").positions


@pytest.mark.parametrize(
    ("learned", "used", "match"),
    [
        (None, HERE, "origin: .* in the library none is declared, here it is in frame 'floor'; learn this link anew"),
        (HERE, None, "origin: .* in the library it is in frame 'floor', here none is declared"),
    ],
)
def test_relative_and_plain_positions_are_not_mixed_up(
    tmp_path: Path, learned: Origin | None, used: Origin | None, match: str
) -> None:
    save_chain(learn(learned, 0.3), tmp_path, "a test", "0" * 64)
    with pytest.raises(InputError, match=match):
        load_links(tmp_path, graph(used), NAMES, ("p",))
    with pytest.raises(InputError, match=match):
        load_command(tmp_path, graph(used), NAMES)


@pytest.mark.parametrize(
    ("origin", "match"),
    [
        ({"frame": "ceiling", "position": [0.0, 0.0, 0.0]}, "origin.frame: arm has no position in frame 'ceiling'"),
        ({"frame": "floor", "position": [0.0]}, r"origin: an origin in frame 'floor' is at \(0.0,\)"),
    ],
)
def test_an_origin_that_can_not_be_is_refused(tmp_path: Path, origin: dict[str, object], match: str) -> None:
    save_chain(learn(HERE, 0.3), tmp_path, "a test", "0" * 64)
    file = tmp_path / "arm-pedal" / MANIFEST
    manifest = json.loads(file.read_text())
    manifest["origin"] = origin
    manifest["checksums"]["origin"] = sha256(json.dumps(origin, sort_keys=True).encode())
    file.write_text(json.dumps(manifest))
    with pytest.raises(InputError, match=match):
        load_links(tmp_path, graph(HERE), NAMES, ("p",))


def test_origins_are_checked_by_the_graph() -> None:
    edge = graph(HERE).interactions[0]
    assert graph(HERE).origin_for(edge) == HERE
    assert graph(None).origin_for(edge) is None
    np.testing.assert_array_equal(HERE.offset(ARM), [0.3, 0.0])
    with pytest.raises(InputError, match="origin of foot: none of its parents has a position in frame 'wall'"):
        graph(Origin("wall", (0.0, 0.0, 0.0)))
    with pytest.raises(InputError, match="there is no object 'hat'"):
        InteractionGraph({"left": ARM, "foot": PEDAL}, ["left->foot"], {"hat": HERE})
    with pytest.raises(InputError, match="give x, y, z in metres"):
        Origin("floor", (0.0, float("nan"), 0.0))

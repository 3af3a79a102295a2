"""Learning a whole chain: the right view of each child, limits, commands, and links that are already known."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.chain import LinkCandidates, _most_likely, learn_chain, learn_link, replace_samples
from ichain_drake.learning.chain.command import learn_command
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.state import StateSpace, Variable, wrap_angle
from ichain_drake.timing import TICK

ROBOT = StateSpace("robot", (Variable("p", "m"), Variable("turn", "rad", kind="angle")))
LEVER = StateSpace("lever", (Variable("tilt"),))
CART = StateSpace("cart", (Variable("place"), Variable("speed")))
GRAPH = InteractionGraph({"hand": ROBOT, "lever": LEVER, "cart": CART}, ["hand->lever", "lever->cart"])
TO_LEVER, TO_CART = GRAPH.interactions
DEGREE_2 = (EstimatorSpec("polynomial", {"degree": 2}),)
CANDIDATES = {"*": LinkCandidates(DEGREE_2, DEGREE_2)}


def demonstrate(
    rows: int = 150, seed: int = 0, p: float = 0.0, turn: float = 3.1, commands: bool = True
) -> Demonstration:
    """The lever mirrors the hand; the cart is pushed by the lever. The hand stays around p and a turn near +-pi."""
    rng = np.random.default_rng(seed)
    hand = np.stack([p + rng.uniform(-0.1, 0.1, rows), wrap_angle(turn + rng.uniform(-0.1, 0.1, rows))], axis=1)
    lever = 3.0 * (hand[:, 0] - p) + 2.0 * (hand[:, 0] - p) ** 2 + 0.002 * rng.standard_normal(rows)
    cart = np.zeros((rows, 2))
    for k in range(1, rows):
        speed = 0.8 * cart[k - 1, 1] + lever[k] + 0.001 * rng.standard_normal()
        cart[k] = cart[k - 1, 0] + speed, speed
    data = {"time": TICK * np.arange(rows), "hand.p": hand[:, 0], "hand.turn": hand[:, 1], "lever.tilt": lever}
    data |= {"cart.place": cart[:, 0], "cart.speed": cart[:, 1]}
    if commands:
        after = np.roll(hand, -1, axis=0)
        data |= {"command.p": (after[:, 0] - 0.01) / 0.9, "command.turn": after[:, 1]}
    return Demonstration(pd.DataFrame(data), name=f"piece{seed}")


def test_a_child_that_mirrors_its_parent_is_learned_without_its_own_state() -> None:
    lever = learn_link([demonstrate()], GRAPH, TO_LEVER, CANDIDATES["*"], [0])
    assert lever.is_static
    assert {s.spec.features for s in lever.inverses} == {"none"}
    assert lever.best_inverse.score > 0.45  # p is determined, the turn plays no part
    assert lever.forward.residual_std[0] == pytest.approx(0.002, rel=0.2)


def test_a_child_with_a_life_of_its_own_is_learned_with_its_state() -> None:
    cart = learn_link([demonstrate()], GRAPH, TO_CART, CANDIDATES["*"], [0])
    assert not cart.is_static
    assert cart.forward.spec.features == "raw"
    assert {s.spec.features for s in cart.inverses} == {"raw"}
    assert cart.best_inverse.score > 0.99


def test_scales_and_ranges_are_those_of_the_demonstrations() -> None:
    piece = demonstrate()
    link = learn_link([piece], GRAPH, TO_CART, CANDIDATES["*"], [0])
    change = np.abs(np.diff(piece.states("cart", CART), axis=0))
    np.testing.assert_allclose(link.child_limit, change.max(axis=0))
    np.testing.assert_allclose(link.child_scale, np.median(change, axis=0))
    lever = piece.table["lever.tilt"][1:]
    assert (link.parent_lower[0], link.parent_upper[0]) == (lever.min(), lever.max())


def test_all_links_of_a_chain_robot_first() -> None:
    said: list[str] = []
    chain = learn_chain([demonstrate()], GRAPH, "cart", ["place"], CANDIDATES, {"hand->lever": 50.0}, said.append)
    assert chain.names == ("hand", "lever", "cart")
    assert said == ["learning hand->lever", "learning lever->cart"]
    assert [link.robot_seconds for link in chain.links] == [50.0, 0.0]
    assert chain.targets == (0,)
    assert chain.links[1].best_inverse.model.targets == (0,)
    assert len(chain.validation) == 1


def test_the_hands_step_is_taken_within_pieces_and_the_short_way_round() -> None:
    """Two pieces 5 m apart, in each the hand turns to and fro over +-pi."""
    pieces = [demonstrate(seed=0), demonstrate(seed=1, p=5.0)]
    limit = learn_chain(pieces, GRAPH, "lever", ["tilt"], CANDIDATES).hand_limit
    assert (limit > 0.1).all()
    assert (limit <= 0.2).all()


def test_a_hand_that_is_systematically_off_gets_a_learned_command() -> None:
    states = np.random.default_rng(0).uniform(-1, 1, (60, 2))
    commands = (states - [0.01, -0.02]) / 0.9
    model = learn_command(commands, states)
    assert model is not None
    np.testing.assert_allclose(model.batch(states), commands, atol=1e-4)


def test_a_hand_that_goes_where_it_is_told_gets_none() -> None:
    states = np.random.default_rng(0).uniform(-1, 1, (60, 2))
    assert learn_command(states, states) is None


def test_without_recorded_commands_the_hands_range_is_used() -> None:
    chain = learn_chain([demonstrate(commands=False)], GRAPH, "lever", ["tilt"], CANDIDATES)
    assert chain.command is None
    np.testing.assert_array_equal(chain.command_lower, chain.links[0].parent_lower)


def test_a_known_link_is_taken_as_it_is() -> None:
    known = learn_link([demonstrate(seed=1)], GRAPH, TO_LEVER, CANDIDATES["*"], [0])
    chain = learn_chain([demonstrate()], GRAPH, "cart", ["place"], CANDIDATES, known={"hand->lever": known})
    assert chain.links[0] is known


def test_the_number_of_transitions_can_be_limited() -> None:
    chain = learn_chain([demonstrate()], GRAPH, "cart", ["place"], replace_samples(CANDIDATES, 60))
    assert [link.forward.samples for link in chain.links] == [60, 60]


def test_learning_is_deterministic() -> None:
    first, second = (learn_chain([demonstrate()], GRAPH, "cart", ["place"], CANDIDATES) for _ in range(2))
    for one, two in zip(first.links, second.links, strict=True):
        for name, array in one.forward.model.frozen.arrays().items():
            np.testing.assert_array_equal(array, two.forward.model.frozen.arrays()[name])


def test_what_can_not_be_learned_is_named() -> None:
    few = [demonstrate(rows=12)]
    steep = {"*": LinkCandidates((EstimatorSpec("polynomial", {"degree": 5}),), DEGREE_2)}
    with pytest.raises(InputError, match="^hand->lever, forward model: .*n_samples = 11 for degree 5"):
        learn_chain(few, GRAPH, "cart", ["place"], steep)
    with pytest.raises(InputError, match="lever->cart: no candidate for the inverse model"):
        learn_chain([demonstrate()], GRAPH, "cart", ["place"], CANDIDATES | {"lever->cart": LinkCandidates(inverse=())})
    lone = Demonstration(demonstrate().table.drop(columns=["lever.tilt"]))
    with pytest.raises(InputError, match="hand->lever: no demonstration holds hand and lever"):
        learn_chain([lone], GRAPH, "cart", ["place"], CANDIDATES)
    with pytest.raises(InputError, match="cart has no variable 'colour'"):
        learn_chain([demonstrate()], GRAPH, "cart", ["colour"], CANDIDATES)
    with pytest.raises(InputError, match="hand is the robot itself"):
        learn_chain([demonstrate()], GRAPH, "hand", ["p"], CANDIDATES)


def test_a_candidate_that_fails_does_not_spoil_the_others() -> None:
    mixed = (EstimatorSpec("polynomial", {"degree": 9}), *DEGREE_2)
    link = learn_link([demonstrate(rows=40)], GRAPH, TO_CART, LinkCandidates(mixed, mixed), [0])
    assert str(link.forward.spec).startswith("polynomial(degree=2)")


def test_a_hand_that_is_off_as_much_one_way_as_the_other_gets_a_learned_command_too() -> None:
    states = np.random.default_rng(0).uniform(-1.0, 1.0, (60, 2))
    states -= states.mean(axis=0)
    found = learn_command(1.1 * states, states)
    assert found is not None
    np.testing.assert_allclose(found.batch(np.array([[0.5, 0.2]])), [[0.55, 0.22]], atol=1e-6)
    assert learn_command(states, states) is None


@pytest.mark.parametrize("unit", [1.0, 1e-4, 1e4])
def test_a_candidate_is_chosen_by_the_shares_of_its_residuals_whatever_the_unit(unit: float) -> None:
    """Half as much in one variable outweighs a third more in another that is far larger; a tie goes to the first."""
    fitted = [SimpleNamespace(residual_std=unit * np.array(r)) for r in ([0.3, 0.004], [0.4, 0.002], [0.4, 0.001995])]
    assert _most_likely(fitted) is fitted[1]  # type: ignore[arg-type, comparison-overlap]
    assert _most_likely(fitted[::2]) is fitted[2]  # type: ignore[arg-type, comparison-overlap]
    assert _most_likely(fitted[:1]) is fitted[0]  # type: ignore[arg-type, comparison-overlap]

"""What goes back to a value by itself, and what keeps its own."""

import numpy as np
import pytest

from ichain_drake.learning.discovery.log import RawPiece, make_log
from ichain_drake.learning.discovery.passive_kind import constant_values
from ichain_drake.state import Role, StateSpace, Variable


@pytest.mark.filterwarnings("ignore:Mean of empty slice", "ignore:invalid value")  # of a hand that stands still
@pytest.mark.parametrize("back", [False, True])
def test_what_goes_back_within_a_tick_has_a_rest_value_and_what_differs_from_piece_to_piece_has_none(
    back: bool,
) -> None:
    """Pieces of two rows: in one half of them it is off its rest, for both rows or for one."""
    spaces = {
        "hand": StateSpace("hand", (Variable("x"),)),
        "can": StateSpace("can", (Variable("a", role=Role("amount")),)),
    }
    pieces = []
    for k in range(41):
        off = float(k % 2)
        level = np.array([[off], [0.0 if back else off]])
        pieces.append(RawPiece(f"p{k}", {"hand": np.zeros((2, 1)), "can": level}))
    log = make_log(pieces, spaces, "hand", {})
    log.noise["can"][:] = 1e-3
    found = constant_values(log, "can", ("hand",))
    assert found == {0: 0.0 if back else None}

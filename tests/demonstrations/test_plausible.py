"""Values far beyond their bounds are named, with the unit that they are likely in."""

import numpy as np
import pandas as pd
import pytest

from ichain_drake.demonstrations import Demonstration
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.state import StateSpace, Variable
from ichain_drake.timing import TICK

GRAPH = InteractionGraph(
    {
        "arm": StateSpace("arm", (Variable("x", "m", 0.2, 0.8), Variable("stick", "1", -1, 1))),
        "kart": StateSpace("kart", (Variable("place", "px"), Variable("h", "rad", -np.pi, np.pi, "angle"))),
    },
    ["arm->kart"],
)
N = 30
T = np.arange(N)
GOOD = {
    "time": TICK * T, "arm.x": 0.5 + 0.3 * np.sin(T), "arm.stick": np.sin(T), "kart.place": 10.0 * T,
    "kart.h": (0.4 * T + 2) % (2 * np.pi) - np.pi,
}  # fmt: skip


def check(**changed: object) -> None:
    Demonstration(pd.DataFrame(GOOD | changed), {}, "push.csv").check(GRAPH)


def test_what_people_measure_is_plausible() -> None:
    check()
    check(**{"arm.stick": 1.3 * np.sin(T)})  # a stick that reads beyond its bound
    check(**{"kart.h": 0.4 * T})  # an angle that doesn't wrap
    check(**{"kart.h": (0.4 * T) % (2 * np.pi)})  # one that wraps elsewhere


@pytest.mark.parametrize(
    ("column", "values", "message"),
    [
        ("kart.h", (20.0 * T) % 360, r"an angle is in radians.*is it in deg\? .*kart\.h \[deg\]"),
        ("kart.h", np.full(N, 90.0), "90 rad given, and an angle is in radians.*is it in deg"),
        ("arm.stick", 50 * np.sin(T), "its bounds are -1 to 1; is it in %"),
        ("arm.stick", 32767 * np.sin(T), "is it a 16-bit integer"),
        ("arm.x", 1e3 * GOOD["arm.x"], r"500 m given, and its bounds are 0\.2 to 0\.8; is it in mm"),
        ("arm.x", 1e2 * GOOD["arm.x"], "is it in cm"),
        ("arm.x", GOOD["arm.x"] + 4000.0, "mend or remove it"),
        ("kart.place", np.where(T == 4, 1e12, 0.0), r"line 6, column kart\.place: 1e\+12 px given, and no reading is"),
        ("kart.place", np.where(T == 4, -1e300, 0.0), "line 6.*no reading is that large"),
    ],
)
def test_far_beyond_the_bounds(column: str, values: np.ndarray, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        check(**{column: values})
    assert str(caught.value).startswith("push.csv: line ")
    assert "\n" not in str(caught.value)


def test_an_angle_is_declared_in_radians() -> None:
    with pytest.raises(
        InputError, match=r"variable h: an angle wraps at .*can't be in deg; declare Variable\('h', 'rad'"
    ):
        Variable("h", "deg", -180, 180, kind="angle")

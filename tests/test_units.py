"""Units: converted where there is a way, refused where there is none, and nothing is worked out that is no unit."""

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.units import convert, split_unit


@pytest.mark.parametrize(
    ("unit", "wanted", "factor"),
    [
        ("m", "m", 1), ("mm", "m", 1e-3), ("deg", "rad", np.pi / 180), ("°/s", "rad/s", np.pi / 180),
        ("rpm", "rad/s", np.pi / 30), ("km/h", "m/s", 1 / 3.6), ("%", "1", 0.01), ("ms", "s", 1e-3),
        ("1/s", "Hz", 1), ("m/s^2", "mm/s**2", 1e3), ("pixels", "px", 1), ("px/ms", "px/s", 1e3),
    ],
)  # fmt: skip
def test_there_is_a_way(unit: str, wanted: str, factor: float) -> None:
    np.testing.assert_allclose(convert(np.array([2.0, -3.0]), unit, wanted), factor * np.array([2.0, -3.0]))


@pytest.mark.parametrize(
    ("unit", "wanted"),
    [("px", "m"), ("m", "px"), ("rad", "1"), ("deg", "1"), ("kg", "m"), ("1", "m"), ("Hz", "rad/s"), ("foo", "m"),
     ("", "m"), ("9**9**9**9", "m"), ("m" * 50, "m"), ("m; import os", "m"), ("__import__", "m")],
)  # fmt: skip
def test_there_is_none(unit: str, wanted: str) -> None:
    with pytest.raises(InputError):
        convert(np.array([2.0]), unit, wanted)


def test_temperatures_have_an_offset() -> None:
    assert convert(np.array([20.0]), "degC", "K") == pytest.approx([293.15])


def test_headers() -> None:
    assert split_unit("car.x [px]") == ("car.x", "px")
    assert split_unit(" h (deg) ".strip()) == ("h", "deg")
    assert split_unit(" plain ") == ("plain", None)
    assert split_unit("[px]") == ("[px]", None)

"""Which paths a run follows: by name, or from a file, each checked before any work."""

from pathlib import Path

import numpy as np
import pytest

from ichain_drake.errors import InputError
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.systems import load_scenario

SCENARIO = load_scenario("car_game", (), "ideal", 0)


def csv(folder: Path, points: list[tuple[float, float]]) -> Path:
    file = folder / "mine.csv"
    file.write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in points))
    return file


def test_reference_paths_are_all_or_those_named_in_that_order() -> None:
    every = list(SCENARIO.reference_paths())
    assert list(choose_paths(SCENARIO)) == every
    assert list(choose_paths(SCENARIO, [every[1], every[0]])) == [every[1], every[0]]
    with pytest.raises(InputError, match=f"car_game has no path 'nix'; it has {every[0]}"):
        choose_paths(SCENARIO, ["nix"])


def test_a_path_of_a_file_is_called_after_it_and_followed_as_it_is(tmp_path: Path) -> None:
    (found,) = choose_paths(SCENARIO, file=csv(tmp_path, [(100, 100), (400, 100), (400, 300)])).items()
    assert found[0] == "mine"
    np.testing.assert_allclose(found[1].points[[0, -1]], [[100, 100], [400, 300]])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([(100, 100), (900, 100)], r"line 3: \(900, 100\) px is outside the screen of 800 x 600 px"),
        ([(-1, 100), (400, 100)], r"line 2: \(-1, 100\) px is outside"),
        ([(100, 100), (100, 601)], r"line 3: \(100, 601\) px is outside"),
        ([(100, 100), (101, 100)], r"it is 1 px long; an end counts as reached within"),
    ],
)
def test_a_path_that_can_not_be_followed_is_refused(tmp_path: Path, points: list, message: str) -> None:
    with pytest.raises(InputError, match=message):
        choose_paths(SCENARIO, file=csv(tmp_path, points))


def test_the_screen_s_border_is_on_it(tmp_path: Path) -> None:
    (path,) = choose_paths(SCENARIO, file=csv(tmp_path, [(0, 0), (800, 0), (800, 600)])).values()
    assert path.points.max() == 800


def test_so_many_points_that_they_fill_the_memory_are_refused() -> None:
    fine = load_scenario("car_game", ["path.spacing=0.000001"], "ideal", 0)
    with pytest.raises(InputError, match="at a spacing of 1e-06 are over .* points; give a larger spacing"):
        choose_paths(fine)

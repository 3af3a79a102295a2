"""The second game with the joystick: its numbers, paths and one short run."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from ichain_drake.cli.main import main
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.systems import load_scenario
from ichain_drake.systems.hover_game.scenario import HoverGame
from ichain_drake.visualization.sprites import hovercraft_sprite


def game(*settings: str, seed: int = 0) -> HoverGame:
    scenario = load_scenario("hover_game", settings, "ideal", seed)
    assert isinstance(scenario, HoverGame)
    return scenario


def test_paths_are_on_the_screen_and_no_tighter_than_it_can_go() -> None:
    for path in choose_paths(game()).values():
        assert (path.points > 40).all()
        assert (path.points < np.array([760, 560])).all()
        assert path.speed.min() > 30


def test_a_run_starts_on_its_path_with_the_fan_running() -> None:
    scenario = game()
    path = choose_paths(scenario, ["waves"])["waves"]
    world = scenario.make_world(path, 0)
    state = world.objects["hovercraft"].get_state(world.objects["hovercraft"].CreateDefaultContext())
    assert np.hypot(*(state[:2] - path.points[0])) < 5
    assert state[2] == pytest.approx(path.direction[0])
    assert state[3] == pytest.approx(path.speed[0])
    assert state[6] > 0.2


def test_the_driver_shows_bends_and_slides_without_the_arm() -> None:
    (drive,) = game("learning.samples=200").record_demonstrations(known={"hand->joystick"})
    table = drive.table
    assert set(table.columns).isdisjoint({"hand.x", "hovercraft.fan"})
    assert table["hovercraft.ahead"].max() > 45
    assert table["hovercraft.aside"].abs().max() > 10
    assert np.ptp(table[["hovercraft.x", "hovercraft.y"]].to_numpy(), axis=0).min() > 200


def test_a_short_run_with_its_picture(tmp_path: Path) -> None:
    a = np.linspace(0.0, np.pi / 2, 200)
    pd.DataFrame({"x": 250 + 200 * np.sin(a), "y": 400 - 200 * (1 - np.cos(a))}).to_csv(tmp_path / "b.csv", index=False)
    settings = ["--set", "learning.samples=250", "--set", "control.efforts=[0.05]"]
    more = ["--physics", "ideal", "--path", str(tmp_path / "b.csv"), "-o", str(tmp_path), "--oracle", *settings]
    assert main(["run", "hover_game", *more]) == 0
    metrics = json.loads((tmp_path / "report.json").read_text())["metrics"]
    assert metrics["completed"]
    assert metrics["mean_error_px"] < 2 * metrics["oracle_error_px"]
    assert (tmp_path / "playback.html").stat().st_size > 100_000


def test_its_picture_is_its_own_and_fades() -> None:
    picture = np.asarray(hovercraft_sprite())
    assert picture.shape == (120, 180, 4)
    assert picture[0, 0, 3] < 20
    red, green, blue, alpha = (int(v) for v in picture[60, 150])  # the bow's deck
    assert green > max(red, blue)
    assert alpha == 255
    assert np.asarray(hovercraft_sprite(opacity=0.5))[60, 150, 3] == pytest.approx(128, abs=2)

"""Playbacks of real scenarios in a real browser: after any seek, scene and panel are what was logged."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from ichain_drake.control.execution.tasks import Mode
from ichain_drake.control.planning.plan import Condition, Goal
from ichain_drake.objects.drawings.dispenser import water_color
from ichain_drake.runs.goals.output import write_graph_recording
from ichain_drake.runs.goals.run import GraphRun
from ichain_drake.runs.paths.choice import choose_paths
from ichain_drake.runs.paths.output import write_recording
from ichain_drake.runs.paths.result import PathResult, PathRun
from ichain_drake.simulation.commands import Commands
from ichain_drake.simulation.episode import Episode
from ichain_drake.systems.car_game.scenario import CarGame
from ichain_drake.systems.water_dispenser.layout import LAYOUT
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser
from ichain_drake.systems.water_dispenser.teleoperation import Teleoperation

QUIET = ("noise.scale=0",)
PANEL = """
const panel = document.getElementById('ichain-panel');
const strips = [...panel.querySelectorAll('.strip')].filter(s => s.style.display !== 'none');
return {
  lit: [...panel.querySelectorAll('.edge.on')].map(e => e.dataset.edge).sort(),
  edges: panel.querySelectorAll('.edge').length,
  strips: Object.fromEntries(strips.map(s => [s.querySelector('.label').textContent, {
    value: s.querySelector('.value').textContent, met: s.classList.contains('met'),
    cursor: Number(s.querySelector('.cursor').getAttribute('x1')) / 240,
    drawn: s.querySelector('.line').getAttribute('d').length,
  }])),
}"""


def logged(scenario, world, commands):
    episode = Episode(world, Commands(commands))
    episode.run(len(commands))
    return episode.log()


def between(values, time):
    """Linear interpolation of logged rows, as the page does it."""
    k = math.floor(time * 30)
    return values[k] + (time * 30 - k) * (values[k + 1] - values[k])


def turned(node):
    x, y, z, w = node["quaternion"]
    return RotationMatrix(Quaternion(np.array([w, x, y, z]) / np.linalg.norm(node["quaternion"])))


def angle(a, b):
    return abs(float((a.inverse() @ b).ToAngleAxis().angle()))


def read_out(browser):
    lines = [line.split("\t") for line in browser.hud().splitlines()]
    return {line[0]: line[1].strip() for line in lines if len(line) > 1}


@pytest.fixture(scope="module")
def water():
    """A run in which water is poured and put below the outlet, and both buttons are pressed."""
    scenario = WaterDispenser(QUIET, "ideal")
    start = dataclasses.replace(scenario.start(0), water=0.8, temperature=0.1, tank_amount=0.3, tank_temperature=0.7)
    hand = Teleoperation(start.hand).fetch(start.cup).carry_over_inlet().tilt(-1.3).wait(3).tilt(0.0)
    hand.to(0.59, -0.05).to(0.585, 0.06, 0.10).to(z=0.082).to(0.68).put(0.68, 0.06, LAYOUT.tray.height)
    hand.turn(0.0).grip(True).to(*LAYOUT.power[:2], 0.12).press(LAYOUT.power, 6.0).wait(8).press(LAYOUT.power, -20.0)
    hand.to(*LAYOUT.dispense[:2]).press(LAYOUT.dispense, 6.0).wait(5).press(LAYOUT.dispense, -20.0)
    log = logged(scenario, scenario.build_world(start, 0), hand.commands)
    n, edges = len(log.times), scenario.graph.interactions
    run = GraphRun(scenario, ("cup.water >= 0.5",), log=log)
    run.goal = Goal((Condition("cup", "water", 0.5, math.inf), Condition("tank", "amount", 0.2, 0.6)), (edges[0],))
    half = np.arange(n) < n // 2
    run.doing = {
        "mode": np.where(half, Mode.ACTIVATE, Mode.DRIVE),
        "edge": np.where(half, 0.0, 1.0),
        "skill": np.where(half, 1.0, 0.0),
        "plan_step": np.where(half, 0.0, 2.0),
    }
    return run


@pytest.fixture(scope="module")
def water_page(browser, water, tmp_path_factory):
    file = tmp_path_factory.mktemp("water") / "play.html"
    write_graph_recording(water, file)
    browser.complaints()
    browser.driver.set_window_size(1200, 800)
    browser.open(file.as_uri())
    yield browser
    browser.driver.set_window_size(900, 700)


def moments(water):
    """Mid-frame times: pouring, heating, dispensing, before everything, in the end; not in this order."""
    states, duration = water.log.states, float(water.log.times[-1])
    index = {n: s.index for n, s in water.scenario.graph.objects.items()}
    pours = np.flatnonzero(states["cup"][:, index["cup"]("flow")] > 0.001)
    heats = np.flatnonzero(states["power"][:, 0] > 3.0)
    gives = np.flatnonzero(states["tank"][:, index["tank"]("flow")] > 0)
    middles = [int(np.median(k)) / 30 + 0.4 / 30 for k in (pours, heats, gives)]
    return [middles[1], middles[0], duration - 0.05, middles[2], 0.35]


@pytest.mark.parametrize("moment", range(5), ids=["heating", "pouring", "end", "dispensing", "start"])
def test_water_levels_colours_buttons_and_edges_are_as_logged(water, water_page, moment):
    time, log, scenario = moments(water)[moment], water.log, water.scenario
    water_page.seek(time)
    k = math.floor(time * 30)
    graph, index = scenario.graph, {n: s.index for n, s in scenario.graph.objects.items()}
    cup, tank = (between(log.states[n], time) for n in ("cup", "tank"))

    shown = water_page.node("drake/cup/cup")
    assert shown["position"] == pytest.approx(list(scenario.cup_settings().camera.to_robot(cup[:3])), abs=2e-4)
    lean = RotationMatrix.MakeYRotation(cup[index["cup"]("lean")])
    assert angle(turned(shown), RotationMatrix.MakeXRotation(cup[3]) @ lean) < np.deg2rad(0.15)
    for node, column, amount, temperature in (
        ("drake/cup/cup/inside/water", "column", cup[4], cup[5]),
        ("drake/tank/gauge/water", "column", tank[0], tank[1]),
    ):
        assert water_page.node(node)["scale"][2] == pytest.approx(max(amount, 1e-4), abs=2e-3)
        assert water_page.node(f"{node}/{column}/<object>")["color"] == pytest.approx(
            water_color(temperature), abs=8e-3
        )
    for node, obj in (("drake/cup/stream", "cup"), ("drake/tank/jet", "tank")):
        assert water_page.node(node)["visible"] == bool(log.states[obj][k, index[obj]("flow")] > 0), node
    for name, button in (("power", LAYOUT.power), ("dispense", LAYOUT.dispense)):
        level, depth = between(log.states[name], time)[:2]
        assert water_page.node(f"drake/{name}/cap")["position"][2] == pytest.approx(button[2] - depth, abs=2e-4)
        brightness = max(water_page.node(f"drake/{name}/cap/body/<object>")["color"])
        assert (brightness > 0.5) == (level > 3)

    panel = water_page.js(PANEL)
    on = [e.name for e in graph.interactions if log.active[e.child][k, graph.parents(e.child).index(e.parent)] > 0.5]
    assert panel["lit"] == sorted(on)
    assert panel["edges"] == len(graph.interactions)
    values = {"cup.water ≥ 0.5": log.states["cup"][k, 4], "tank.amount from 0.200 to 0.600": log.states["tank"][k, 0]}
    for (label, value), (low, high) in zip(values.items(), ((0.5, math.inf), (0.2, 0.6)), strict=True):
        assert float(panel["strips"][label]["value"]) == pytest.approx(value, abs=6e-4)
        assert panel["strips"][label]["met"] == (low <= round(value, 3) <= high)
        assert panel["strips"][label]["cursor"] == pytest.approx(k / (len(log.times) - 1), abs=1e-6)

    shown = read_out(water_page)
    assert float(shown["time"]) == pytest.approx(log.times[k], abs=6e-3)
    assert float(shown["cup temperature"]) == pytest.approx(log.states["cup"][k, 5], abs=6e-4)
    assert float(shown["tank amount"]) == pytest.approx(log.states["tank"][k, 0], abs=6e-4)
    first = k < len(log.times) // 2
    assert shown["controller"] == ("activates" if first else "drives")
    assert shown["interaction"] == graph.interactions[0 if first else 1].name
    assert (shown["skill"], shown["plan step"]) == (("activate", "1") if first else ("-", "3"))
    met = sum(low <= v <= high for v, (low, high) in zip(values.values(), ((0.5, 9), (0.2, 0.6)), strict=True))
    assert shown["goal"] == f"{met + (graph.interactions[0].name not in on)} of 3 met"


def test_the_run_shows_all_that_the_test_wants_to_see(water):
    """The moments above differ in what flows and which interactions are active."""
    flags = water.log.active
    seen = {tuple(float(v[int(t * 30)].sum()) for v in flags.values()) for t in moments(water)}
    assert len(seen) >= 4


def test_a_click_on_a_strip_seeks(water, water_page):
    water_page.frames(
        "const s = document.querySelector('#ichain-panel .strip svg'), r = s.getBoundingClientRect();"
        "s.dispatchEvent(new MouseEvent('click', {clientX: r.left + r.width / 2, clientY: r.top + 5}))"
    )
    assert water_page.js("return viewer.animator.time") == pytest.approx(water.log.times[-1] / 2, abs=0.3)
    assert water_page.complaints() == []


@pytest.fixture(scope="module")
def car():
    """The car game under commands that sway the stick."""
    scenario = CarGame(QUIET, "ideal")
    path = choose_paths(scenario)["eight"]
    low, high = scenario.command_range()
    t = np.arange(24)[:, None] / 3
    sway = 0.5 * (low + high) + 0.35 * (high - low) * np.sin(t * np.linspace(0.6, 1.1, len(low)) + 0.3)
    log = logged(scenario, scenario.make_world(path, 0), sway)
    run = PathRun(scenario, {"eight": path})
    run.results = [PathResult("eight", path, log, False, 1.0, 1.0)]
    return run


@pytest.fixture(scope="module")
def car_page(browser, car, tmp_path_factory):
    file = tmp_path_factory.mktemp("car") / "play.html"
    write_recording(car, file)
    browser.open(file.as_uri())
    return browser


@pytest.mark.parametrize("time", [3.015, 7.01, 0.515, 5.32, 1.75])
def test_the_car_game_is_as_logged(car, car_page, time):
    scenario, log = car.scenario, car.results[0].log
    car_page.seek(time)
    k = math.floor(time * 30)
    graph, index = scenario.graph, scenario.graph.objects["car"].index
    x, y, heading = (between(log.states["car"], time)[index(v)] for v in ("x", "y", "heading"))
    screen = scenario.drawings()["car"]
    sprite = car_page.node("drake/car/screen/sprite")
    assert sprite["position"] == pytest.approx(list(screen.points([[x, y]], sprite["position"][2])[0]), abs=2e-4)
    assert angle(turned(sprite), RotationMatrix.MakeZRotation(-heading)) < np.deg2rad(0.2)
    assert car_page.node("drake/car/screen/episode0/executed/<object>")["drawn"] > 0

    stick, states = car_page.node("drake/joystick/stick"), between(log.states["joystick"], time)
    top = turned(stick).matrix()[:, 2]
    assert math.acos(top[2]) == pytest.approx(
        math.acos(math.cos(states[0]) * math.cos(states[1])), abs=np.deg2rad(0.15)
    )
    hand = car_page.node("drake/hand/hand")["position"]
    names = graph.objects["hand"].names
    assert hand[:2] == pytest.approx([between(log.states["hand"], time)[names.index(a)] for a in "xy"], abs=2e-4)

    panel = car_page.js(PANEL)
    on = [e.name for e in graph.interactions if log.active[e.child][k, 0] > 0.5]
    assert panel["lit"] == sorted(on) == ["hand->joystick", "joystick->car"]
    row = log.states["car"][k]
    for label, value in (("car x", row[index("x")]), ("car y", row[index("y")])):
        assert float(panel["strips"][label]["value"].split()[0]) == pytest.approx(value, abs=0.06)
        assert panel["strips"][label]["drawn"] > 200
    off = np.linalg.norm(car.results[0].path.points - row[[index("x"), index("y")]], axis=1).min()
    assert float(read_out(car_page)["distance to path"].split()[0]) == pytest.approx(off, abs=0.06)

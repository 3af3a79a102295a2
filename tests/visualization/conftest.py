"""A made-up recording with a two-link arm, its playback, and a headless browser to look at it."""

import base64
import gzip
import re
import shutil
import struct
from pathlib import Path

import numpy as np
import pytest
import umsgpack
from patience import PATIENCE
from pydrake.geometry import Box, Rgba
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from ichain_drake.graph import Interaction
from ichain_drake.state import StateSpace, Variable
from ichain_drake.visualization import (
    GameScreen,
    Readout,
    RecordedEpisode,
    Recording,
    Strip,
    linear_rgb,
    write_playback,
)

TWO_LINKS = """
<robot name="two_link">
  <link name="base"><visual><geometry><box size=".1 .1 .02"/></geometry></visual></link>
  <link name="upper">
    <inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 .15"/><geometry><cylinder radius=".03" length=".3"/></geometry>
      <material name="orange"><color rgba=".9 .5 .1 1"/></material></visual>
  </link>
  <link name="lower">
    <inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 .1"/><geometry><box size=".04 .04 .2"/></geometry></visual>
  </link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="9"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 .3"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="9"/></joint>
</robot>
"""


def two_link_diagram():
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.0)
    Parser(plant).AddModelsFromString(TWO_LINKS, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    return builder.Build()


SPACES = {
    "lamp": StateSpace("lamp", (Variable("level", "m"), Variable("on", kind="binary"))),
    "car": StateSpace("car", (Variable("x", "px"), Variable("y", "px"), Variable("heading", "rad", kind="angle"))),
}
X_WS = RigidTransform(RotationMatrix.MakeXRotation(np.pi / 2), [0.6, 0.4, 0.5])
HOT, COLD = (0.9, 0.2, 0.1), (0.1, 0.2, 0.9)


class LampDrawing:
    """A column that rises and falls, changes color by its level, and a light that goes on and off."""

    legend = (("lamp", HOT),)

    def setup(self, scene):
        scene.shape("column/water", Box(0.1, 0.1, 0.2), COLD, RigidTransform([0, 0, 0.1]))
        scene.shape("light", Box(0.05, 0.05, 0.05), Rgba(1, 1, 0, 1), RigidTransform([0.3, 0, 0.1]))

    def update(self, scene, time, state):
        scene.scale("column", (1.0, 1.0, state[0]), time)
        scene.color("column/water", state[0] * linear_rgb(HOT) + (1 - state[0]) * linear_rgb(COLD), time)
        scene.visible("light", state[1] > 0.5, time)


def episode(name: str, samples: int, phase: float, start: float = 0.0) -> RecordedEpisode:
    t = np.arange(samples) / 30
    level = 0.5 + 0.4 * np.sin(1.3 * t + phase)
    lamp = np.column_stack([level, (np.floor(t / 1.5) % 2).astype(float)])
    heading = 0.5 * t + phase
    xy = np.column_stack([400 + 120 * np.sin(heading), 300 - 120 * np.cos(heading)])
    car = np.column_stack([xy, (heading + np.pi) % (2 * np.pi) - np.pi])
    return RecordedEpisode(
        name,
        start + t,
        {"lamp": lamp, "car": car},
        np.column_stack([0.8 * np.sin(t + phase), 1.2 * np.cos(0.7 * t)]),
        {"error": Readout(0.1 * t + phase, "px"), "mode": Readout(["drive" if x < 3 else "stop" for x in t])},
        {"car": xy[:: max(1, samples // 40)] + 2.0},
        {"lamp->car": np.floor(t) % 2 == 1},
        {"lamp level": Strip(level, "m", 0.5), "free": Strip(np.where(t < 1, np.nan, t))},
    )


EPISODES = (episode("eight", 181, 0.0, 2.0), episode("spiral", 121, 1.0))


@pytest.fixture(scope="session")
def recording() -> Recording:
    return Recording("test_game", "ideal", 7, SPACES, EPISODES, (Interaction("lamp", "car"),))


@pytest.fixture(scope="session")
def diagram():
    return two_link_diagram()


@pytest.fixture(scope="session")
def drawings():
    return lambda: {"lamp": LampDrawing(), "car": GameScreen((800, 600), 0.001, X_WS, stand=0.2, ghost_period=2.0)}


@pytest.fixture(scope="session")
def page(recording, diagram, drawings, tmp_path_factory) -> Path:
    file = tmp_path_factory.mktemp("playback") / "run.html"
    write_playback(recording, drawings(), file, plant=diagram)
    return file


def inflate(page: Path) -> list[bytes]:
    """The records inside a playback: the log, then Meshcat's commands."""
    packed = re.search(r'id="ichain-recording">\s*([^<\s]+)\s*</script>', page.read_text(encoding="utf-8")).group(1)
    data, records, at = gzip.decompress(base64.b64decode(packed)), [], 0
    while at < len(data):
        (size,) = struct.unpack_from("<I", data, at)
        records.append(data[at + 4 : at + 4 + size])
        at += 4 + size
    return records


@pytest.fixture(scope="session")
def inflated():
    return inflate


@pytest.fixture(scope="session")
def records(page) -> list[bytes]:
    return inflate(page)


@pytest.fixture(scope="session")
def tracks(records) -> dict[str, dict[str, list[dict]]]:
    """Keyframes by object path and track name, as Meshcat's own codec reads them."""
    animation = umsgpack.unpackb(records[-1])
    assert animation["type"] == "set_animation"
    return {a["path"]: {t["name"]: t["keys"] for t in a["clip"]["tracks"]} for a in animation["animations"]}


class Browser:
    """Headless Chromium with WebGL in software."""

    FLAGS = (
        "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
        "--disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader "
        "--ignore-gpu-blocklist --disable-dev-shm-usage --window-size=900,700 --hide-scrollbars "
        "--force-device-scale-factor=0.5"  # a quarter of the pixels, which the processor draws
    )

    RARELY = """
        const drawn = window.requestAnimationFrame.bind(window);
        window.requestAnimationFrame = draw => setTimeout(() => drawn(draw), 40);
    """  # a frame takes the processor, so that they are fewer than on a desk

    def __init__(self, profile: Path, chromium: str, chromedriver: str) -> None:
        from selenium import webdriver  # noqa: PLC0415  (an optional package)

        options = webdriver.ChromeOptions()
        options.binary_location = chromium
        for flag in [*self.FLAGS.split(), f"--user-data-dir={profile}"]:
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(chromedriver))
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": self.RARELY})
        self.driver.set_script_timeout(PATIENCE)
        self.driver.set_page_load_timeout(PATIENCE)

    def open(self, address: str) -> None:
        from selenium.webdriver.support.ui import WebDriverWait  # noqa: PLC0415

        self.driver.get("about:blank")
        self.driver.get(address)
        WebDriverWait(self.driver, PATIENCE, 0.05).until(
            lambda _: self.js("return typeof ichain == 'object' && ichain.ready")
        )

    def js(self, script: str, *arguments):
        return self.driver.execute_script(script, *arguments)

    def frames(self, script: str = "", *arguments) -> None:
        """Run a script and wait until two frames are drawn."""
        self.driver.execute_async_script(
            f"{script}; const done = arguments[arguments.length - 1];"
            "requestAnimationFrame(() => requestAnimationFrame(() => done(true)))",
            *arguments,
        )

    def seek(self, time: float) -> None:
        self.frames("ichain.seek(arguments[0])", time)

    def node(self, path: str) -> dict:
        """What three.js shows of an object in the scene tree."""
        return self.js(
            "const o = viewer.scene_tree.find(arguments[0].split('/').filter(p => p)).object;"
            "return {position: o.position.toArray(), quaternion: o.quaternion.toArray(), scale: o.scale.toArray(),"
            "visible: o.visible, color: o.material ? o.material.color.toArray() : null,"
            "drawn: o.geometry ? o.geometry.drawRange.count : null}",
            path,
        )

    def hud(self) -> str:
        return self.js("return document.getElementById('ichain-hud').innerText")

    def complaints(self) -> list[str]:
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]


@pytest.fixture(scope="session")
def _browser(tmp_path_factory):
    pytest.importorskip("selenium", reason="selenium is missing: pip install ichain_drake[dev]")
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    chromedriver = shutil.which("chromedriver")
    if chromium is None or chromedriver is None:
        pytest.skip("no Chromium or chromedriver: install them (Debian: apt install chromium chromium-driver)")
    instance = Browser(tmp_path_factory.mktemp("profile"), chromium, chromedriver)
    yield instance
    instance.driver.quit()


@pytest.fixture(scope="module")
def browser(_browser):
    """One for all files; leaves no page open, which would be drawn as long as tests run, without a graphics card."""
    yield _browser
    _browser.driver.get("about:blank")

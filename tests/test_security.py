"""The page on security: every test that it names exists, and what no other test holds is held here."""

import re
from pathlib import Path

import pytest
from pydrake.geometry import Meshcat, Sphere

from ichain_drake.control.planning.goal_text import read_goal_text
from ichain_drake.errors import InputError
from ichain_drake.graph import InteractionGraph
from ichain_drake.learning.chain.link import EstimatorSpec
from ichain_drake.learning.estimators import make_estimator
from ichain_drake.objects import Joystick
from ichain_drake.visualization.html_page import playback_page
from ichain_drake.visualization.live_page import LivePage

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "security.md").read_text(encoding="utf-8")


def test_every_sentence_names_tests_that_exist() -> None:
    trusted = PAGE[: PAGE.index("## What is not promised")]
    items = re.split(r"^\* ", trusted, flags=re.MULTILINE)[1:]
    assert len(items) > 10
    for item in items:
        named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", item)
        assert named, item
        for file, test in named:
            assert f"def {test}(" in (ROOT / file).read_text(encoding="utf-8"), f"{file}::{test}"


CODE = [
    "__import__('os').system('true')",
    "os.system",
    "Ridge(alpha=open('x'))",
    "Ridge(**{})",
    "a.b(c=1)",
    "Ridge(alpha=1 if 1 else 2)",
]


@pytest.mark.parametrize("text", CODE)
def test_names_of_estimators_run_nothing(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.system", lambda *a: pytest.fail("it was run"))
    with pytest.raises(InputError):
        EstimatorSpec.parse(text).make()
    with pytest.raises(InputError):
        make_estimator(text)


@pytest.mark.parametrize("text", [*CODE, "stick.x_axis >= open('x')", "stick.__class__ >= 1"])
def test_goals_run_nothing(text: str) -> None:
    graph = InteractionGraph({"hand": Joystick.state_space, "stick": Joystick.state_space}, ["hand->stick"])
    with pytest.raises(InputError, match="goal"):
        read_goal_text(text, graph)


EVIL = "</script><script>alert(1)</script>"


def test_the_live_page_is_for_this_machine_alone(meshcat: Meshcat) -> None:
    page = LivePage(meshcat, EVIL, [[[EVIL], EVIL, EVIL]])
    try:
        assert page._server._server.server_address[0] == "127.0.0.1"
        assert page.address.startswith("http://127.0.0.1:")
        assert b"<script>alert" not in page._answers.shown()[0]
    finally:
        page.close()


def test_texts_in_a_page_stay_texts(meshcat: Meshcat) -> None:
    meshcat.SetObject("ball", Sphere(0.1))
    page = playback_page(meshcat, b"", {"title": EVIL}, EVIL)
    assert b"<script>alert" not in page
    assert b"&lt;/script&gt;&lt;script&gt;alert" in page

"""What tests of several folders learn from: the water dispenser's pieces on `ideal`; patience; which files begin first.

Imported where they are used, so that a test of something small loads neither plants nor estimators.
"""

from __future__ import annotations

import gc
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import HealthCheck, settings
from sharing import made_once, share_in

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pydrake.geometry import Meshcat

    from ichain_drake.demonstrations import Demonstration
    from ichain_drake.learning import InteractionModel, InteractionSpec

# How long an example takes says more about what else runs on the machine than about the code.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("patient")

# Files that take longest begin first, whatever their names: one that begins last would be waited for by idle workers.
FIRST = (
    "test_hostile_files.py",
    "cli/test_killed.py",
    "visualization/test_teaching_in_browser.py",
    "cli/test_scoreboard.py",
    "test_examples.py",
    "cli/test_interrupt.py",
    "cli/test_graph_library_commands.py",
    "runs/goals/test_evaluate_lamp.py",
    "systems/test_dispenser_in_other_words.py",
    "runs/goals/test_run.py",
    "cli/test_evaluate.py",
    "test_own_system.py",
    "runs/paths/test_link_accuracy.py",
    "runs/goals/test_evaluation.py",
    "cli/test_bad_inputs.py",
    "systems/test_contact.py",
    "cli/test_streams.py",
)
_FOLDER = Path(__file__).parent


def pytest_configure(config: pytest.Config) -> None:
    missing = [name for name in FIRST if not (_FOLDER / name).is_file()]
    if missing:
        raise pytest.UsageError(f"tests/conftest.py: there is no tests/{missing[0]} to begin with")
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False  # xdist would begin with the files of most tests


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    rank = {_FOLDER / name: k for k, name in enumerate(FIRST)}
    items.sort(key=lambda item: rank.get(item.path, len(rank)))


def pytest_collection_finish() -> None:
    """What there is now stays: searching it for garbage again and again takes a seventh of the time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def _shared_folder(tmp_path_factory: pytest.TempPathFactory) -> None:
    share_in(tmp_path_factory)


@pytest.fixture(scope="module")
def meshcat() -> Iterator[Meshcat]:
    """A scene. What holds it in a cycle is deleted here: the process would end if another thread did that."""
    from pydrake.geometry import Meshcat, MeshcatParams

    yield Meshcat(MeshcatParams(host="127.0.0.1", show_stats_plot=False))
    gc.collect()


@pytest.fixture(scope="session")
def quick_spec() -> InteractionSpec:
    from ichain_drake.learning import InteractionSpec
    from ichain_drake.learning.chain.link import EstimatorSpec

    return InteractionSpec(status_estimators=(EstimatorSpec.parse("box(reach=0.3)"),))


@pytest.fixture(scope="session")
def dispenser_pieces() -> list[Demonstration]:
    from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

    return made_once("dispenser_pieces", lambda: list(WaterDispenser((), "ideal").record_demonstrations()))


@pytest.fixture(scope="session")
def dispenser_model(dispenser_pieces: list[Demonstration], quick_spec: InteractionSpec) -> InteractionModel:
    from ichain_drake.runs.learn import learn
    from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

    graph = WaterDispenser((), "ideal").graph
    return made_once("dispenser_model", lambda: learn(graph, dispenser_pieces, spec=quick_spec))

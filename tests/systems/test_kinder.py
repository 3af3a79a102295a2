"""KinDER's StickButton2D through the general adapter; without the benchmark, what is said about that."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import ichain_drake as ic
from ichain_drake.cli.main import main
from ichain_drake.systems.kinder.demonstrations import UP, RobotCommands, script_pieces
from ichain_drake.systems.kinder.stick_button import HIGH, LOW, STICK_BUTTONS
from ichain_drake.timing import TICK

B1 = "kinder/StickButton2D-b1"
there = pytest.mark.skipif(find_spec("kinder") is None, reason="KinDER is missing: see docs/kinder.md")


@pytest.mark.skipif(find_spec("kinder") is not None, reason="KinDER is installed")
def test_without_the_benchmark_it_says_what_to_install(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", B1]) == 2
    assert "this needs KinDER (kinder is missing): pip install 'ichain_drake[kinder]'" in capsys.readouterr().err


def test_commands_are_steps_that_the_base_can_take_and_stay_where_it_can_be() -> None:
    lay = RobotCommands(np.array([1.0, 0.5, 0.0, 0.1, 0.0]), LOW, HIGH)
    rows = lay.to(x=1.52, theta=UP, arm=0.2).to(y=9.0, vacuum=1).wait(2).commands
    steps = np.abs(np.diff(rows, axis=0))
    assert (steps[:, :4].max(axis=0) <= np.array([0.05, 0.05, np.pi / 16, 0.1]) + 1e-9).all()
    np.testing.assert_allclose(rows[-1], [1.52, HIGH[1], UP, 0.2, 1.0])
    assert rows[-4, 4] == 0.0  # switched on arrival


def test_a_person_shows_at_most_forty_pieces_and_looks_only_at_starts() -> None:
    looked: list[int] = []

    def look(start: int) -> dict[str, np.ndarray]:
        looked.append(start)
        rng = np.random.default_rng(start)
        return {
            "robot": np.array([1.7, 0.5, 0.3, 0.1, 0.0]),
            "stick": np.array([rng.uniform(0.2, 3.2), rng.uniform(0.65, 1.1), 0.0]),
            "button0": np.array([*rng.uniform([0.1, 0.1], [3.4, 2.4]), 0.0]),
        }

    numbers = iter(range(10_000))
    pieces = list(script_pieces(np.random.default_rng(0), lambda: next(numbers), look, LOW, HIGH))
    assert len(pieces) <= 40
    assert len({p.start for p in pieces}) == len(pieces)
    for piece in pieces:
        assert (piece.commands[:, :2] >= np.array(LOW) - 1e-9).all()
        assert (piece.commands[:, :2] <= np.array(HIGH) + 1e-9).all()


@there
def test_it_opens_as_a_world_that_replays_to_the_last_bit() -> None:
    from pydrake.systems.analysis import Simulator

    scenario = ic.load_scenario(B1, seed=3)
    start = scenario.start_states(scenario.start(0))  # type: ignore[attr-defined]
    world = ic.build_world(scenario)
    simulator = Simulator(world)
    context = simulator.get_mutable_context()
    np.testing.assert_array_equal(world.GetOutputPort("stick.state").Eval(context)[:3], start["stick"])
    wanted = np.array([start["robot"][0] + 0.3, 0.5, 1.0, 0.2, 1.0])
    world.GetInputPort("hand_command").FixValue(context, wanted)
    simulator.AdvanceTo(5 * TICK)
    clone = context.Clone()
    simulator.AdvanceTo(12 * TICK)
    again = Simulator(world, clone)
    again.AdvanceTo(12 * TICK)
    end = world.GetOutputPort("robot.state").Eval(context)
    np.testing.assert_array_equal(end, world.GetOutputPort("robot.state").Eval(again.get_context()))
    np.testing.assert_allclose(end[:4], wanted[:4], atol=1e-6)


@there
def test_what_was_learned_on_one_button_presses_three(tmp_path: Path) -> None:
    teacher = ic.load_scenario(B1, seed=0)
    model = ic.learn(teacher, list(teacher.record_demonstrations()))
    effects = {e.name: [f.variable for f in learned.effects] for e, learned in model.edges.items()}
    assert effects == {"robot->stick": [0, 1], "stick->button0": [2], "robot->button0": [2]}
    run = ic.GraphRun(ic.load_scenario(B1, seed=7))  # type: ignore[arg-type]
    ic.run_graph(run, known=model)
    assert run.goal_reached, run.reason
    ic.save(model, tmp_path, B1)
    three = STICK_BUTTONS["kinder/StickButton2D-b3"](seed=8)
    run = ic.GraphRun(three)
    ic.run_graph(run, known=ic.load(tmp_path, three, lift=True))
    assert run.goal_reached, run.reason
    assert not run.pieces

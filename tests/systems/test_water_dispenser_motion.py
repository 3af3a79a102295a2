"""The arm executes a plan among the machine's parts, and by contact: nothing but what it means to touch is touched."""

import numpy as np
import pytest

from ichain_drake.errors import UnreachableError
from ichain_drake.learning import InteractionModel
from ichain_drake.motion_query import MotionQuery
from ichain_drake.robot import MotionPlanner
from ichain_drake.runs.goals.run import GraphRun, run_graph
from ichain_drake.systems.water_dispenser.scenario import WaterDispenser

WARM_TANK = ("tank.amount >= 0.3", "tank.temperature >= 0.2", "not hand->cup")


def nearest(run: GraphRun, scenario: WaterDispenser) -> float:
    """Least distance between arm or gripper and the machine or table in a run, at most 20 mm [m]."""
    world = scenario.make_world(run.number)
    robot, context = world.robot, world.CreateDefaultContext()
    plant, graph = robot.plant, robot.scene_graph
    scene, inspector = graph.GetMyContextFromRoot(context), graph.model_inspector()

    def model(geometry: object) -> str:
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        return str(plant.GetModelInstanceName(body.model_instance()))

    least = 0.02
    assert run.log is not None
    assert run.log.plant_positions is not None
    for row in run.log.plant_positions[::3]:
        plant.SetPositions(plant.GetMyContextFromRoot(context), row)
        query = graph.get_query_output_port().Eval(scene)
        for pair in query.ComputeSignedDistancePairwiseClosestPoints(0.02):
            both = {model(pair.id_A), model(pair.id_B)}
            if both & {"arm", "gripper"} and both & {"machine", "table"}:
                least = min(least, pair.distance)
    return least


def test_warm_water_in_the_tank_without_touching_the_machine(dispenser_model: InteractionModel) -> None:
    scenario = WaterDispenser((), "contact")
    run = GraphRun(scenario, WARM_TANK, number=1)
    run_graph(run, known=dispenser_model)
    assert run.goal_reached, run.memory and (run.reason, run.memory.log)
    assert nearest(run, scenario) > 0.002


def test_a_point_needs_no_ways_and_an_arm_does() -> None:
    assert WaterDispenser((), "ideal").make_motion() is None
    motion = WaterDispenser((), "arm").make_motion()
    assert isinstance(motion, MotionPlanner)
    above, below = (np.array([0.68, 0.06, z, 0.0, np.pi / 2, 1.0]) for z in (0.36, 0.0715))
    path = motion.path(MotionQuery(above, below, "cup"))  # from over the inlet to the tray
    assert path[:, 0].min() < 0.61
    with pytest.raises(UnreachableError, match="machine.body"):
        motion.path(MotionQuery(above, [0.68, 0.06, 0.2, 0.0, np.pi / 2, 1.0], "cup"))

"""A joystick and a car in a Simulator of your own: learn from demonstrations, then drive along a path."""

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

import ichain_drake as ic

scenario = ic.load_scenario("car_game", ["learning.samples=200"], physics="ideal")
path, builder = scenario.timed_path("eight"), DiagramBuilder()
world = ic.AddWorld(builder, scenario, path)
controller = ic.AddController(builder, world, ic.learn(scenario, scenario.record_demonstrations()), path)
car = LogVectorOutput(world.GetOutputPort("car.state"), builder, ic.FRAME)
reached = LogVectorOutput(controller.GetOutputPort("progress"), builder, ic.TICK)
simulator = Simulator(builder.Build())
simulator.AdvanceTo(path.time[-1])
x, y = car.FindLog(simulator.get_context()).data()[:2, -1]
part = reached.FindLog(simulator.get_context()).data().max() / (len(path.points) - 1)
print(f"{part:.0%} of the path are done, the car is at ({x:.0f}, {y:.0f}) px")

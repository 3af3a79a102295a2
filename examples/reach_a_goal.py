"""A water dispenser in a Simulator of your own: learn from demonstrations, then make a cup of hot water."""

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

import ichain_drake as ic

scenario = ic.load_scenario("water_dispenser", physics="ideal")
model = ic.learn(scenario, scenario.record_demonstrations())
builder = DiagramBuilder()
world = ic.AddWorld(builder, scenario)
goal = ["cup.water >= 0.6", "cup.temperature >= 0.9", "not hand->cup"]
controller = ic.AddController(builder, world, model, goal)
cup = LogVectorOutput(world.GetOutputPort("cup.measured"), builder, ic.FRAME)
simulator = Simulator(builder.Build())
simulator.AdvanceTo(150.0)
last = cup.FindLog(simulator.get_context()).data()[:, -1]
print({name: float(last[k].round(2)) for k, name in enumerate(scenario.graph.objects["cup"].observable.names)})

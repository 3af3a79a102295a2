"""The car game's world in a Simulator of your own: hold the stick still and look where the car goes."""

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from ichain_drake import FRAME, build_world, load_scenario

scenario = load_scenario("car_game", physics="contact", seed=1)  # an arm holds the stick, by friction alone
builder = DiagramBuilder()
world = builder.AddSystem(build_world(scenario))
hand = builder.AddSystem(ConstantVectorSource([0.515, 0.02]))  # x, y of the hand [m]: steer a little, drive forward
builder.Connect(hand.get_output_port(), world.GetInputPort("hand_command"))
stick = LogVectorOutput(world.GetOutputPort("joystick.measured"), builder, FRAME)
car = LogVectorOutput(world.GetOutputPort("car.state"), builder, FRAME)

simulator = Simulator(builder.Build())
simulator.AdvanceTo(4.0)

context = simulator.get_context()
axes, states = stick.FindLog(context).data(), car.FindLog(context).data()
for k in range(0, states.shape[1], 30):
    x, y, heading, speed = states[:4, k]
    print(
        f"{k * FRAME:3.0f} s: axes {axes[0, k]:5.2f} {axes[1, k]:5.2f}, car ({x:3.0f}, {y:3.0f}) px, {speed:4.1f} px/s"
    )

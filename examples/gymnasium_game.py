"""Gymnasium's pendulum as an object behind the joystick (extra: games): it swings, and is replayed from the middle."""

from fractions import Fraction

from pydrake.systems.analysis import Simulator

import ichain_drake as ic
from ichain_drake.objects import Joystick
from ichain_drake.objects.gymnasium import ActionTerm, GameEnvironment, GameSpec, GymnasiumGame

# Torque of 2 N m at the end of the stick; 20 steps a second in 30 frames.
terms = (ActionTerm("x_axis", scale=2.0),)
game = GameEnvironment(GameSpec("Pendulum-v1", terms, steps_per_frame=Fraction(2, 3)))
robot = ic.build_robot(ic.load_scenario("car_game").config.robot, "ideal")
objects = {"hand": robot.space, "stick": Joystick.state_space, "pendulum": game.space}
stick = Joystick("stick", {"hand": robot.space}, settings=ic.ObjectSettings(object_id=1))
pendulum = GymnasiumGame("pendulum", {"stick": stick.state_space}, game, settings=ic.ObjectSettings(object_id=2))
ic.check_object(pendulum)
graph = ic.InteractionGraph(objects, ["hand->stick", "stick->pendulum"])
world = ic.World(graph, robot, {"stick": stick, "pendulum": pendulum})

simulator = Simulator(world)
world.GetInputPort("hand_command").FixValue(simulator.get_mutable_context(), [0.53, 0.0])
simulator.AdvanceTo(1.0)
middle = simulator.get_context().Clone()  # all of the game's state is in it
for context in (middle, middle.Clone()):
    Simulator(world, context).AdvanceTo(2.0)
    cos, sin, rate = world.GetOutputPort("pendulum.measured").Eval(context)
    print(f"after 2 s: cos {cos:.4f}, sin {sin:.4f}, {rate:.4f} rad/s")

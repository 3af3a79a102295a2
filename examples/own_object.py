"""A new object, a winch, behind the joystick: see docs/add_your_own_object.md."""

import numpy as np
from pydrake.systems.analysis import Simulator

import ichain_drake as ic
from ichain_drake.objects import Joystick


class Winch(ic.WorldObject):
    """Winds a load up and down, at up to 0.5 m/s and a little unevenly, between floor and pulley."""

    state_space = ic.StateSpace("winch", (ic.Variable("height", "m", 0.0, 2.0, role=ic.Role("position", "yard", "z")),))
    process_noise_size = 1

    def step(self, state, parents, active, noise, dt):
        ((name, space),) = self.parents.items()
        axis = active[name] * parents[name][..., space.index("x_axis")]
        return np.clip(state + (0.5 * dt * axis)[..., None] + 0.01 * np.sqrt(dt) * noise, 0.0, 2.0)


robot = ic.build_robot(ic.load_scenario("car_game").config.robot, "ideal")
objects = {"hand": robot.space, "stick": Joystick.state_space, "winch": Winch.state_space}
stick = Joystick("stick", {"hand": robot.space}, settings=ic.ObjectSettings(object_id=1))
winch = Winch("winch", {"stick": stick.state_space}, settings=ic.ObjectSettings(object_id=2))
ic.check_object(winch)  # says what is wrong, if anything is
world = ic.World(ic.InteractionGraph(objects, ["hand->stick", "stick->winch"]), robot, {"stick": stick, "winch": winch})
simulator = Simulator(world)
world.GetInputPort("hand_command").FixValue(simulator.get_mutable_context(), [0.53, 0.0])  # push the stick
simulator.AdvanceTo(3.0)
print(f"after 3 s the load is at {world.GetOutputPort('winch.state').Eval(simulator.get_context())[0]:.3f} m")

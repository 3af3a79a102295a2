"""Predict with the learned graph, and differentiate the prediction by the hand's state with Drake's AutoDiff."""

import numpy as np
from pydrake.autodiffutils import ExtractGradient, ExtractValue, InitializeAutoDiff

import ichain_drake as ic

scenario = ic.load_scenario("car_game", ["learning.samples=150"], physics="ideal")
learned = ic.LearnedGraph(ic.learn(scenario, scenario.record_demonstrations()))
context = learned.CreateDefaultContext()
learned.set_states(context, {"hand": [0.5, 0.0], "joystick": [0.0, 0.0], "car": [400.0, 300.0, 0.0, 45.0, 0.0]})
learned.GetInputPort("hand").FixValue(context, [0.515, 0.02])  # where the hand will be at t + 1
print("car in one tick:", np.round(learned.GetOutputPort("car.next_state").Eval(context), 2))

autodiff = learned.ToAutoDiffXd()  # the same graph for AutoDiffXd, in the same state
gradients = autodiff.CreateDefaultContext()
gradients.SetTimeStateAndParametersFrom(context)
autodiff.GetInputPort("hand").FixValue(gradients, InitializeAutoDiff([0.515, 0.02]))
after = autodiff.GetOutputPort("car.next_state").Eval(gradients)
print("the same, by AutoDiff:", np.round(ExtractValue(after).ravel(), 2))
print("d heading / d hand [rad/m]:", np.round(ExtractGradient(after)[2], 2))

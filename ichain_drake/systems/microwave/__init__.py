"""The microwave oven (paper sec. V, fig. 5): hand, door, on/off button, power knob and food."""

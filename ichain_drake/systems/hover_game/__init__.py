"""A second game with the joystick of the car game (paper sec. IV, its end): hand -> joystick -> hovercraft."""

"""Controls that a hand holds: a joystick, a steering wheel."""

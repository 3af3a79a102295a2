"""The car game (paper sec. IV): hand -> joystick -> car."""

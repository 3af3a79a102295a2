"""Steering wheel -> ship (paper sec. IV, its end): the wheel of the drive steers a ship; only wheel -> ship is new."""

"""Steering wheel -> car (paper fig. 1): the hand turns and lifts a wheel, the wheel drives a car on the road."""

"""A game that nobody here wrote: hand -> joystick -> the car of Gymnasium's CarRacing."""

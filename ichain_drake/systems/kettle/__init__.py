"""Bottle and kettle (paper sec. I): two objects that act on each other in opposite directions at different times."""

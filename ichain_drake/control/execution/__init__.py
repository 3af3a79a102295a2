"""Executing a plan under feedback: tasks, what is held, what went otherwise than predicted (paper appendix B)."""

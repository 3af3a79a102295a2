"""Runs of systems that follow paths."""

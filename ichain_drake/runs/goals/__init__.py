"""Runs of systems that reach goals over an interaction graph."""

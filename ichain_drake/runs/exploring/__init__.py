"""A robot that finds out by itself which objects act on which."""

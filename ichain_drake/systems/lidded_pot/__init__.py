"""A pot under a lid that a spring shuts: two hands are needed to pour into it."""

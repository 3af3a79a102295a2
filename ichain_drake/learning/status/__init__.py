"""Status: whether an interaction is active, by a classifier over states (paper sec. V)."""

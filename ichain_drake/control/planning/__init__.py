"""Planning over a learned interaction graph: goals, macro-actions, skills, search (paper sec. V, VI)."""

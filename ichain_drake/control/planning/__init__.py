"""Planning over a learned interaction graph: goals, options, skills, search (paper sec. V, VI)."""

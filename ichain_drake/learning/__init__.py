"""Learning from demonstrations: links of a chain here, whole graphs in `interaction`; no Drake systems."""

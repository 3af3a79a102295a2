"""One table of what works: every system, task, physics and fault, every trial with demonstrations of its own."""

"""Control of interaction graphs: planning over interactions, skills that switch them, and execution with monitors."""

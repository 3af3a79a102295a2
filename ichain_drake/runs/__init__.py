"""What a user asks for: run, plan, evaluate, relearn, watch, teach."""

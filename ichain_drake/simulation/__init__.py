"""Running a world: episodes, recording, watching, real time."""

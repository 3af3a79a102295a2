"""Script and style of the playback page."""

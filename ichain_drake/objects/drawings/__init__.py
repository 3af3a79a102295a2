"""How objects look in a playback."""

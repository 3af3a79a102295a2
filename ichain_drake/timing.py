"""The two clocks: frames of 1/30 s in the world, ticks of ten frames for control, demonstrations and learned models."""

from __future__ import annotations

FRAME = 1.0 / 30.0
"""Period of the one base event that drives objects, hand, modes and controller [s]."""

FRAMES_PER_TICK = 10
"""A tick is counted in frames; a period of 1/3 s of its own would drift against the frames in floating point."""

TICK = FRAMES_PER_TICK * FRAME
"""Period of control, of demonstrations and of the learned graph [s] (paper sec. IV: 3 Hz)."""

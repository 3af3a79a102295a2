"""Effects: what an active interaction adds to a child's passive dynamics (paper eq. 2, 3)."""

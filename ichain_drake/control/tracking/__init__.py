"""Following timed paths: Algorithm 1 of the paper, its levels, and how they are chosen."""

"""Control through learned models: Algorithm 1 and its levels for chains, plans and monitors for graphs (in `graph`)."""

"""Control one object through another: chains and graphs of learned object interactions, for Drake."""

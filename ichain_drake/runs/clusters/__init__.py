"""Where trials run: processes of this machine, or a cluster; and what becomes of a trial that crashes or hangs."""

"""Two water dispensers side by side and one cup: a goal that needs both (`ideal` alone: an arm does not reach both)."""

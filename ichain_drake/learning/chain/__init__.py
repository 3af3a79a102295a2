"""Learning a chain, link by link: forward and inverse transition models (paper sec. III, IV)."""

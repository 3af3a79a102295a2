"""KinDER, a public benchmark of tool use, opened through the general adapter (extra `kinder`)."""

"""What a stick or a wheel drives: cars, a hovercraft, a ship."""

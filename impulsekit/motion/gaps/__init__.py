"""How far bodies are apart, how fast that changes, and the points at which they touch."""

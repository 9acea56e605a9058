"""Where a motion has come to, and what happens to it there: impacts, rest, hops, drift."""

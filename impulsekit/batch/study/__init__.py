"""Studies: a scene at random states, streamed to a store, resumed, summed up."""

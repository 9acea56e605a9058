"""The integrator at work between impacts: steps in a chart, kept as a path."""

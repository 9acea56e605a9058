"""What ends a step: gaps that close, points that stop or lift, forces with a kink."""

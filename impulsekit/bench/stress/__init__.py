"""Sweeps to the edge of what doubles can hold: is every answer right, or says that it is not?

    bodies ─► sweeps: trees, chains, held, touched, laws ─► methods ─► judge ─► run ─► report
                                                                        ▲
    numbers ─► mechanics ─► equations ─► truth: impacts, planar, chains ┘

The truth comes from ``impulsekit.reference`` and closed forms in 50 digits, never from doubles.
"""

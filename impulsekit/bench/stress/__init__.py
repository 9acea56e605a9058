"""Sweeps to the edge of what doubles can hold: is every answer right, or says that it is not?

    bodies ─► sweeps: trees, held, contacts, chains ─► methods ─► judge ─► run ─► report, pictures
                                                                   ▲
    numbers ─► elimination ─► truth: Kane and the laws in 50 digits┘

The truth comes from ``impulsekit.reference`` and closed forms in 50 digits, never from doubles.
"""

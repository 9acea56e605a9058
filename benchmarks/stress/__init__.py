"""Sweeps to the edge of what doubles can hold: is every answer right, or says that it is not?

    bodies ─► sweeps: trees, chains, held, touched, laws, sequences, collisions ─► methods ─► judge
                                                                                      ▲         │
    numbers ─► mechanics ─► equations ─► truth: impacts, planar, slip ─► strikes, chains        ▼
                                                                                      run ─► report

Flights (``flights``, ``flown``) are motions, held against exact ones; their errors are times [s].
Contacts in a plane (``in_plane``, ``enumerated``) are held against all modes of their law, scenes
written in other ways (``rewritten``, ``mechanisms``, ``struck``) against themselves, and
scenes of example robots (``robots``) against Kane's equations.

The truth comes from ``impulsekit.reference`` and closed forms in 50 digits, never from doubles.
"""

"""What users get wrong, and the words they get: one clear sentence for each.

``python -m tests.faults`` makes every fault of the list and writes the table
``tests/faults/faults.md``. A fault is a line of plain words and a function that
commits it; the lists stand by room, in the order of the design.
"""

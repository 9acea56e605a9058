"""Broken and hostile files by the hundred thousand: every one is loaded, or refused by us.

``python -m benchmarks.fuzz --files 100000`` makes URDFs and scene files by a grammar
that knows what hurts, and by changing bytes of the files that ship with the project. Each
is loaded and struck in a process of its own kind, so that a crash of the interpreter is
seen, and laid at the file's door. A file is its number and the seed, nothing else.
"""

"""Frames, joints and bodies of every entry of a scene; the core makes rows of them.

A new constraint is a class in the scene, a function in ``entries`` and a word in the scene file's
vocabulary. ``bodies`` has the shapes and margins of what may collide.
"""

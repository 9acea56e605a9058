"""Pairs of frames and what their rows are: Jacobian, bias, derivative, reaction, once each.

``frame_pair`` has the formulas and the conventions of sign, order and frame. ``entries`` says of
every entry of a scene which frames or joints it speaks of. All else is built on these: ``pair``
has the rows of two frames and their rates from Pinocchio's data, ``point_rows`` those of tables
of points for compiled motions, ``constraints`` and ``contacts`` those of a scene, ``reach`` the
part of the robot that they are written for. A new constraint is a class in the scene, a function
in ``entries`` and a word in the scene file's vocabulary.
"""

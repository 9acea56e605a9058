"""Springs, PD laws, motors and applied forces: from a scene to torques and wrenches."""

"""Many steps and impacts in one compiled call, as long as compiled code knows all that acts."""

"""Questions asked of the MM3A: step calibration, open-loop control, trends of the actuators."""

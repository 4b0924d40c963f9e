"""The MM3A in Drake: plant, stepper, limit switch and teleoperation."""

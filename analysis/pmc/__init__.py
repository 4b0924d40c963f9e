"""Questions asked of the PepperMill-Carrier: workspace, rotatability, torque, controllers."""

"""Questions asked of models and diagrams: comparison, workspace, calibration and the instrument."""

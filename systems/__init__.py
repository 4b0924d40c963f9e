"""LeafSystems: plants, actuators, encoders, observers, controllers and references."""

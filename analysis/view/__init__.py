"""Pictures that move: machines with sliders, replays with ghosts, block diagrams."""

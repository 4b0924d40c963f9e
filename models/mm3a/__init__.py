"""The Kleindiek MM3A micromanipulator (Damani 2013): a rotary-rotary-prismatic stick-slip arm."""

"""From a checked `Scene` to the arrays that kernels trust, and the plan of effects."""

"""The built-in robots: one module per robot, with its URDF and its individuals beside it."""

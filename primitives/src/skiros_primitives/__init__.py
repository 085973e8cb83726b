"""The built-in primitives: driving, arm motion, gripper, locating, registering. Found through entry points."""

"""Arm kinematics, collision checks and motion planning with Pinocchio and Coal.

Only :mod:`skiros_py.motion.arm_planner` looks in here, from inside a worker process.
"""

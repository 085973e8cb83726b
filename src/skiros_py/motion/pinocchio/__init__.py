"""Arm kinematics, collision checks and motion planning with Pinocchio and Coal.

Used only by :mod:`skiros_py.motion.adapters`, inside a worker process.
"""

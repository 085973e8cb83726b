"""The MuJoCo physics engine behind the simulation port."""

from skiros_py.simulation.mujoco.engine import MujocoEngine

__all__ = ["MujocoEngine"]

"""The PyBullet physics engine behind the simulation port."""

from skiros_py.simulation.pybullet.engine import PyBulletEngine

__all__ = ["PyBulletEngine"]

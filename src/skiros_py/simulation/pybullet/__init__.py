"""A physically simulated robot cell: the adapter to PyBullet."""

from skiros_py.simulation.pybullet.cell import PyBulletCell

__all__ = ["PyBulletCell"]

"""Fakes of the robot's ports: instant, without physics, part of the product."""

from skiros_py.simulation.fake.cell import FakeCell

__all__ = ["FakeCell"]

"""Fakes of the robot's ports: instant, without physics, part of the product."""

"""Selects the part of the world that goes into a planning problem."""

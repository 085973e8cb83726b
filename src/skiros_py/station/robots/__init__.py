"""Robots: their models, camera observations and motions."""

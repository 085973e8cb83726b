"""Robots: their models, what they see and where they go."""

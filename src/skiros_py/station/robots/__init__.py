"""Robots: their models, looks and motions."""

"""Scenes that can be saved and loaded."""

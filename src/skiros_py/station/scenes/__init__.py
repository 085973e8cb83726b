"""Saving and loading of scenes."""

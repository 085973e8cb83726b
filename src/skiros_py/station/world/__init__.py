"""The world as people and programs outside see it."""

"""Reasoners: plug-ins that work out relations from data, and store data in elements (paper §5.4)."""

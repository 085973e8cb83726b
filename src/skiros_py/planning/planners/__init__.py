"""Planners: the port, those that come with the platform, and which of them plans."""

"""Checks plug-ins: applies the rules to everything in a distribution, and runs its skills on a fake robot."""

"""Plug-ins by entry points: the built-ins use the same door as anyone's.

They are found without importing any of them, and loaded when they are needed. One that fails to load is reported
with its name, version, origin and traceback, and does not affect the others.
"""

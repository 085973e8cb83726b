"""Open3D behind the perception ports: detection of parts, and registration of known bodies.

Open3D is imported in the worker process only; importing this package costs nothing.
"""

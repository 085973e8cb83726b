"""Open3D behind the perception ports: which parts lie there, where exactly is this kit.

Open3D is imported in the worker process only; importing this package costs nothing.
"""

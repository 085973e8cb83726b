"""Open3D behind the perception ports: which parts lie there, where exactly is this kit.

Open3D is imported in the worker process only; importing this package costs nothing.
"""

from skiros_py.perception.worker import Open3dPartDetector, Open3dRegistrar, start_perception

__all__ = ["Open3dPartDetector", "Open3dRegistrar", "start_perception"]

"""Open3D's compiled library, without the viewers and the machine learning that ``import open3d`` loads too.

Those import dash, plotly, IPython and scikit-learn: more than a second, and more than 100 MB in each process.
"""

import sys
from importlib.util import find_spec, module_from_spec

if "open3d" in sys.modules:
    from open3d.cpu import pybind as pybind
else:
    _spec = find_spec("open3d")
    if _spec is None:
        raise ModuleNotFoundError("No module named 'open3d'", name="open3d")
    sys.modules["open3d"] = module_from_spec(_spec)  # its __init__ is not executed
    try:
        from open3d.cpu import pybind as pybind
    finally:
        del sys.modules["open3d"]  # a plug-in's own `import open3d` executes it

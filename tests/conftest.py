"""Numerics run on one thread, as in the worker processes: results do not depend on the number of cores.

Set before any test module loads a numerical library, which read it once.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

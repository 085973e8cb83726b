"""The client is for any program: it brings no robot and no server along."""

from __future__ import annotations

import subprocess
import sys

HEAVY = {
    "fastapi",
    "numpy",
    "starlette",
    "uvicorn",
    "pyoxigraph",
    "rdflib",
    "pybullet",
    "scipy",
    "skiros_py.station.session",
}


def test_importing_the_client_imports_neither_runtime_nor_server() -> None:
    code = "import sys, skiros_py.client; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()

    assert HEAVY.isdisjoint(loaded)

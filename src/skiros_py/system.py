"""Checks, before anything starts, what is missing: extras of the distribution, libraries that pip cannot install."""

from __future__ import annotations

import ctypes
import os
import platform
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

from skiros_py.errors import MissingExtra, MissingSystemLibrary, UsageError

EXTRAS = {
    "kitting": ("skiros_primitives", "skiros_robots", "skiros_skills"),
    "physics": ("mujoco", "pinocchio", "open3d"),
    "pybullet": ("pybullet",),
    "perception": ("open3d",),
    "ik": ("ssik",),
    "calibration": ("cv2",),
    "planners": ("kairos", "unified_planning"),
    "ontology": ("owlready2", "reasonable"),
    "server": ("fastapi", "uvicorn", "structlog"),
}
"""Modules that tell whether an extra of the distribution is installed."""

_NEEDED = (
    # (used by, shared library, Debian package)
    ("open3d", "libX11.so.6", "libx11-6"),
    ("open3d", "libGL.so.1", "libgl1"),
    ("open3d", "libudev.so.1", "libudev1"),
    ("open3d", "libgomp.so.1", "libgomp1"),
    ("pinocchio", "libgomp.so.1", "libgomp1"),
)
_CONTAINER = Path("/sys/fs/cgroup/memory.max")


def has_extra(name: str) -> bool:
    """Returns whether an extra of the distribution is installed."""
    try:
        return all(find_spec(module) is not None for module in EXTRAS[name])
    except ImportError:
        return False


def default_simulation() -> str:
    """Returns the engine that simulates where no other is asked for: PyBullet, where there is one."""
    return "mujoco" if find_spec("pybullet") is None else "pybullet"


def require_extra(name: str, needed_for: str) -> None:
    """Checks that an extra of the distribution is installed.

    Args:
        name: The extra.
        needed_for: What needs it, for the message ("serving a scene").

    Raises:
        MissingExtra: It is not; the message says how to install it.
    """
    if not has_extra(name):
        raise MissingExtra(name, needed_for)


def this_platform() -> str:
    """Returns Python and machine, as wheels are made for them: "Python 3.13 on Linux aarch64"."""
    return f"Python {sys.version_info[0]}.{sys.version_info[1]} on {platform.system()} {platform.machine()}"


def check_system_libraries() -> None:
    """Looks for the system libraries that the simulation, motion and perception packages load.

    Raises:
        MissingSystemLibrary: One is absent; the message says which package brings it.
    """
    for missing in missing_system_libraries():
        raise missing


def missing_system_libraries() -> Iterator[MissingSystemLibrary]:
    """Yields the system libraries that are absent, as the faults that they would be."""
    if sys.platform != "linux":
        return
    for package, library, debian in _NEEDED:
        if find_spec(package) is None:
            continue
        try:
            ctypes.CDLL(library)
        except OSError:
            yield MissingSystemLibrary(package, library, debian)


def processors() -> int:
    """Returns on how many processors this process may run."""
    return len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1


def memory() -> int:
    """Returns how much memory this process may take [bytes]: what there is, or what a container leaves of it."""
    there_is = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    try:
        return min(there_is, int(_CONTAINER.read_text(encoding="ascii")))
    except (OSError, ValueError):  # no such file, or "max" in it
        return there_is


def check_display(display: str | None) -> None:
    """Checks that a window can be opened.

    Args:
        display: The environment's ``DISPLAY``.

    Raises:
        UsageError: There is no display.
    """
    if sys.platform != "linux":
        return
    if not display:
        raise UsageError("--gui needs a display and DISPLAY is not set; use --record FILE for pictures instead")
    library = ctypes.CDLL("libX11.so.6")
    library.XOpenDisplay.restype = ctypes.c_void_p
    if library.XOpenDisplay(display.encode()) is None:  # PyBullet would end the process
        raise UsageError(f"--gui: no display answers at DISPLAY={display}; use --record FILE for pictures instead")

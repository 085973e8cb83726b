"""skiros-py: describe a scene, state a goal, and a robot plans and does it.

>>> import skiros_py
>>> with skiros_py.open("kitting", fake=True) as session:
...     report = session.run(session.goal)
>>> report.reached
True
"""

from __future__ import annotations

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from skiros_py.station.session import Session

__all__ = ["__version__", "open"]

__version__ = version("skiros-py")


def open(scene: str | Path, **options: Any) -> Session:  # noqa: A001 - reads as what it does: skiros_py.open("kitting")
    """Opens a scene: world, robot, skills, planner.

    Args:
        scene: Name of a scene, or path of a scene file.
        **options: Fields of `station.session.Options`: ``seed``, ``robot``, ``fake``, ``pace``, ``gui``.

    Returns:
        A session; use it in a ``with`` or close it.
    """
    from skiros_py.station.session import Options, Session  # heavy imports only when something is opened

    return Session(str(scene), Options(**options))

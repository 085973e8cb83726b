"""Stopping everything, and letting it start again."""

from __future__ import annotations

from skiros_py.api.stop import StopInfo
from skiros_py.client.call import Call


def stop(reason: str = "") -> Call[StopInfo]:
    """Halts all robots in the next control cycle.

    Args:
        reason: Why, for a person.
    """
    return Call("POST", "/stop", StopInfo, json={"reason": reason})


def get_stop() -> Call[StopInfo]:
    """Tells whether everything is halted."""
    return Call("GET", "/stop", StopInfo)


def reset() -> Call[StopInfo]:
    """Lets things start again after a halt: somebody has looked why that was."""
    return Call("POST", "/reset", StopInfo)

"""Stopping everything, and letting it start again."""

from __future__ import annotations

from httpx2 import Response

from skiros_py.api.stop import StopInfo
from skiros_py.client.call import Call

__all__ = ["get_stop", "reset", "stop"]


def stop(reason: str = "") -> Call[StopInfo]:
    """Halts all robots in the next control cycle.

    Args:
        reason: Why, for a person.
    """
    return Call("POST", "/stop", _info, json={"reason": reason})


def get_stop() -> Call[StopInfo]:
    """Tells whether everything is halted."""
    return Call("GET", "/stop", _info)


def reset() -> Call[StopInfo]:
    """Lets things start again after a halt: somebody has looked why that was."""
    return Call("POST", "/reset", _info)


def _info(response: Response) -> StopInfo:
    return StopInfo.model_validate_json(response.content)

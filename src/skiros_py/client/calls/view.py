"""The world as it is seen."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api.view import WorldView
from skiros_py.client.call import Call


def read_view(elements: Sequence[str] | None = None) -> Call[WorldView]:
    """Tells where everything is believed to be, and what it looks like.

    Args:
        elements: Only these, with what moves or is gone with them, at most 100; everything where left out.
    """
    query = {"element": None if elements is None else list(elements)}
    return Call("GET", "/view", WorldView, query=query)

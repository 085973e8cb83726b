"""What robots were taught."""

from __future__ import annotations

from urllib.parse import quote

from skiros_py.api.learned import LearnedPage
from skiros_py.api.world import Written
from skiros_py.client.call import Call


def list_learned(*, limit: int | None = None, cursor: str | None = None) -> Call[LearnedPage]:
    """Lists what robots were taught."""
    query = {"limit": limit, "cursor": cursor}
    return Call("GET", "/learned", LearnedPage, query=query)


def forget_learned(element: str, *, version: int | None = None, reason: str | None = None) -> Call[Written]:
    """Forgets something with its pieces; an undo brings it back.

    Args:
        element: Its id.
        version: The version that was seen; None for whatever it is now.
        reason: Why.
    """
    return Call(
        "DELETE",
        f"/learned/{quote(element, safe='')}",
        Written,
        query={"reason": reason},
        headers={"If-Match": "*" if version is None else f'"{version}"'},
        repeatable=False,
    )


def export_learned() -> Call[str]:
    """Returns everything that was learned as the text of a Turtle file."""
    return Call("GET", "/learned.ttl", lambda r: r.text)

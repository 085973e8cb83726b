"""Previews: goals that are planned and not done."""

from __future__ import annotations

from urllib.parse import quote

from skiros_py.api.goals import GoalOrder
from skiros_py.api.previews import AppliedRepair, Preview, PreviewPage
from skiros_py.client.call import Call


def ask_preview(order: GoalOrder) -> Call[Preview]:
    """Begins to plan for a goal."""
    body = order.model_dump(mode="json", by_alias=True, exclude_defaults=True, include=set(GoalOrder.model_fields))
    return Call("POST", "/previews", Preview, json=body)


def list_previews() -> Call[PreviewPage]:
    """Lists the previews that are kept, the latest first."""
    return Call("GET", "/previews", PreviewPage)


def get_preview(preview: str, *, wait: float = 0.0) -> Call[Preview]:
    """Looks at a preview.

    Args:
        preview: Its id.
        wait: How long to wait for the answer [s], up to 30 s.
    """
    return Call("GET", _path(preview), Preview, query={"wait": wait or None})


def apply_repair(preview: str, repair: int) -> Call[AppliedRepair]:
    """Makes the changes to the world that a repair consists of."""
    path = f"{_path(preview)}/repairs/{repair}/apply"
    return Call("POST", path, AppliedRepair, repeatable=False)


def _path(preview: str) -> str:
    return f"/previews/{quote(preview, safe='')}"

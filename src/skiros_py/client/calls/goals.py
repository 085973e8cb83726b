"""Goals: checking and previews."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api.goals import (
    CheckedGoal,
    ConditionWords,
    GoalData,
    GoalOrder,
    GoalTexts,
    SceneGoals,
)
from skiros_py.api.previews import AppliedRepair, Preview, PreviewPage
from skiros_py.client.request import Call, path_of


def check_goal(order: GoalOrder) -> Call[CheckedGoal]:
    """Returns how a goal is interpreted, and whether it holds now; nothing is ordered."""
    body = order.model_dump(mode="json", by_alias=True, exclude_defaults=True, include=set(GoalOrder.model_fields))
    return Call("POST", "/goals/check", CheckedGoal, json=body)


def get_goals() -> Call[tuple[SceneGoals, str]]:
    """Returns the goals stored with the scene, and their version for :func:`put_goals`."""
    return Call("GET", "/goals", lambda r: (SceneGoals.model_validate_json(r.content), r.headers["etag"]))


def put_goals(goals: Sequence[str | GoalData], *, seen: str) -> Call[SceneGoals]:
    """Replaces the goals stored with the scene.

    Args:
        goals: Texts or structured conditions; empty for none.
        seen: Their version, from :func:`get_goals`.
    """
    body = GoalTexts(goals=tuple(goals)).model_dump(mode="json")
    headers = {"If-Match": seen}
    return Call("PUT", "/goals", SceneGoals, json=body, headers=headers)


def list_goal_conditions(*, every: bool = False) -> Call[ConditionWords]:
    """Lists the words of the language of goals.

    Args:
        every: True to include those that no current robot can achieve.
    """
    query = {"all": "true" if every else None}
    return Call("GET", "/goals/conditions", ConditionWords, query=query)


def ask_preview(order: GoalOrder) -> Call[Preview]:
    """Starts planning for a goal."""
    body = order.model_dump(mode="json", by_alias=True, exclude_defaults=True, include=set(GoalOrder.model_fields))
    return Call("POST", "/previews", Preview, json=body)


def list_previews() -> Call[PreviewPage]:
    """Lists the stored previews, newest first."""
    return Call("GET", "/previews", PreviewPage)


def get_preview(preview: str, *, wait: float = 0.0) -> Call[Preview]:
    """Returns a preview.

    Args:
        preview: Its id.
        wait: How long to wait for the answer [s], up to 30 s.
    """
    return Call("GET", path_of("previews", preview), Preview, query={"wait": wait or None})


def apply_repair(preview: str, repair: int) -> Call[AppliedRepair]:
    """Applies the world changes of a repair."""
    path = path_of("previews", preview, "repairs", repair, "apply")
    return Call("POST", path, AppliedRepair, repeatable=False)

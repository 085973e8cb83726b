"""Goals: checked without being ordered, and those that go with the scene."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.api.goals import CheckedGoal, ConditionWords, GoalData, GoalOrder, GoalTexts, SceneGoals
from skiros_py.client.call import Call


def check_goal(order: GoalOrder) -> Call[CheckedGoal]:
    """Says how a goal is understood, and whether it holds now; nothing is ordered."""
    body = order.model_dump(mode="json", by_alias=True, exclude_defaults=True, include=set(GoalOrder.model_fields))
    return Call("POST", "/goals/check", CheckedGoal, json=body)


def get_goals() -> Call[tuple[SceneGoals, str]]:
    """Shows the goals that go with the scene, and their version, for :func:`put_goals`."""
    return Call("GET", "/goals", lambda r: (SceneGoals.model_validate_json(r.content), r.headers["etag"]))


def put_goals(goals: Sequence[str | GoalData], *, seen: str) -> Call[SceneGoals]:
    """Replaces the goals that go with the scene.

    Args:
        goals: Texts or structured conditions; empty for none.
        seen: Their version, as :func:`get_goals` says it.
    """
    body = GoalTexts(goals=tuple(goals)).model_dump(mode="json")
    headers = {"If-Match": seen}
    return Call("PUT", "/goals", SceneGoals, json=body, headers=headers)


def list_goal_conditions(*, every: bool = False) -> Call[ConditionWords]:
    """Lists the words of the language of goals.

    Args:
        every: True for those as well that no present robot can do anything for.
    """
    query = {"all": "true" if every else None}
    return Call("GET", "/goals/conditions", ConditionWords, query=query)

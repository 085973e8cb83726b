"""Goal templates: named goals with parameters."""

from __future__ import annotations

from urllib.parse import quote

from skiros_py.api.templates import GoalTemplate, GoalTemplateContent, GoalTemplates
from skiros_py.client.call import Call, nothing


def list_goal_templates() -> Call[GoalTemplates]:
    """Lists the goal templates."""
    return Call("GET", "/goal-templates", GoalTemplates)


def get_goal_template(name: str) -> Call[GoalTemplate]:
    """Looks at a goal template."""
    return Call("GET", _path(name), GoalTemplate)


def put_goal_template(name: str, content: GoalTemplateContent, *, seen: int | None = None) -> Call[GoalTemplate]:
    """Writes a goal template.

    Args:
        name: Its name.
        content: What it says.
        seen: Version of the one that is there already.
    """
    body = content.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    headers = {"If-Match": None if seen is None else f'"{seen}"'}
    return Call("PUT", _path(name), GoalTemplate, json=body, headers=headers, repeatable=False)


def remove_goal_template(name: str, *, seen: int) -> Call[None]:
    """Removes a goal template."""
    return Call("DELETE", _path(name), nothing, headers={"If-Match": f'"{seen}"'}, repeatable=False)


def _path(name: str) -> str:
    return f"/goal-templates/{quote(name, safe='')}"

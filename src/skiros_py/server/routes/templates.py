"""Routes: goal templates, which ISA-95 calls work masters."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Response

from skiros_py.api.templates import GoalTemplate, GoalTemplateContent, GoalTemplates
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.etags import NEEDS_VERSION, SeenDep, tagged, with_etag
from skiros_py.server.services import StationDep

router = APIRouter(tags=["goal templates"])

TemplateName = Annotated[
    str, Path(min_length=1, max_length=200, description="Name of the template.", examples=["fill kit"])
]


@router.get("/goal-templates", summary="List goal templates", dependencies=[needs(Role.VIEWER, mes=True)])
def list_goal_templates(station: StationDep) -> GoalTemplates:
    """Lists the goal templates, by name."""
    return station.templates.all()


@router.get(
    "/goal-templates/{name}",
    summary="Look at a goal template",
    dependencies=[needs(Role.VIEWER, mes=True)],
    responses=tagged(),
)
def get_goal_template(name: TemplateName, station: StationDep, response: Response) -> GoalTemplate:
    """Shows a goal template."""
    return with_etag(station.templates.get(name), response)


@router.put(
    "/goal-templates/{name}",
    summary="Write a goal template",
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION
    | tagged()
    | {201: {"model": GoalTemplate, "description": "It is new.", **tagged(201)[201]}},
)
def put_goal_template(
    name: TemplateName,
    content: GoalTemplateContent,
    station: StationDep,
    seen: SeenDep,
    response: Response,
) -> GoalTemplate:
    """Writes a goal template; for one that is there already, `If-Match` names the version that was seen.

    Jobs that were ordered with it stay as they are.
    """
    template, new = station.templates.put(name, content, seen)
    response.status_code = 201 if new else 200
    return with_etag(template, response)


@router.delete(
    "/goal-templates/{name}",
    summary="Remove a goal template",
    status_code=204,
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION,
)
def remove_goal_template(name: TemplateName, station: StationDep, seen: SeenDep) -> None:
    """Removes a goal template; `If-Match` names the version that was seen. Jobs that were ordered with it stay."""
    station.templates.remove(name, seen)

"""Routes: goal templates, which ISA-95 calls work masters."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Response

from skiros_py.api.templates import GoalTemplate, GoalTemplateContent, GoalTemplates
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.etags import NEEDS_VERSION, VersionDep, etag, require_version, tagged
from skiros_py.server.job_faults import job_faults
from skiros_py.server.problems import found
from skiros_py.server.routes.job_access import TemplatesDep
from skiros_py.server.services import ServicesDep
from skiros_py.station.jobs.templates import check_template

__all__ = ["router"]

router = APIRouter(tags=["goal templates"])

TemplateName = Annotated[
    str, Path(min_length=1, max_length=200, description="Name of the template.", examples=["fill kit"])
]


@router.get("/goal-templates", summary="List goal templates", dependencies=[needs(Role.VIEWER, mes=True)])
def list_goal_templates(templates: TemplatesDep) -> GoalTemplates:
    """Lists the goal templates, by name."""
    return GoalTemplates(templates=templates.all())


@router.get(
    "/goal-templates/{name}",
    summary="Look at a goal template",
    dependencies=[needs(Role.VIEWER, mes=True)],
    responses=tagged(),
)
def get_goal_template(name: TemplateName, templates: TemplatesDep, response: Response) -> GoalTemplate:
    """Shows a goal template."""
    with found():
        return _shown(templates.find(name), response)


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
    services: ServicesDep,
    templates: TemplatesDep,
    seen: VersionDep,
    response: Response,
) -> GoalTemplate:
    """Writes a goal template; for one that is there already, `If-Match` names the version that was seen.

    Jobs that were ordered with it stay as they are.
    """
    session = services.session
    with job_faults():
        check_template(content, session.world.ontology, session.catalogue.conditions)
    known = templates.get(name)
    if known is not None:
        require_version(seen, known.version)
    with job_faults():
        written = templates.put(name, content, expects=0 if known is None else known.version)
    response.status_code = 201 if known is None else 200
    return _shown(written, response)


@router.delete(
    "/goal-templates/{name}",
    summary="Remove a goal template",
    status_code=204,
    dependencies=[needs(Role.OPERATOR)],
    responses=NEEDS_VERSION,
)
def remove_goal_template(name: TemplateName, templates: TemplatesDep, seen: VersionDep) -> None:
    """Removes a goal template; `If-Match` names the version that was seen. Jobs that were ordered with it stay."""
    with found():
        known = templates.find(name)
    require_version(seen, known.version)
    with job_faults():
        templates.remove(name, expects=known.version)


def _shown(template: GoalTemplate, response: Response) -> GoalTemplate:
    response.headers["ETag"] = etag(template.version)
    return template

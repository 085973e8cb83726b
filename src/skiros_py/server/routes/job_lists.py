"""Routes: what a factory system asks of all jobs: what may be ordered, and what has come of what was."""

from __future__ import annotations

import time
from typing import Annotated

from fastapi import APIRouter, Query

from skiros_py.api.jobs import JobCapabilities, JobResponses, StateName, WorkMaster
from skiros_py.api.wire import WantedMoment
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.routes.job_access import CursorQuery, JobsDep, NewestFirstQuery, TemplatesDep, job_page
from skiros_py.server.services import ServicesDep
from skiros_py.station.jobs.accounts import response_of
from skiros_py.world.vocabulary import MANIPULATABLE

__all__ = ["router"]

router = APIRouter()

_NEEDS = [needs(Role.VIEWER, mes=True)]


@router.get("/capabilities", summary="What may be ordered here", dependencies=_NEEDS)
def get_capabilities(services: ServicesDep, jobs: JobsDep, templates: TemplatesDep) -> JobCapabilities:
    """Lists what an order may name: goal templates, classes of material, robots; and how many orders are taken."""
    session = services.session
    return JobCapabilities(
        work_masters=tuple(
            WorkMaster(
                id=one.name,
                version=one.version,
                description=one.content.description,
                parameters=one.content.parameters,
            )
            for one in templates.all()
        ),
        material_class_ids=tuple(sorted(session.world.ontology.subclasses(MANIPULATABLE))),
        equipment_ids=tuple(robot.id for robot in session.spec.robots),
        max_downloadable_job_orders=jobs.limit,
        open_job_orders=len(jobs.open),
    )


@router.get("/job-responses", summary="What jobs have come to (ISA-95 job responses)", dependencies=_NEEDS)
def list_job_responses(
    jobs: JobsDep,
    state: Annotated[list[StateName] | None, Query(max_length=6, description="Of jobs in these states only.")] = None,
    since: Annotated[WantedMoment | None, Query(description="Of those only that changed since then.")] = None,
    limit: Annotated[int, Query(ge=1, le=100, description="How many at most.")] = 100,
    cursor: CursorQuery = None,
    newest_first: NewestFirstQuery = False,
) -> JobResponses:
    """Lists the job responses of the jobs that were not removed, in the order in which they were ordered."""
    page, now = job_page(jobs, state, since, limit, cursor, newest_first=newest_first), time.time()
    return JobResponses(
        items=tuple(response_of(jobs, job, now) for job in page.jobs),
        next=None if page.next is None else str(page.next),
    )

"""Routes: what a factory system asks of all jobs: what may be ordered, and what has come of what was."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query

from skiros_py.api.jobs import JobCapabilities, JobResponses, StateName
from skiros_py.api.wire import WantedMoment
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.routes.job_access import CursorQuery, NewestFirstQuery
from skiros_py.server.services import StationDep

router = APIRouter()

_NEEDS = [needs(Role.VIEWER, mes=True)]


@router.get("/capabilities", summary="What may be ordered here", dependencies=_NEEDS)
def get_capabilities(station: StationDep) -> JobCapabilities:
    """Lists what an order may name: goal templates, classes of material, robots; and how many orders are taken."""
    return station.jobs.capabilities()


@router.get("/job-responses", summary="What jobs have come to (ISA-95 job responses)", dependencies=_NEEDS)
def list_job_responses(
    station: StationDep,
    state: Annotated[list[StateName] | None, Query(max_length=6, description="Of jobs in these states only.")] = None,
    since: Annotated[WantedMoment | None, Query(description="Of those only that changed since then.")] = None,
    limit: Annotated[int, Query(ge=1, le=100, description="How many at most.")] = 100,
    cursor: CursorQuery = None,
    newest_first: NewestFirstQuery = False,
) -> JobResponses:
    """Lists the job responses of the jobs that were not removed, in the order in which they were ordered."""
    after = None if cursor is None else int(cursor)
    return station.jobs.responses(state, since, limit, after, newest_first=newest_first)

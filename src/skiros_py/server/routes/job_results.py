"""Routes: what jobs do and have done, and what may be ordered."""

from __future__ import annotations

import gzip
import math
import re
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Header, Query, Response
from fastapi.responses import FileResponse

from skiros_py.api.jobs import (
    JobCapabilities,
    JobExplanation,
    JobPlan,
    JobReport,
    JobResponse,
    JobResponses,
    JobTrace,
    JobTransitions,
    StateName,
)
from skiros_py.api.view import Replay
from skiros_py.api.wire import WantedMoment
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.routes.job_commands import CursorQuery, JobId, NewestFirstQuery
from skiros_py.server.services import StationDep

router = APIRouter()

_NEEDS = [needs(Role.VIEWER, mes=True)]
_GZIP = re.compile(r"(?:^|[,\s])(?:gzip|\*)\s*(?!\s*;\s*q=0(?:\.0*)?\s*(?:,|$))")
_LEVEL = 5
_Time = partial(Query, ge=0.0, allow_inf_nan=False)


@router.get("/jobs/{id}/response", dependencies=_NEEDS)
def get_job_response(job: JobId, station: StationDep) -> JobResponse:
    """Get the result of a job (ISA-95 job response).

    Returns what was done with which material, by which skills, in which states, and why not if it was not done.
    """
    return station.jobs.response(job)


@router.get("/jobs/{id}/plan", dependencies=_NEEDS)
def get_job_plan(job: JobId, station: StationDep) -> JobPlan:
    """Get the plan of a job.

    Returns the steps of the last plan, with what each waits for; empty if there is none (yet).
    """
    return station.jobs.plan(job)


@router.get("/jobs/{id}/trace", dependencies=_NEEDS)
def get_job_trace(
    job: JobId,
    station: StationDep,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
    cursor: Annotated[str, Query(pattern=r"^\d{1,15}$")] = "0",
) -> JobTrace:
    """Get the trace of a job.

    Lists what happened, as text and as data; for a running job, the last second may be missing.
    """
    return station.jobs.trace(job, int(cursor), limit)


@router.get("/jobs/{id}/report", dependencies=_NEEDS)
def get_job_report(job: JobId, station: StationDep) -> JobReport:
    """Get the report of a job.

    Returns the outcome of each condition and of each step, as `skiros run` does.
    """
    return station.jobs.report(job)


@router.get("/jobs/{id}/transitions", dependencies=_NEEDS)
def get_job_transitions(job: JobId, station: StationDep) -> JobTransitions:
    """List the state changes of a job.

    Lists the states that a job went through: when, who requested it, and why.
    """
    return station.jobs.transitions(job)


@router.get("/jobs/{id}/explanation", dependencies=_NEEDS)
def get_job_explanation(job: JobId, station: StationDep) -> JobExplanation:
    """Explain why there is no plan.

    Returns why there is no plan for a job, and what would help; empty if there is one, or planning has not started.
    """
    return station.jobs.explanation(job)


@router.get(
    "/jobs/{id}/replay",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses={200: {"model": Replay, "description": "The job as it was seen; compressed where that is accepted."}},
)
def get_job_replay(
    job: JobId,
    station: StationDep,
    start: float = 0.0,
    end: float | None = None,
    accept_encoding: Annotated[str, Header(max_length=1000)] = "",
) -> Response:
    """What a job looked like.

    Shows a job that runs or ran as moving pictures: the world at its beginning, what changed, where the robots were.

    A range of time begins with the world at that time, and has the frames just before and after it as well.
    Of a job that runs, the last seconds may be missing. Replays are kept for the last 200 jobs, and go with the job.

    Parameters:
        start: From this run time on [s].
        end: Up to this run time [s]; left out: to the end.
    """
    text = station.recordings.replay(job, start, math.inf if end is None else end)
    headers = {"Cache-Control": "no-cache", "Vary": "Accept-Encoding"}
    if _GZIP.search(accept_encoding):
        text = gzip.compress(text, _LEVEL)
        headers["Content-Encoding"] = "gzip"
    return Response(text, media_type="application/json", headers=headers)


@router.get(
    "/jobs/{id}/recording",
    dependencies=[needs(Role.VIEWER)],
    response_class=FileResponse,
    responses={200: {"content": {"application/octet-stream": {}}, "description": "An MCAP file."}},
)
def get_job_recording(job: JobId, station: StationDep) -> FileResponse:
    """The recording of a job.

    Downloads the recording of a job that runs or ran, for Foxglove and other programs; takes requests for ranges.

    Of a job that runs, the last second may be missing, and the file has no index yet. It is deleted with the job.
    """
    path = station.recordings.path(job)
    return FileResponse(path, media_type="application/octet-stream", filename=path.name)


@router.get("/capabilities", dependencies=_NEEDS)
def get_capabilities(station: StationDep) -> JobCapabilities:
    """List what can be ordered.

    Lists what an order may name: goal templates, material classes, robots; and the maximum number of orders.
    """
    return station.jobs.capabilities()


@router.get("/job-responses", dependencies=_NEEDS)
def list_job_responses(
    station: StationDep,
    state: Annotated[list[StateName] | None, Query(max_length=6)] = None,
    since: WantedMoment | None = None,
    limit: Annotated[int, Query(ge=1, le=100)] = 100,
    cursor: CursorQuery = None,
    newest_first: NewestFirstQuery = False,
) -> JobResponses:
    """List the results of jobs (ISA-95 job responses).

    Lists the job responses of all jobs that were not removed, in the order in which they were ordered.

    Parameters:
        state: Only jobs in these states.
        since: Only jobs changed since then.
    """
    after = None if cursor is None else int(cursor)
    return station.jobs.responses(state, since, limit, after, newest_first=newest_first)

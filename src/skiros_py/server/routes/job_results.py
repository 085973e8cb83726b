"""Routes: what jobs do and have done, and what may be ordered."""

from __future__ import annotations

import gzip
import math
import re
from functools import partial
from typing import Annotated

from fastapi import Header, Query, Response
from fastapi.responses import FileResponse

from skiros_py.api import jobs as api
from skiros_py.api.view import Replay
from skiros_py.api.wire import WantedMoment
from skiros_py.server.access.roles import Viewer, ViewerOrMes
from skiros_py.server.problems import topic_router
from skiros_py.server.routes.job_commands import CursorQuery, JobId, NewestFirstQuery

router = topic_router("jobs")

_GZIP = re.compile(r"(?:^|[,\s])(?:gzip|\*)\s*(?!\s*;\s*q=0(?:\.0*)?\s*(?:,|$))")
_LEVEL = 5
_Time = partial(Query, ge=0.0, allow_inf_nan=False)


@router.get("/jobs/{id}/response")
def get_job_response(act: ViewerOrMes, job: JobId) -> api.JobResponse:
    """Get the result of a job (ISA-95 job response).

    Returns what was done with which material, by which skills, in which states, and why not if it was not done.
    """
    return act.station.jobs.response(job)


@router.get("/jobs/{id}/plan")
def get_job_plan(act: ViewerOrMes, job: JobId) -> api.JobPlan:
    """Get the plan of a job.

    Returns the steps of the last plan, with what each waits for; empty if there is none (yet).
    """
    return act.station.jobs.plan(job)


@router.get("/jobs/{id}/trace")
def get_job_trace(
    act: ViewerOrMes,
    job: JobId,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
    cursor: Annotated[str, Query(pattern=r"^\d{1,15}$")] = "0",
) -> api.JobTrace:
    """Get the trace of a job.

    Lists what happened, as text and as data; for a running job, the last second may be missing.
    """
    return act.station.jobs.trace(job, int(cursor), limit)


@router.get("/jobs/{id}/report")
def get_job_report(act: ViewerOrMes, job: JobId) -> api.JobReport:
    """Get the report of a job.

    Returns the outcome of each condition and of each step, as `skiros run` does.
    """
    return act.station.jobs.report(job)


@router.get("/jobs/{id}/transitions")
def get_job_transitions(act: ViewerOrMes, job: JobId) -> api.JobTransitions:
    """List the state changes of a job.

    Lists the states that a job went through: when, who requested it, and why.
    """
    return act.station.jobs.transitions(job)


@router.get("/jobs/{id}/explanation")
def get_job_explanation(act: ViewerOrMes, job: JobId) -> api.JobExplanation:
    """Explain why there is no plan.

    Returns why there is no plan for a job, and what would help; empty if there is one, or planning has not started.
    """
    return act.station.jobs.explanation(job)


@router.get(
    "/jobs/{id}/replay",
    response_class=Response,
    responses={200: {"model": Replay, "description": "The job as it was seen; compressed where that is accepted."}},
)
def get_job_replay(
    act: Viewer,
    job: JobId,
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
    text = act.station.recordings.replay(job, start, math.inf if end is None else end)
    headers = {"Cache-Control": "no-cache", "Vary": "Accept-Encoding"}
    if _GZIP.search(accept_encoding):
        text = gzip.compress(text, _LEVEL)
        headers["Content-Encoding"] = "gzip"
    return Response(text, media_type="application/json", headers=headers)


@router.get(
    "/jobs/{id}/recording",
    response_class=FileResponse,
    responses={200: {"content": {"application/octet-stream": {}}, "description": "An MCAP file."}},
)
def get_job_recording(act: Viewer, job: JobId) -> FileResponse:
    """The recording of a job.

    Downloads the recording of a job that runs or ran, for Foxglove and other programs; takes requests for ranges.

    Of a job that runs, the last second may be missing, and the file has no index yet. It is deleted with the job.
    """
    path = act.station.recordings.path(job)
    return FileResponse(path, media_type="application/octet-stream", filename=path.name)


@router.get("/capabilities")
def get_capabilities(act: ViewerOrMes) -> api.JobCapabilities:
    """List what can be ordered.

    Lists what an order may name: goal templates, material classes, robots; and the maximum number of orders.
    """
    return act.station.jobs.capabilities()


@router.get("/job-responses")
def list_job_responses(
    act: ViewerOrMes,
    state: Annotated[list[api.StateName] | None, Query(max_length=6)] = None,
    since: WantedMoment | None = None,
    limit: Annotated[int, Query(ge=1, le=100)] = 100,
    cursor: CursorQuery = None,
    newest_first: NewestFirstQuery = False,
) -> api.JobResponses:
    """List the results of jobs (ISA-95 job responses).

    Lists the job responses of all jobs that were not removed, in the order in which they were ordered.

    Parameters:
        state: Only jobs in these states.
        since: Only jobs changed since then.
    """
    after = None if cursor is None else int(cursor)
    return act.station.jobs.responses(states=state, since=since, limit=limit, after=after, newest_first=newest_first)

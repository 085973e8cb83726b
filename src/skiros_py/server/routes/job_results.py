"""Routes: what a job does and has done."""

from __future__ import annotations

import gzip
import re
import time
from typing import Annotated

from fastapi import APIRouter, Header, Query, Response
from fastapi.responses import FileResponse

from skiros_py.api.jobs import JobExplanation, JobPlan, JobReport, JobResponse, JobTrace, JobTransitions
from skiros_py.api.replays import Replay
from skiros_py.errors import FileError
from skiros_py.server.access.roles import Role, needs
from skiros_py.server.job_faults import job_faults
from skiros_py.server.problems import Problem
from skiros_py.server.routes.job_access import JobId, JobsDep
from skiros_py.server.services import ServicesDep
from skiros_py.station.jobs.accounts import explanation_of, plan_of, planned_steps, report_of, response_of
from skiros_py.station.jobs.views import transitions_view
from skiros_py.station.recordings.replay import replay_text
from skiros_py.tasks.jobs import Job

__all__ = ["router"]

router = APIRouter()

_NEEDS = [needs(Role.VIEWER, mes=True)]
_GZIP = re.compile(r"(?:^|[,\s])(?:gzip|\*)\s*(?!\s*;\s*q=0(?:\.0*)?\s*(?:,|$))")
_LEVEL = 5


@router.get("/jobs/{id}/response", summary="What a job has come to (ISA-95 job response)", dependencies=_NEEDS)
def get_job_response(id: JobId, jobs: JobsDep) -> JobResponse:  # noqa: A002 - the name in the address
    """Says what was done to which part, by which skills, in which states, and why not where it was not."""
    with job_faults():
        return response_of(jobs, jobs.job(id), time.time())


@router.get("/jobs/{id}/plan", summary="The last plan of a job", dependencies=_NEEDS)
def get_job_plan(id: JobId, jobs: JobsDep, services: ServicesDep) -> JobPlan:  # noqa: A002 - the name in the address
    """Shows the steps of the last plan, with what each waits for; empty where there is none (yet)."""
    with job_faults():
        job = jobs.job(id)
        running = next((task for task in services.session.tasks.active if task.name == id), None)
        if running is not None and running.plan is not None:  # younger than what is written down
            return JobPlan(steps=planned_steps(running.plan))
        return plan_of(job, jobs.trace(id))


@router.get("/jobs/{id}/trace", summary="What happened for a job", dependencies=_NEEDS)
def get_job_trace(
    id: JobId,  # noqa: A002 - the name in the address
    jobs: JobsDep,
    limit: Annotated[int, Query(ge=1, le=1000, description="How many at most.")] = 100,
    cursor: Annotated[str, Query(pattern=r"^\d{1,15}$", description="The `next` of the page before.")] = "0",
) -> JobTrace:
    """Lists what happened, in sentences and as data; of what runs, the last second may be missing."""
    with job_faults():
        entries = jobs.trace(id, skip=int(cursor), limit=limit + 1)
    return JobTrace(
        entries=tuple(dict(entry) for entry in entries[:limit]),
        next=str(int(cursor) + limit) if len(entries) > limit else None,
    )


@router.get("/jobs/{id}/report", summary="The report of a job", dependencies=_NEEDS)
def get_job_report(id: JobId, jobs: JobsDep) -> JobReport:  # noqa: A002 - the name in the address
    """Reports what came of each condition and of each step, as `skiros run` does."""
    with job_faults():
        return report_of(jobs.job(id), jobs.trace(id), time.time())


@router.get("/jobs/{id}/transitions", summary="The changes of state of a job", dependencies=_NEEDS)
def get_job_transitions(id: JobId, jobs: JobsDep) -> JobTransitions:  # noqa: A002 - the name in the address
    """Lists the states that a job went through: when, and who wanted it and why."""
    with job_faults():
        return JobTransitions(transitions=transitions_view(jobs.transitions(id)))


@router.get("/jobs/{id}/explanation", summary="Why there is no plan", dependencies=_NEEDS)
def get_job_explanation(id: JobId, jobs: JobsDep) -> JobExplanation:  # noqa: A002 - the name in the address
    """Says why there is no plan for a job, and what would help; empty where there is one, or nobody has looked yet."""
    with job_faults():
        return explanation_of(jobs.job(id), jobs.trace(id))


@router.get(
    "/jobs/{id}/replay",
    summary="What a job looked like",
    dependencies=[needs(Role.VIEWER)],
    response_class=Response,
    responses={200: {"model": Replay, "description": "The job as it was seen; compressed where that is accepted."}},
)
def get_job_replay(
    id: JobId,  # noqa: A002 - the name in the address
    jobs: JobsDep,
    services: ServicesDep,
    accept_encoding: Annotated[str, Header(max_length=1000)] = "",
) -> Response:
    """Shows a job that runs or ran as moving pictures: the world at its beginning, what changed, where the robots were.

    Of a job that runs, the last seconds may be missing. Replays are kept for the last 200 jobs, and go with the job.
    """
    with job_faults():
        job = jobs.job(id)
    try:
        with services.recordings.read(job.number) as recording:
            text = replay_text(recording, over=not job.state.is_open)
    except (FileError, ValueError, KeyError) as error:
        raise _no_replay(job, error) from None
    headers = {"Cache-Control": "no-cache", "Vary": "Accept-Encoding"}
    if _GZIP.search(accept_encoding):
        text = gzip.compress(text, _LEVEL)
        headers["Content-Encoding"] = "gzip"
    return Response(text, media_type="application/json", headers=headers)


@router.get(
    "/jobs/{id}/recording",
    summary="The recording of a job",
    dependencies=[needs(Role.VIEWER)],
    response_class=FileResponse,
    responses={200: {"content": {"application/octet-stream": {}}, "description": "An MCAP file."}},
)
def get_job_recording(
    id: JobId,  # noqa: A002 - the name in the address
    jobs: JobsDep,
    services: ServicesDep,
) -> FileResponse:
    """Downloads the recording of a job that runs or ran, for Foxglove and other programs; takes requests for ranges.

    Of a job that runs, the last second may be missing, and the file has no index yet. It is deleted with the job.
    """
    with job_faults():
        job = jobs.job(id)
    path = services.recordings.path(job.number)
    if not path.is_file():
        raise _no_replay(job, FileError(path, "there is no such recording"))
    return FileResponse(path, media_type="application/octet-stream", filename=f"{job.number:09d}.mcap")


def _no_replay(job: Job, error: Exception) -> Problem:
    if job.started is None:
        why = "it has not begun" if job.state.is_open else "it never began"
    elif job.state.is_open:
        why = "nothing is written down yet: ask again in some seconds"
    else:
        why = f"it is kept no longer, or never was ({error}): there is room for those of the last jobs only"
    return Problem(404, "NoReplay", f"there is no replay of job '{job.id}': {why}")

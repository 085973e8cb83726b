"""Routes: commands to jobs. Each may be repeated: one that has already had its effect changes nothing."""

from __future__ import annotations

from typing import Annotated, TypedDict
from urllib.parse import quote

from fastapi import APIRouter, Body, Depends, Path, Query, Request, Response

from skiros_py.api.jobs import AcceptedJob, Job, JobAnswer, JobComment
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.problems import SeenDep, tagged, with_etag
from skiros_py.server.services import StationDep
from skiros_py.station.requests import Author

JobId = Annotated[
    str, Path(alias="id", min_length=1, max_length=200, description="Id of the job.", examples=["line-1-kit-4711"])
]
CursorQuery = Annotated[str | None, Query(pattern=r"^\d{1,15}$")]
NewestFirstQuery = Annotated[bool, Query(description="From the newest job backwards.")]


async def _expected(seen: SeenDep) -> int | None:  # asynchronous to spare each request a turn in the thread pool
    return None if seen is None else seen.version


ExpectedDep = Annotated[int | None, Depends(_expected)]
"""For routes: the version that the caller has seen; None for any."""


def job_location(id_: str) -> str:
    """Returns the address of a job."""
    return f"/api/v1/jobs/{quote(id_, safe='')}"


def accepted(job: Job, response: Response) -> AcceptedJob:
    """Returns a job in answer to an order or a command, with its version in the head of the answer."""
    return AcceptedJob.model_construct(**dict(shown(job, response)))


def shown(job: Job, response: Response) -> Job:
    """Returns a job, with its version in the head of the answer."""
    return with_etag(job, response)


router = APIRouter(responses=tagged())

_NEEDS = [needs(Role.OPERATOR, mes=True)]
_NO_COMMENT = JobComment()


class _Wish(TypedDict):
    comment: str
    expects: int | None
    author: Author


def _wish(
    job: JobId,
    request: Request,
    caller: CallerDep,
    expected: ExpectedDep,
    body: Annotated[JobComment, Body(description="Reason; optional.")] = _NO_COMMENT,
) -> _Wish:
    """Reads who commands a job and why, and notes it for the audit log: a removed job takes its record along."""
    note(request, job=job, comment=body.comment)
    return {"comment": body.comment, "expects": expected, "author": caller.author}


WishDep = Annotated[_Wish, Depends(_wish)]
"""For routes: who commands, why, and which version of the job they have seen."""


@router.post("/jobs/{id}/start", dependencies=_NEEDS)
def start_job(job: JobId, station: StationDep, wish: WishDep, response: Response) -> AcceptedJob:
    """Allow a job to start.

    Allows a job to start when its turn comes.
    """
    return accepted(station.jobs.command(job, "start", **wish), response)


@router.post("/jobs/{id}/revoke-start", dependencies=_NEEDS)
def revoke_start_of_job(job: JobId, station: StationDep, wish: WishDep, response: Response) -> AcceptedJob:
    """Revoke the permission to start.

    Prevents a job from starting until it is allowed to start again.
    """
    return accepted(station.jobs.command(job, "revoke_start", **wish), response)


@router.post("/jobs/{id}/pause", dependencies=_NEEDS)
def pause_job(job: JobId, station: StationDep, wish: WishDep, response: Response) -> AcceptedJob:
    """Pause a job.

    Pauses a job: everything that it moves comes to a standstill.
    """
    return accepted(station.jobs.command(job, "pause", **wish), response)


@router.post("/jobs/{id}/resume", dependencies=_NEEDS)
def resume_job(job: JobId, station: StationDep, wish: WishDep, response: Response) -> AcceptedJob:
    """Resume a job.

    Resumes a paused job; a job that waits for an answer continues when it is answered.
    """
    return accepted(station.jobs.command(job, "resume", **wish), response)


@router.post("/jobs/{id}/stop", dependencies=_NEEDS)
def stop_job(job: JobId, station: StationDep, wish: WishDep, response: Response) -> AcceptedJob:
    """Stop a job.

    Ends a running job in an orderly way; it is over when everything that it moved stands still.
    """
    return accepted(station.jobs.command(job, "stop", **wish), response)


@router.post("/jobs/{id}/abort", dependencies=_NEEDS)
def abort_job(job: JobId, station: StationDep, wish: WishDep, response: Response) -> AcceptedJob:
    """Abort a job.

    Ends a job, started or not; it is over when everything that it moved stands still.
    """
    return accepted(station.jobs.command(job, "abort", **wish), response)


@router.post("/jobs/{id}/cancel", dependencies=_NEEDS)
def cancel_job(job: JobId, station: StationDep, wish: WishDep, response: Response) -> AcceptedJob:
    """Remove a job that has not started.

    Removes a job that has not started, and returns its last state.
    """
    return accepted(station.jobs.command(job, "cancel", **wish), response)


@router.post("/jobs/{id}/clear", dependencies=_NEEDS)
def clear_job(job: JobId, station: StationDep, wish: WishDep, response: Response) -> AcceptedJob:
    """Remove a job that is over.

    Confirms that the result was fetched: removes a job that is over, with all its data.
    """
    return accepted(station.jobs.command(job, "clear", **wish), response)


@router.delete("/jobs/{id}", dependencies=_NEEDS)
def remove_job(
    job: JobId,
    request: Request,
    station: StationDep,
    expected: ExpectedDep,
    response: Response,
    comment: Annotated[str, Query(max_length=1000)] = "",
) -> AcceptedJob:
    """Remove a job.

    Removes a job that has not started or is over: cancel or clear, whichever applies.

    Parameters:
        comment: Reason, for the audit log.
    """
    note(request, job=job, comment=comment)
    return accepted(station.jobs.command(job, "remove", expects=expected), response)


@router.post("/jobs/{id}/answer", dependencies=_NEEDS)
def answer_job(
    job: JobId,
    body: JobAnswer,
    request: Request,
    station: StationDep,
    caller: CallerDep,
    expected: ExpectedDep,
    response: Response,
) -> AcceptedJob:
    """Answer a job's question.

    Answers the question for which a job waits, with one of its `choices`.
    """
    note(request, job=job, comment=body.answer)
    return accepted(station.jobs.answer(job, body, expects=expected, author=caller.author), response)

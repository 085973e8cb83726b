"""Routes: commands to jobs. Each may be sent again: where it has had its effect, nothing happens."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Depends, Query, Request, Response

from skiros_py.api.jobs import AcceptedJob, JobAnswer, JobComment
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import CallerDep, Role, needs
from skiros_py.server.etags import tagged
from skiros_py.server.job_faults import job_faults
from skiros_py.server.routes.job_access import ExpectedDep, JobId, accepted
from skiros_py.server.services import StationDep

router = APIRouter(responses=tagged())

_NEEDS = [needs(Role.OPERATOR, mes=True)]
_NO_COMMENT = JobComment()


def _comment(
    id: JobId,  # noqa: A002 - the name in the address
    request: Request,
    body: Annotated[JobComment, Body(description="Why; may be left out.")] = _NO_COMMENT,
) -> str:
    """Takes what somebody says about a command, for the audit log too: with a removed job goes its record."""
    note(request, job=id, comment=body.comment)
    return body.comment


CommentDep = Annotated[str, Depends(_comment)]
"""For routes: why."""


@router.post("/jobs/{id}/start", summary="Give a job leave to start", dependencies=_NEEDS)
def start_job(
    id: JobId,  # noqa: A002 - the name in the address
    station: StationDep,
    caller: CallerDep,
    expected: ExpectedDep,
    response: Response,
    comment: CommentDep,
) -> AcceptedJob:
    """Lets a job start by itself when its turn comes."""
    with job_faults():
        job = station.jobs.command(id, "start", comment=comment, expects=expected, author=caller.author)
        return accepted(job, response)


@router.post("/jobs/{id}/revoke-start", summary="Take back the leave to start", dependencies=_NEEDS)
def revoke_start_of_job(
    id: JobId,  # noqa: A002 - the name in the address
    station: StationDep,
    caller: CallerDep,
    expected: ExpectedDep,
    response: Response,
    comment: CommentDep,
) -> AcceptedJob:
    """Keeps a job that has not begun until somebody gives leave to start again."""
    with job_faults():
        job = station.jobs.command(id, "revoke_start", comment=comment, expects=expected, author=caller.author)
        return accepted(job, response)


@router.post("/jobs/{id}/pause", summary="Let a job stand for a while", dependencies=_NEEDS)
def pause_job(
    id: JobId,  # noqa: A002 - the name in the address
    station: StationDep,
    caller: CallerDep,
    expected: ExpectedDep,
    response: Response,
    comment: CommentDep,
) -> AcceptedJob:
    """Lets a job come to a standstill where it is."""
    with job_faults():
        job = station.jobs.command(id, "pause", comment=comment, expects=expected, author=caller.author)
        return accepted(job, response)


@router.post("/jobs/{id}/resume", summary="Go on with a job that stands", dependencies=_NEEDS)
def resume_job(
    id: JobId,  # noqa: A002 - the name in the address
    station: StationDep,
    caller: CallerDep,
    expected: ExpectedDep,
    response: Response,
    comment: CommentDep,
) -> AcceptedJob:
    """Goes on with a job that stands; what waits for an answer goes on with that."""
    with job_faults():
        job = station.jobs.command(id, "resume", comment=comment, expects=expected, author=caller.author)
        return accepted(job, response)


@router.post("/jobs/{id}/stop", summary="End a job in good order", dependencies=_NEEDS)
def stop_job(
    id: JobId,  # noqa: A002 - the name in the address
    station: StationDep,
    caller: CallerDep,
    expected: ExpectedDep,
    response: Response,
    comment: CommentDep,
) -> AcceptedJob:
    """Ends a job that is under way; it is over when everything that it moved stands."""
    with job_faults():
        job = station.jobs.command(id, "stop", comment=comment, expects=expected, author=caller.author)
        return accepted(job, response)


@router.post("/jobs/{id}/abort", summary="Give a job up", dependencies=_NEEDS)
def abort_job(
    id: JobId,  # noqa: A002 - the name in the address
    station: StationDep,
    caller: CallerDep,
    expected: ExpectedDep,
    response: Response,
    comment: CommentDep,
) -> AcceptedJob:
    """Gives a job up, begun or not; it is over when everything that it moved stands."""
    with job_faults():
        job = station.jobs.command(id, "abort", comment=comment, expects=expected, author=caller.author)
        return accepted(job, response)


@router.post("/jobs/{id}/cancel", summary="Remove a job that has not begun", dependencies=_NEEDS)
def cancel_job(
    id: JobId,  # noqa: A002 - the name in the address
    station: StationDep,
    expected: ExpectedDep,
    response: Response,
    comment: CommentDep,
) -> AcceptedJob:
    """Removes a job that has not begun, and answers with what it was."""
    del comment  # the audit log has it
    with job_faults():
        return accepted(station.jobs.command(id, "cancel", expects=expected), response)


@router.post("/jobs/{id}/clear", summary="Remove a job that is over", dependencies=_NEEDS)
def clear_job(
    id: JobId,  # noqa: A002 - the name in the address
    station: StationDep,
    expected: ExpectedDep,
    response: Response,
    comment: CommentDep,
) -> AcceptedJob:
    """Says that its result was fetched: removes a job that is over with all that is known of it."""
    del comment  # the audit log has it
    with job_faults():
        return accepted(station.jobs.command(id, "clear", expects=expected), response)


@router.delete("/jobs/{id}", summary="Remove a job", dependencies=_NEEDS)
def remove_job(
    id: JobId,  # noqa: A002 - the name in the address
    request: Request,
    station: StationDep,
    expected: ExpectedDep,
    response: Response,
    comment: Annotated[str, Query(max_length=1000, description="Why, for the audit log.")] = "",
) -> AcceptedJob:
    """Removes a job that has not begun, or is over: cancel or clear, whichever fits."""
    note(request, job=id, comment=comment)
    with job_faults():
        return accepted(station.jobs.command(id, "remove", expects=expected), response)


@router.post("/jobs/{id}/answer", summary="Answer what a job waits for", dependencies=_NEEDS)
def answer_job(
    id: JobId,  # noqa: A002 - the name in the address
    body: JobAnswer,
    request: Request,
    station: StationDep,
    caller: CallerDep,
    expected: ExpectedDep,
    response: Response,
) -> AcceptedJob:
    """Answers what a job waits for: with one of its `choices`."""
    note(request, job=id, comment=body.answer)
    with job_faults():
        return accepted(station.jobs.answer(id, body, expects=expected, author=caller.author), response)

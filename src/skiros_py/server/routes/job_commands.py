"""Routes: commands to jobs. Each may be repeated: one that has already had its effect changes nothing."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Body, Depends, Path, Query

from skiros_py.api.jobs import AcceptedJob, Job, JobAnswer, JobComment
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import Act, OperatorOrMes
from skiros_py.server.problems import SeenDep, tagged, topic_router

JobId = Annotated[
    str, Path(alias="id", min_length=1, max_length=200, description="Id of the job.", examples=["line-1-kit-4711"])
]
CursorQuery = Annotated[str | None, Query(pattern=r"^\d{1,15}$")]
NewestFirstQuery = Annotated[bool, Query(description="From the newest job backwards.")]


def accepted(act: Act, job: Job) -> AcceptedJob:
    """Returns a job in answer to an order or a command, with its version in the headers of the answer."""
    return AcceptedJob.model_construct(**dict(act.tagged(job)))


router = topic_router("jobs", responses=tagged())

_NO_COMMENT = JobComment()


def _wish(
    act: OperatorOrMes,
    job: JobId,
    seen: SeenDep,
    body: Annotated[JobComment, Body(description="Reason; optional.")] = _NO_COMMENT,
) -> dict[str, Any]:
    """Reads who commands a job and why, and notes it for the audit log: a removed job takes its record along."""
    note(act.request, job=job, comment=body.comment)
    return {"comment": body.comment, "expects": seen.version if seen else None, "author": act.author}


WishDep = Annotated[dict[str, Any], Depends(_wish)]
"""For routes: who commands, why, and which version of the job they have seen."""


@router.post("/jobs/{id}/start")
def start_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> AcceptedJob:
    """Allow a job to start.

    Allows a job to start when its turn comes.
    """
    return accepted(act, act.station.jobs.command(job, "start", **wish))


@router.post("/jobs/{id}/revoke-start")
def revoke_start_of_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> AcceptedJob:
    """Revoke the permission to start.

    Prevents a job from starting until it is allowed to start again.
    """
    return accepted(act, act.station.jobs.command(job, "revoke_start", **wish))


@router.post("/jobs/{id}/pause")
def pause_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> AcceptedJob:
    """Pause a job.

    Pauses a job: everything that it moves comes to a standstill.
    """
    return accepted(act, act.station.jobs.command(job, "pause", **wish))


@router.post("/jobs/{id}/resume")
def resume_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> AcceptedJob:
    """Resume a job.

    Resumes a paused job; a job that waits for an answer continues when it is answered.
    """
    return accepted(act, act.station.jobs.command(job, "resume", **wish))


@router.post("/jobs/{id}/stop")
def stop_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> AcceptedJob:
    """Stop a job.

    Ends a running job in an orderly way; it is over when everything that it moved stands still.
    """
    return accepted(act, act.station.jobs.command(job, "stop", **wish))


@router.post("/jobs/{id}/abort")
def abort_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> AcceptedJob:
    """Abort a job.

    Ends a job, started or not; it is over when everything that it moved stands still.
    """
    return accepted(act, act.station.jobs.command(job, "abort", **wish))


@router.post("/jobs/{id}/cancel")
def cancel_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> AcceptedJob:
    """Remove a job that has not started.

    Removes a job that has not started, and returns its last state.
    """
    return accepted(act, act.station.jobs.command(job, "cancel", **wish))


@router.post("/jobs/{id}/clear")
def clear_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> AcceptedJob:
    """Remove a job that is over.

    Confirms that the result was fetched: removes a job that is over, with all its data.
    """
    return accepted(act, act.station.jobs.command(job, "clear", **wish))


@router.delete("/jobs/{id}")
def remove_job(
    act: OperatorOrMes,
    job: JobId,
    seen: SeenDep,
    comment: Annotated[str, Query(max_length=1000)] = "",
) -> AcceptedJob:
    """Remove a job.

    Removes a job that has not started or is over: cancel or clear, whichever applies.

    Parameters:
        comment: Reason, for the audit log.
    """
    note(act.request, job=job, comment=comment)
    return accepted(act, act.station.jobs.command(job, "remove", expects=seen.version if seen else None))


@router.post("/jobs/{id}/answer")
def answer_job(
    act: OperatorOrMes,
    job: JobId,
    body: JobAnswer,
    seen: SeenDep,
) -> AcceptedJob:
    """Answer a job's question.

    Answers the question for which a job waits, with one of its `choices`.
    """
    note(act.request, job=job, comment=body.answer)
    return accepted(act, act.station.jobs.answer(job, body, expects=seen.version if seen else None, author=act.author))

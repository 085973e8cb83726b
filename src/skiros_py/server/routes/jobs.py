"""Routes: jobs. Ordering and looking; commands, each of which may be repeated; and what jobs do and have done."""

from __future__ import annotations

import gzip
import math
import re
from typing import Annotated, Any

from fastapi import Body, Depends, Header, Path, Query, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import FileResponse

from skiros_py.api import jobs as api
from skiros_py.api.view import Replay
from skiros_py.api.wire import WantedMoment
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import Act, OperatorOrMes, Viewer, ViewerOrMes
from skiros_py.server.problems import Problem, SeenDep, also_refused, tagged, topic_router
from skiros_py.station.jobs.views import is_open

JobId = Annotated[
    str, Path(alias="id", min_length=1, max_length=200, description="Id of the job.", examples=["line-1-kit-4711"])
]
CursorQuery = Annotated[str | None, Query(pattern=r"^\d{1,15}$")]
NewestFirstQuery = Annotated[bool, Query(description="From the newest job backwards.")]

router = topic_router("jobs")

_LONGEST_WAIT = 30
_WAIT = re.compile(r'(?:^|[,;\s])wait\s*=\s*"?(\d{1,6})"?')
_KEY = re.compile(r'"?([\x21\x23-\x5b\x5d-\x7e]{1,200})"?')
"""A key in printable characters, with the quotes of a structured field or without."""
_TAKEN: dict[int | str, dict[str, Any]] = {
    200: {"model": api.AcceptedJob, "description": "The job existed already, or is over (Prefer: wait)."}
}

_REMOVED = also_refused(410, "The job of this order was removed (`last`).")

StartQuery = Annotated[bool, Query(description="False to hold the job until it is allowed to start.")]
AgainQuery = Annotated[bool, Query(description="Accept the order although a job with this id was removed.")]
PreferHeader = Annotated[
    str | None,
    Header(max_length=200, description="wait=N: respond when the job is over or paused, after N s at the latest."),
]


@router.post("/jobs", status_code=202, responses=_TAKEN | _REMOVED)
async def order_job(
    act: OperatorOrMes,
    order: api.JobOrder,
    start: StartQuery = True,
    again: AgainQuery = False,
    idempotency_key: Annotated[str | None, Header(max_length=202)] = None,
    prefer: PreferHeader = None,
) -> api.AcceptedJob:
    """Order a job.

    Accepts a job order, which is on disk when this responds; it is planned later.

    Without an id, the server generates one; an `Idempotency-Key` makes that repeatable for at least 24 h.

    Parameters:
        idempotency-key: Identifies the request: repeating it does not create a second job.
    """
    key, holder = _key_of(idempotency_key), act.caller.key or act.caller.name
    ordered = act.station.jobs.order(order, start=start, again=again, key=key, author=act.author, holder=holder)
    result = await act.services.results.of(ordered)
    if result.repeated:
        act.response.headers["Idempotency-Replayed"] = "true"
        act.response.status_code = 200
    note(act.request, job=result.job.id)
    return await _taken(act, result.job, prefer)


@router.put("/jobs/{id}", status_code=202, responses=_TAKEN | _REMOVED)
async def put_job(
    act: OperatorOrMes,
    job: JobId,
    order: api.JobOrder,
    seen: SeenDep,
    start: StartQuery = True,
    again: AgainQuery = False,
    prefer: PreferHeader = None,
) -> api.AcceptedJob:
    """Order a job under a given id, or change its order.

    Accepts a job order. Repeating the same order returns the same job (200), whatever its state.

    If that job was removed, the order is refused for at least 7 days (410, with the last state of the job), unless
    `again` is true. A job that was not allowed to start is allowed by the same order with `start=true`, once.

    Another order under the same id is refused (409), unless the job has not started and `If-Match` names its version:
    then it replaces the order.
    """
    ordered = act.station.jobs.put(
        job,
        order,
        start=start,
        again=again,
        replaces=seen is not None,
        expects=seen.version if seen else None,
        author=act.author,
    )
    result = await act.services.results.of(ordered)
    if not result.repeated:
        return await _taken(act, result.job, prefer)
    act.response.status_code = 200
    return _located(act, result.job)


@router.get("/jobs")
async def list_jobs(
    act: ViewerOrMes,
    state: Annotated[list[api.StateName] | None, Query(max_length=6)] = None,
    since: WantedMoment | None = None,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
    cursor: CursorQuery = None,
    newest_first: NewestFirstQuery = False,
) -> api.JobPage:
    """List jobs.

    Lists all jobs that were not removed, in the order in which they were ordered.

    Parameters:
        state: Only jobs in these states.
        since: Only jobs changed since then.
    """
    after = None if cursor is None else int(cursor)
    return await run_in_threadpool(
        lambda: act.station.jobs.all(states=state, since=since, limit=limit, after=after, newest_first=newest_first)
    )


@router.get("/jobs/{id}", responses=tagged())
def get_job(act: ViewerOrMes, job: JobId) -> api.Job:
    """Get a job.

    Returns the current state of a job.
    """
    return act.tagged(act.station.jobs.get(job))


def _key_of(given: str | None) -> str | None:
    """Reads an idempotency key.

    Raises:
        Problem: It cannot be one.
    """
    if given is None:
        return None
    match = _KEY.fullmatch(given.strip())
    if match is None:
        raise Problem(422, "InvalidRequest", "Idempotency-Key: 1 to 200 printable ASCII characters, such as a UUID")
    return match[1]


async def _taken(act: Act, job: api.Job, prefer: str | None) -> api.AcceptedJob:
    """Answers an order, perhaps when it is over."""
    wanted = _WAIT.search(prefer or "")
    if wanted is not None:
        seconds = min(int(wanted[1]), _LONGEST_WAIT)
        act.request.state.place.close()  # it is stored: further orders need not wait for it
        job = await run_in_threadpool(act.station.jobs.wait, job.id, seconds)
        act.response.headers["Preference-Applied"] = f"wait={seconds}"
        act.response.status_code = 202 if is_open(job) else 200
    return _located(act, job)


def _located(act: Act, job: api.Job) -> api.AcceptedJob:
    act.locate("jobs", job.id)
    if is_open(job):
        act.response.headers["Retry-After"] = "1"
    return accepted(act, job)


def accepted(act: Act, job: api.Job) -> api.AcceptedJob:
    """Returns a job in answer to an order or a command, with its version in the headers of the answer."""
    return api.AcceptedJob.model_construct(**dict(act.tagged(job)))


commands_router = topic_router("jobs", responses=tagged())

_NO_COMMENT = api.JobComment()


def _wish(
    act: OperatorOrMes,
    job: JobId,
    seen: SeenDep,
    body: Annotated[api.JobComment, Body(description="Reason; optional.")] = _NO_COMMENT,
) -> dict[str, Any]:
    """Reads who commands a job and why, and notes it for the audit log: a removed job takes its record along."""
    note(act.request, job=job, comment=body.comment)
    return {"comment": body.comment, "expects": seen.version if seen else None, "author": act.author}


WishDep = Annotated[dict[str, Any], Depends(_wish)]
"""For routes: who commands, why, and which version of the job they have seen."""


@commands_router.post("/jobs/{id}/start")
def start_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> api.AcceptedJob:
    """Allow a job to start.

    Allows a job to start when its turn comes.
    """
    return accepted(act, act.station.jobs.command(job, "start", **wish))


@commands_router.post("/jobs/{id}/revoke-start")
def revoke_start_of_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> api.AcceptedJob:
    """Revoke the permission to start.

    Prevents a job from starting until it is allowed to start again.
    """
    return accepted(act, act.station.jobs.command(job, "revoke_start", **wish))


@commands_router.post("/jobs/{id}/pause")
def pause_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> api.AcceptedJob:
    """Pause a job.

    Pauses a job: everything that it moves comes to a standstill.
    """
    return accepted(act, act.station.jobs.command(job, "pause", **wish))


@commands_router.post("/jobs/{id}/resume")
def resume_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> api.AcceptedJob:
    """Resume a job.

    Resumes a paused job; a job that waits for an answer continues when it is answered.
    """
    return accepted(act, act.station.jobs.command(job, "resume", **wish))


@commands_router.post("/jobs/{id}/stop")
def stop_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> api.AcceptedJob:
    """Stop a job.

    Ends a running job in an orderly way; it is over when everything that it moved stands still.
    """
    return accepted(act, act.station.jobs.command(job, "stop", **wish))


@commands_router.post("/jobs/{id}/abort")
def abort_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> api.AcceptedJob:
    """Abort a job.

    Ends a job, started or not; it is over when everything that it moved stands still.
    """
    return accepted(act, act.station.jobs.command(job, "abort", **wish))


@commands_router.post("/jobs/{id}/cancel")
def cancel_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> api.AcceptedJob:
    """Remove a job that has not started.

    Removes a job that has not started, and returns its last state.
    """
    return accepted(act, act.station.jobs.command(job, "cancel", **wish))


@commands_router.post("/jobs/{id}/clear")
def clear_job(act: OperatorOrMes, job: JobId, wish: WishDep) -> api.AcceptedJob:
    """Remove a job that is over.

    Confirms that the result was fetched: removes a job that is over, with all its data.
    """
    return accepted(act, act.station.jobs.command(job, "clear", **wish))


@commands_router.delete("/jobs/{id}")
def remove_job(
    act: OperatorOrMes,
    job: JobId,
    seen: SeenDep,
    comment: Annotated[str, Query(max_length=1000)] = "",
) -> api.AcceptedJob:
    """Remove a job.

    Removes a job that has not started or is over: cancel or clear, whichever applies.

    Parameters:
        comment: Reason, for the audit log.
    """
    note(act.request, job=job, comment=comment)
    return accepted(act, act.station.jobs.command(job, "remove", expects=seen.version if seen else None))


@commands_router.post("/jobs/{id}/answer")
def answer_job(
    act: OperatorOrMes,
    job: JobId,
    body: api.JobAnswer,
    seen: SeenDep,
) -> api.AcceptedJob:
    """Answer a job's question.

    Answers the question for which a job waits, with one of its `choices`.
    """
    note(act.request, job=job, comment=body.answer)
    return accepted(act, act.station.jobs.answer(job, body, expects=seen.version if seen else None, author=act.author))


results_router = topic_router("jobs")

_GZIP = re.compile(r"(?:^|[,\s])(?:gzip|\*)\s*(?!\s*;\s*q=0(?:\.0*)?\s*(?:,|$))")
_LEVEL = 5


@results_router.get("/jobs/{id}/response")
def get_job_response(act: ViewerOrMes, job: JobId) -> api.JobResponse:
    """Get the result of a job (ISA-95 job response).

    Returns what was done with which material, by which skills, in which states, and why not if it was not done.
    """
    return act.station.jobs.response(job)


@results_router.get("/jobs/{id}/plan")
def get_job_plan(act: ViewerOrMes, job: JobId) -> api.JobPlan:
    """Get the plan of a job.

    Returns the steps of the last plan, with what each waits for; empty if there is none (yet).
    """
    return act.station.jobs.plan(job)


@results_router.get("/jobs/{id}/trace")
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


@results_router.get("/jobs/{id}/report")
def get_job_report(act: ViewerOrMes, job: JobId) -> api.JobReport:
    """Get the report of a job.

    Returns the outcome of each condition and of each step, as `skiros run` does.
    """
    return act.station.jobs.report(job)


@results_router.get("/jobs/{id}/transitions")
def get_job_transitions(act: ViewerOrMes, job: JobId) -> api.JobTransitions:
    """List the state changes of a job.

    Lists the states that a job went through: when, who requested it, and why.
    """
    return act.station.jobs.transitions(job)


@results_router.get("/jobs/{id}/explanation")
def get_job_explanation(act: ViewerOrMes, job: JobId) -> api.JobExplanation:
    """Explain why there is no plan.

    Returns why there is no plan for a job, and what would help; empty if there is one, or planning has not started.
    """
    return act.station.jobs.explanation(job)


@results_router.get(
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


@results_router.get(
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


@results_router.get("/capabilities")
def get_capabilities(act: ViewerOrMes) -> api.JobCapabilities:
    """List what can be ordered.

    Lists what an order may name: goal templates, material classes, robots; and the maximum number of orders.
    """
    return act.station.jobs.capabilities()


@results_router.get("/job-responses")
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

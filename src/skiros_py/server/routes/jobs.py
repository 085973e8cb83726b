"""Routes: jobs. Ordering and looking; commands and what came of them are in modules of their own."""

from __future__ import annotations

import re
from asyncio import wrap_future
from typing import Annotated, Any

from fastapi import Header, Query
from fastapi.concurrency import run_in_threadpool

from skiros_py.api.jobs import AcceptedJob, Job, JobOrder, JobPage, StateName
from skiros_py.api.wire import WantedMoment
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import Act, OperatorOrMes, ViewerOrMes
from skiros_py.server.problems import Problem, SeenDep, also_refused, tagged, topic_router
from skiros_py.server.routes.job_commands import (
    CursorQuery,
    JobId,
    NewestFirstQuery,
    accepted,
)
from skiros_py.station.jobs.views import is_open

router = topic_router("jobs")

_LONGEST_WAIT = 30
_WAIT = re.compile(r'(?:^|[,;\s])wait\s*=\s*"?(\d{1,6})"?')
_KEY = re.compile(r'"?([\x21\x23-\x5b\x5d-\x7e]{1,200})"?')
"""A key in printable characters, with the quotes of a structured field or without."""
_TAKEN: dict[int | str, dict[str, Any]] = {
    200: {"model": AcceptedJob, "description": "The job existed already, or is over (Prefer: wait)."}
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
    order: JobOrder,
    start: StartQuery = True,
    again: AgainQuery = False,
    idempotency_key: Annotated[str | None, Header(max_length=202)] = None,
    prefer: PreferHeader = None,
) -> AcceptedJob:
    """Order a job.

    Accepts a job order, which is on disk when this responds; it is planned later.

    Without an id, the server generates one; an `Idempotency-Key` makes that repeatable for at least 24 h.

    Parameters:
        idempotency-key: Identifies the request: repeating it does not create a second job.
    """
    key, holder = _key_of(idempotency_key), act.caller.key or act.caller.name
    ordered = act.station.jobs.order(order, start=start, again=again, key=key, author=act.author, holder=holder)
    result = await wrap_future(ordered)
    if result.repeated:
        act.response.headers["Idempotency-Replayed"] = "true"
        act.response.status_code = 200
    note(act.request, job=result.job.id)
    return await _taken(act, result.job, prefer)


@router.put("/jobs/{id}", status_code=202, responses=_TAKEN | _REMOVED)
async def put_job(
    act: OperatorOrMes,
    job: JobId,
    order: JobOrder,
    seen: SeenDep,
    start: StartQuery = True,
    again: AgainQuery = False,
    prefer: PreferHeader = None,
) -> AcceptedJob:
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
    result = await wrap_future(ordered)
    if not result.repeated:
        return await _taken(act, result.job, prefer)
    act.response.status_code = 200
    return _located(act, result.job)


@router.get("/jobs")
async def list_jobs(
    act: ViewerOrMes,
    state: Annotated[list[StateName] | None, Query(max_length=6)] = None,
    since: WantedMoment | None = None,
    limit: Annotated[int, Query(ge=1, le=1000)] = 100,
    cursor: CursorQuery = None,
    newest_first: NewestFirstQuery = False,
) -> JobPage:
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
def get_job(act: ViewerOrMes, job: JobId) -> Job:
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


async def _taken(act: Act, job: Job, prefer: str | None) -> AcceptedJob:
    """Answers an order, perhaps when it is over."""
    wanted = _WAIT.search(prefer or "")
    if wanted is not None:
        seconds = min(int(wanted[1]), _LONGEST_WAIT)
        act.request.state.place.close()  # it is stored: further orders need not wait for it
        job = await run_in_threadpool(act.station.jobs.wait, job.id, seconds)
        act.response.headers["Preference-Applied"] = f"wait={seconds}"
        act.response.status_code = 202 if is_open(job) else 200
    return _located(act, job)


def _located(act: Act, job: Job) -> AcceptedJob:
    act.locate("jobs", job.id)
    if is_open(job):
        act.response.headers["Retry-After"] = "1"
    return accepted(act, job)

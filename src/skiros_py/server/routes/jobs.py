"""Routes: jobs. Ordering and looking; commands and what came of them are in modules of their own."""

from __future__ import annotations

import re
import time
from typing import Annotated, Any

from fastapi import APIRouter, Header, Query, Request, Response

from skiros_py.api.jobs import AcceptedJob, Job, JobOrder, JobPage, StateName
from skiros_py.api.problem import ProblemDetails
from skiros_py.api.wire import WantedMoment
from skiros_py.errors import StaleVersion, WrongState
from skiros_py.server.access.audit import note
from skiros_py.server.access.roles import Caller, CallerDep, Role, needs
from skiros_py.server.etags import tagged
from skiros_py.server.job_faults import UNABLE_TO_ACCEPT, job_faults
from skiros_py.server.problems import Problem
from skiros_py.server.routes import job_commands, job_lists, job_results
from skiros_py.server.routes.job_access import (
    CursorQuery,
    ExpectedDep,
    JobId,
    JobsDep,
    NewestFirstQuery,
    TemplatesDep,
    accepted,
    job_location,
    job_page,
    said_by,
    shown,
)
from skiros_py.server.services import ServicesDep
from skiros_py.station.jobs.orders import digest_of, is_same, job_order, new_id, texts_of
from skiros_py.station.jobs.templates import TemplateStore
from skiros_py.station.jobs.views import job_view
from skiros_py.station.jobs.waiting import JobDesk
from skiros_py.tasks.jobs import Job as Known
from skiros_py.tasks.jobs import JobManager, Receipt, Trigger
from skiros_py.tasks.jobs import JobState as State

__all__ = ["router"]

router = APIRouter(tags=["jobs"])

_LONGEST_WAIT = 30
_WAIT = re.compile(r'(?:^|[,;\s])wait\s*=\s*"?(\d{1,6})"?')
_KEY = re.compile(r'"?([\x21\x23-\x5b\x5d-\x7e]{1,200})"?')
"""A key in printable characters, with the quotes of a structured field or without."""
_TAKEN: dict[int | str, dict[str, Any]] = {
    200: {"model": AcceptedJob, "description": "It was there already, or it is over (Prefer: wait)."}
}

_REMOVED: dict[int | str, dict[str, Any]] = {
    410: {"model": ProblemDetails, "description": "The same order came before, and its job was removed (`last`)."}
}

StartQuery = Annotated[bool, Query(description="False to keep it until somebody gives leave to start.")]
AgainQuery = Annotated[
    bool, Query(description="True where it is meant although there was a job of that id that was removed.")
]
PreferHeader = Annotated[
    str | None, Header(max_length=200, description="wait=N: answer when it is over or stands, after N s at the latest.")
]


@router.post(
    "/jobs",
    status_code=202,
    summary="Order a job",
    dependencies=[needs(Role.OPERATOR, mes=True)],
    responses=_TAKEN | _REMOVED,
)
def order_job(
    order: JobOrder,
    request: Request,
    services: ServicesDep,
    jobs: JobsDep,
    templates: TemplatesDep,
    caller: CallerDep,
    response: Response,
    start: StartQuery = True,
    again: AgainQuery = False,
    idempotency_key: Annotated[
        str | None,
        Header(max_length=202, description="Marks the request: the same one again leads to no second job."),
    ] = None,
    prefer: PreferHeader = None,
) -> AcceptedJob:
    """Takes a job order; it is on the disk when this is answered, and nobody waits for the plan.

    Without an id the server makes one; an `Idempotency-Key` makes that repeatable for at least 24 h.
    """
    with job_faults():
        receipt = _receipt(idempotency_key, caller, digest_of(order, start=start))
        known = _ordered_before(jobs, order, receipt, again=again)
        if known is not None:
            known = _with_leave(jobs, known, start, caller)
            response.headers["Idempotency-Replayed"] = "true"
            response.status_code = 200
        job = known or _submit(jobs, templates, order, order.id or new_id(), start, again, caller, receipt)
    note(request, job=job.id)
    return _taken(services.desk, jobs, job, response, prefer)


@router.put(
    "/jobs/{id}",
    status_code=202,
    summary="Order a job under an id of one's own, or change its order",
    dependencies=[needs(Role.OPERATOR, mes=True)],
    responses=_TAKEN | _REMOVED,
)
def put_job(
    id: JobId,  # noqa: A002 - the name in the address
    order: JobOrder,
    services: ServicesDep,
    jobs: JobsDep,
    templates: TemplatesDep,
    caller: CallerDep,
    expected: ExpectedDep,
    response: Response,
    start: StartQuery = True,
    again: AgainQuery = False,
    if_match: Annotated[str | None, Header()] = None,
    prefer: PreferHeader = None,
) -> AcceptedJob:
    """Takes a job order. The same order again is answered with the same job (200), whatever has become of it.

    Where that was removed, it is refused for at least 7 days (410, with what the job was last), unless `again` is true.
    A job that was kept from starting is given leave by the same order with `start=true`, once.

    Another order under the same id is refused (409), unless the job has not begun and `If-Match` names its version:
    then it is ordered instead.
    """
    with job_faults():
        if order.id not in (None, id):
            raise Problem(422, "InvalidRequest", f"the order has the id '{order.id}', and the address '{id}'")
        known = jobs.jobs.get(id)
        if known is None and if_match is not None:
            raise Problem(412, "StaleVersion", f"there is no job '{id}' (any more): leave out If-Match to order it")
        if known is None:
            _check_removed(None if again else jobs.removed(id), order)
            job = _submit(jobs, templates, order, id, start, again, caller, None)
            return _taken(services.desk, jobs, job, response, prefer)
        if is_same(order, known.order):
            known = _with_leave(jobs, known, start, caller)
        elif if_match is None:  # whoever orders something else under the id of a job must have seen that
            raise _taken_already(known)
        else:
            changed = job_order(order, id, texts_of(order, templates))
            known = jobs.update(changed, said_by(caller, ""), expects=expected)
    response.status_code = 200
    return _located(known, response)


@router.get("/jobs", summary="List jobs", dependencies=[needs(Role.VIEWER, mes=True)])
def list_jobs(
    jobs: JobsDep,
    state: Annotated[list[StateName] | None, Query(max_length=6, description="In these states only.")] = None,
    since: Annotated[WantedMoment | None, Query(description="Those only that changed since then.")] = None,
    limit: Annotated[int, Query(ge=1, le=1000, description="How many at most.")] = 100,
    cursor: CursorQuery = None,
    newest_first: NewestFirstQuery = False,
) -> JobPage:
    """Lists the jobs that were not removed, open or over, in the order in which they were ordered."""
    page, now = job_page(jobs, state, since, limit, cursor, newest_first=newest_first), time.time()
    return JobPage(
        items=tuple(job_view(job, now) for job in page.jobs), next=None if page.next is None else str(page.next)
    )


@router.get("/jobs/{id}", summary="Look at a job", dependencies=[needs(Role.VIEWER, mes=True)], responses=tagged())
def get_job(id: JobId, jobs: JobsDep, response: Response) -> Job:  # noqa: A002 - the name in the address
    """Shows a job as it is now."""
    with job_faults():
        return shown(jobs.job(id), response)


router.include_router(job_commands.router)
router.include_router(job_results.router)
router.include_router(job_lists.router)


def _ordered_before(jobs: JobManager, order: JobOrder, receipt: Receipt | None, *, again: bool) -> Known | None:
    """Returns the job that the same request, or the same order, has led to before."""
    before = None if receipt is None else jobs.known(receipt)
    if before is not None or order.id is None:
        return before
    known = jobs.jobs.get(order.id)
    if known is None:
        _check_removed(None if again else jobs.removed(order.id), order)
    if known is not None and not is_same(order, known.order):
        raise _taken_already(known)
    if known is not None and receipt is not None:  # so that the key counts for this order from now on
        return jobs.submit(known.order, receipt=receipt)
    return known


def _submit(
    jobs: JobManager,
    templates: TemplateStore,
    order: JobOrder,
    id_: str,
    start: bool,
    again: bool,
    caller: Caller,
    receipt: Receipt | None,
) -> Known:
    wanted = job_order(order, id_, texts_of(order, templates))
    return jobs.submit(wanted, start=start, comment=said_by(caller, ""), receipt=receipt, again=again)


def _with_leave(jobs: JobManager, known: Known, start: bool, caller: Caller) -> Known:
    """Gives leave to start to a job that was ordered without, where the same order comes with it.

    Leave that somebody has taken back is given by that command only: this order may have been sent before.
    """
    if not start or known.state is not State.NOT_ALLOWED_TO_START or known.id not in jobs.open:
        return known
    if any(one.trigger == Trigger.REVOKE_START.value for one in jobs.transitions(known.id)):
        return known
    try:
        return jobs.start(known.id, said_by(caller, ""), expects=known.version)
    except (StaleVersion, WrongState):  # somebody was quicker
        return jobs.job(known.id)


def _check_removed(last: Known | None, order: JobOrder) -> None:
    """Refuses an order under the id of a job that was removed.

    Raises:
        Problem: There was one; where its order was the same, with what it was last.
    """
    if last is None:
        return
    what = f"job '{last.id}' was ordered before and removed"
    if not is_same(order, last.order):
        detail = f"{what}, with another order: take another id, or say again=true"
        raise Problem(409, "UnableToAcceptJobOrder", detail, return_status=UNABLE_TO_ACCEPT)
    view = job_view(last, time.time()).model_dump(mode="json", by_alias=True)
    detail = f"{what}: it is not done once more, unless you say again=true"
    raise Problem(410, "JobOrderRemoved", detail, return_status=UNABLE_TO_ACCEPT, last=view)


def _taken_already(known: Known) -> Problem:
    return Problem(
        409,
        "UnableToAcceptJobOrder",
        f"job '{known.id}' is there already, with another order: take another id; or, before it has begun, put the"
        f' order with If-Match: "{known.version}"',
        return_status=UNABLE_TO_ACCEPT,
    )


def _receipt(key: str | None, caller: Caller, digest: str) -> Receipt | None:
    """Makes what a request is known by.

    Raises:
        Problem: The key cannot be one.
    """
    if key is None:
        return None
    match = _KEY.fullmatch(key.strip())
    if match is None:
        raise Problem(422, "InvalidRequest", "Idempotency-Key: 1 to 200 printable ASCII characters, such as a UUID")
    return Receipt(caller.key or caller.name, match[1], digest)


def _taken(desk: JobDesk, jobs: JobManager, job: Known, response: Response, prefer: str | None) -> AcceptedJob:
    """Answers an order, perhaps when it is over."""
    wanted = _WAIT.search(prefer or "")
    if wanted is not None:
        seconds = min(int(wanted[1]), _LONGEST_WAIT)
        job = desk.wait(jobs, job, seconds)
        response.headers["Preference-Applied"] = f"wait={seconds}"
        response.status_code = 202 if job.state.is_open else 200
    return _located(job, response)


def _located(job: Known, response: Response) -> AcceptedJob:
    response.headers["Location"] = job_location(job.id)
    if job.state.is_open:
        response.headers["Retry-After"] = "1"
    return accepted(job, response)

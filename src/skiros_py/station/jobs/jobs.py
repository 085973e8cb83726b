"""Use cases: jobs, which callers order, follow and command; the queue runs them."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Sequence
from concurrent.futures import Future
from datetime import datetime
from typing import TYPE_CHECKING, Literal, NamedTuple, TypedDict, Unpack

from skiros_py.api import jobs as api
from skiros_py.api.jobs import StateName
from skiros_py.errors import Refused, StaleVersion, UsageError, WrongState
from skiros_py.messages import Message
from skiros_py.station.document_store import TEMPLATE
from skiros_py.station.jobs import views
from skiros_py.station.jobs.intake import OrderIntake
from skiros_py.station.jobs.orders import digest_of, is_same, job_order, texts_of
from skiros_py.station.jobs.template_document import content_of
from skiros_py.station.requests import LIBRARY, Author, Service
from skiros_py.station.session import Session
from skiros_py.tasks.jobs.job import Job, JobOrder, JobState, Trigger
from skiros_py.tasks.jobs.manager import JobManager, Submission
from skiros_py.tasks.jobs.store import Page, Receipt
from skiros_py.world.vocabulary import MANIPULATABLE

if TYPE_CHECKING:
    from skiros_py.station.station import Station

Command = Literal["start", "revoke_start", "pause", "resume", "stop", "abort", "cancel", "clear", "remove"]

_UNABLE = 1 << 4
"""Bit of the standard's return status: unable to accept (OPC 10031-4 v2.00, annex B.2)."""


class OrderResult(NamedTuple):
    """The result of an order.

    Attributes:
        job: The job.
        repeated: True if the same request, or the same order, was received before.
    """

    job: api.Job
    repeated: bool


class JobFilter(TypedDict, total=False):
    """Which jobs to list: those in certain states, changed since a time, after a number, in either order."""

    states: Sequence[StateName] | None
    since: datetime | None
    limit: int
    after: int | None
    newest_first: bool


class JobService(Service):
    """Orders, follows and commands jobs."""

    def __init__(self, station: Station) -> None:
        super().__init__(station)
        self._intake = OrderIntake[OrderResult](lambda: self._jobs)

    @property
    def _jobs(self) -> JobManager:
        return self._station.session.jobs

    # ------------------------------------------------------------------ ordering

    def order(
        self,
        order: api.JobOrder,
        *,
        start: bool = True,
        again: bool = False,
        key: str | None = None,
        author: Author = LIBRARY,
        holder: str = "",
    ) -> Future[OrderResult]:
        """Accepts a job order; the plan is made later.

        Args:
            order: The order; an id is generated if it has none.
            start: False to hold the job until a caller starts it.
            again: True to accept the order even if a job with that id was removed.
            key: Idempotency key: a repeated request with it does not create a second job.
            author: The author of the order.
            holder: The owner of the key; the author if omitted.

        Returns:
            A future that is done when the order is on disk. Its result raises:

            * UsageError: The goal cannot be parsed, or the key belongs to another request.
            * Refused: There is or was another job with that id.

        Raises:
            Overloaded: Too many orders wait.
        """

        def read() -> Submission | OrderResult:
            receipt = None if key is None else Receipt(holder or author.name, key, digest_of(order, start=start))
            known = self._ordered_before(order, receipt, again=again)
            if known is not None:
                return OrderResult(_view(self._with_leave(known, start, author)), repeated=True)
            wanted = self._read(order, order.id or f"job-{secrets.token_hex(8)}")
            return Submission(wanted, start, _said(author, ""), receipt, again)

        return self._intake.ask(read, _new)

    def put(
        self,
        id_: str,
        order: api.JobOrder,
        *,
        start: bool = True,
        again: bool = False,
        replaces: bool = False,
        expects: int | None = None,
        author: Author = LIBRARY,
    ) -> Future[OrderResult]:
        """Accepts a job order with an id chosen by the caller, or changes the order of a job that has not started.

        Args:
            id_: The id.
            order: The order.
            start: False to hold the job until a caller starts it.
            again: True to accept the order even if a job with that id was removed.
            replaces: True to replace a different order that the author has seen.
            expects: The version that the author has seen; None for any.
            author: The author of the order.

        Returns:
            A future that is done when the order is on disk. Its result raises:

            * UsageError: The goal cannot be parsed.
            * Refused: There is or was another job with that id.
            * StaleVersion: It was changed since the author has seen it, or was removed.

        Raises:
            Overloaded: Too many orders wait.
        """

        def read() -> Submission | OrderResult:
            if order.id not in (None, id_):
                raise UsageError("the order has the id '{job}', and the address '{address}'", job=order.id, address=id_)
            jobs = self._jobs
            known = jobs.find(id_)
            if known is None and replaces:
                raise StaleVersion(
                    Message("there is no job '{job}' (any more): leave out If-Match to order it", job=id_)
                )
            if known is None:
                _check_removed(None if again else jobs.store.removed(id_), order)
                return Submission(self._read(order, id_), start, _said(author, ""), again=again)
            if is_same(order, known.order):
                known = self._with_leave(known, start, author)
            elif not replaces:  # a different order with the id of a job requires that the author has seen it
                raise _taken_already(known)
            else:
                known = jobs.update(self._read(order, id_), _said(author, ""), expects=expects)
            return OrderResult(_view(known), repeated=True)

        return self._intake.ask(read, _new)

    def start_intake(self) -> None:
        """Accepts orders from now on."""
        self._intake.start()

    def close(self) -> None:
        """Answers the orders that wait, and accepts no more."""
        self._intake.close()

    def _read(self, order: api.JobOrder, id_: str) -> JobOrder:
        """Returns an order as the queue takes it, with the goal that its template makes."""
        return job_order(order, id_, texts_of(order, self._station.document_store))

    def wait(self, id_: str, seconds: float) -> api.Job:
        """Waits until a job is over or interrupted; returns immediately if too many callers wait already.

        Args:
            id_: Its id.
            seconds: Maximum wait [s].
        """
        jobs = self._jobs
        return _view(self._station.waiter.wait(jobs, jobs.job(id_), seconds))

    def _ordered_before(self, order: api.JobOrder, receipt: Receipt | None, *, again: bool) -> Job | None:
        """Returns the job that the same request, or the same order, has created before."""
        jobs = self._jobs
        before = None if receipt is None else jobs.store.known(receipt)
        if before is not None or order.id is None:
            return before
        known = jobs.find(order.id)
        if known is None:
            _check_removed(None if again else jobs.store.removed(order.id), order)
        if known is not None and not is_same(order, known.order):
            raise _taken_already(known)
        if known is not None and receipt is not None:  # so that the key belongs to this order from now on
            return jobs.submit(known.order, receipt=receipt)
        return known

    def _with_leave(self, known: Job, start: bool, author: Author) -> Job:
        """Starts a job that was ordered with ``start=False`` if the same order is repeated with ``start=True``.

        A revoked start is renewed only by the start command, because this order may have been sent before.
        """
        jobs = self._jobs
        if not start or known.state is not JobState.NOT_ALLOWED_TO_START or known.id not in jobs.open:
            return known
        if any(one.trigger == Trigger.REVOKE_START.value for one in jobs.transitions(known.id)):
            return known
        try:
            return jobs.start(known.id, _said(author, ""), expects=known.version)
        except (StaleVersion, WrongState):  # another caller was faster
            return jobs.job(known.id)

    # ------------------------------------------------------------------ commands

    def command(
        self, id_: str, command: Command, *, comment: str = "", expects: int | None = None, author: Author = LIBRARY
    ) -> api.Job:
        """Commands a job; has no effect if the job is already in the state that the command leads to.

        Args:
            id_: Its id.
            command: The command; "remove" cancels a job that has not started, and clears one that is over.
            comment: The reason.
            expects: The version that the author has seen; None for any.
            author: The author of the command.

        Raises:
            UnknownName: There is no such job.
            WrongState: It does not accept that command in its current state.
            StaleVersion: It was changed since the author has seen it.
        """
        jobs = self._jobs
        if command == "remove":
            command = "cancel" if jobs.job(id_).state.is_open else "clear"
        if command in ("cancel", "clear"):
            return _view(getattr(jobs, command)(id_, expects=expects))
        return _view(getattr(jobs, command)(id_, _said(author, comment), expects=expects))

    def answer(
        self, id_: str, answer: api.JobAnswer, *, expects: int | None = None, author: Author = LIBRARY
    ) -> api.Job:
        """Answers the pending question of a job.

        Raises:
            UnknownName: There is no such job.
            WrongState: It does not wait for that answer, or no longer does.
        """
        jobs = self._jobs
        now = jobs.job(id_)
        if answer.question is None or expects is not None:
            return _view(jobs.answer(id_, answer.answer, by=author.name, expects=expects))
        if now.question != answer.question:
            raise WrongState(
                "job '{job}' does not wait for the answer to question {question} (any more)",
                job=id_,
                question=answer.question,
            )
        try:
            return _view(jobs.answer(id_, answer.answer, by=author.name, expects=now.version))
        except StaleVersion:
            raise WrongState("job '{job}' has gone on meanwhile: look what it asks now", job=id_) from None

    # ------------------------------------------------------------------ reading

    def all(self, **wanted: Unpack[JobFilter]) -> api.JobPage:
        """Lists the jobs that were not removed, in order of acceptance."""
        page, now = self._page(**wanted), time.time()
        return api.JobPage(items=tuple(views.job_view(job, now) for job in page.jobs), next=views.next_cursor(page))

    def responses(self, **wanted: Unpack[JobFilter]) -> api.JobResponses:
        """Lists the ISA-95 job responses of the jobs that were not removed."""
        page, now = self._page(**wanted), time.time()
        return api.JobResponses(
            items=tuple(views.response_of(self._jobs, job, now) for job in page.jobs), next=views.next_cursor(page)
        )

    def _page(self, **wanted: Unpack[JobFilter]) -> Page:
        states, since = wanted.get("states"), wanted.get("since")
        page = self._jobs.store.page(
            states=[views.STATES[name] for name in states] if states else None,
            since=None if since is None else since.timestamp(),
            after=wanted.get("after"),
            limit=wanted.get("limit", 100),
            newest_first=wanted.get("newest_first", False),
        )
        return Page(tuple(map(self._jobs.shown, page.jobs)), page.next)

    def get(self, id_: str) -> api.Job:
        """Returns a job as it is now.

        Raises:
            UnknownName: There is none of that id.
        """
        return _view(self._jobs.shown(self._jobs.job(id_)))

    def response(self, id_: str) -> api.JobResponse:
        """Returns what was done to each part, by which skills, and the reason if it was not done."""
        return views.response_of(self._jobs, self._jobs.job(id_), time.time())

    def plan(self, id_: str) -> api.JobPlan:
        """Returns the steps of a job's last plan, each with the steps for which it waits."""
        session = self._station.session
        job = session.jobs.job(id_)
        running = next((task for task in session.tasks.active if task.name == id_), None)
        if running is not None and running.plan is not None:  # newer than the stored plan
            return api.JobPlan(items=views.planned_steps(running.plan))
        return views.plan_of(job, session.jobs.trace(id_))

    def trace(self, id_: str, skip: int = 0, limit: int = 100) -> api.JobTrace:
        """Returns the trace of a job, in sentences and as data."""
        page = self._jobs.store.trace(self._jobs.job(id_).id, skip=skip, limit=limit)
        return api.JobTrace(items=page.entries, next=None if page.next is None else str(page.next))

    def report(self, id_: str) -> api.JobReport:
        """Returns the outcome of each condition and of each step."""
        return views.report_of(self._jobs.job(id_), self._jobs.trace(id_), time.time())

    def transitions(self, id_: str) -> api.JobTransitions:
        """Returns the transitions of a job with time, author and reason."""
        return api.JobTransitions(items=views.transitions_view(self._jobs.transitions(id_)))

    def explanation(self, id_: str) -> api.JobExplanation:
        """Returns why there is no plan for a job, and the possible repairs."""
        return views.explanation_of(self._jobs.job(id_), self._jobs.trace(id_))

    def capabilities(self) -> api.JobCapabilities:
        """Returns the goal templates, material classes and robots for orders, and the limit of open jobs."""
        session = self._station.session
        return api.JobCapabilities(
            work_masters=tuple(
                api.WorkMaster.view_of(content_of(one.data), id=one.name, version=one.version)
                for one in self._station.document_store.all(TEMPLATE)
            ),
            material_class_ids=tuple(sorted(session.world.ontology.subclasses(MANIPULATABLE))),
            equipment_ids=tuple(robot.id for robot in session.spec.robots),
            max_downloadable_job_orders=session.jobs.limit,
            open_job_orders=len(session.jobs.open),
        )


def _view(job: Job) -> api.Job:
    return views.job_view(job, time.time())


def _new(job: Job) -> OrderResult:
    return OrderResult(_view(job), repeated=False)


def _said(author: Author, comment: str) -> str:
    """Returns a comment with its author, for the record."""
    return f"{author.name}: {comment}" if comment else Message("by {author}", author=author.name)


def _check_removed(last: Job | None, order: api.JobOrder) -> None:
    """Refuses an order with the id of a job that was removed.

    Raises:
        Refused: There was one; if its order was the same, the error contains its last state.
    """
    if last is None:
        return
    what = Message("job '{job}' was ordered before and removed", job=last.id)
    if not is_same(order, last.order):
        detail = Message("{what}, with another order: take another id, or say again=true", what=what)
        raise Refused("UnableToAcceptJobOrder", detail, return_status=_UNABLE)
    view = views.job_view(last, time.time()).model_dump(mode="json", by_alias=True)
    detail = Message("{what}: it is not done once more, unless you say again=true", what=what)
    raise Refused("JobOrderRemoved", detail, return_status=_UNABLE, last=view)


def _taken_already(known: Job) -> Refused:
    return Refused(
        "UnableToAcceptJobOrder",
        Message(
            "job '{job}' is there already, with another order: take another id; "
            'or, before it has begun, put the order with If-Match: "{version}"',
            job=known.id,
            version=known.version,
        ),
        return_status=_UNABLE,
    )


_MOST = 8
"""Maximum number of waiting callers: each occupies a thread that other requests may need."""
_GLANCE = 0.25
"""Period at which waiting callers check whether the server ends [s]."""


class JobWaiter:
    """Sets up the queue of each session, and lets callers wait for jobs.

    Args:
        limit: Maximum number of open jobs.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._places = threading.BoundedSemaphore(_MOST)
        self._ending = False

    def open(self, session: Session) -> None:
        """Sets up the queue of a session; called in the control thread."""
        session.jobs.limit = self._limit

    def wait(self, jobs: JobManager, job: Job, seconds: float) -> Job:
        """Waits until a job is over or interrupted, and returns it; immediately if too many callers wait already.

        Args:
            jobs: The queue.
            job: The job.
            seconds: Maximum wait [s].
        """
        rests = threading.Event()
        unsubscribe = jobs.subscribe(lambda one: rests.set() if one.id == job.id and not _is_under_way(one) else None)
        try:
            if _is_under_way(jobs.find(job.id) or job):
                self.wait_for(rests, seconds)
            return jobs.find(job.id) or job
        finally:
            unsubscribe()

    def wait_for(self, event: threading.Event, seconds: float) -> None:
        """Waits for an event, at most so long [s]; not at all if too many callers wait already."""
        end = time.monotonic() + seconds
        if event.is_set() or not self._places.acquire(blocking=False):
            return
        try:
            while not (event.is_set() or self._ending) and (left := end - time.monotonic()) > 0.0:
                event.wait(min(left, _GLANCE))
        finally:
            self._places.release()

    def close(self) -> None:
        """Ends all waiting."""
        self._ending = True


def _is_under_way(job: Job) -> bool:
    return job.state.is_open and job.state is not JobState.INTERRUPTED

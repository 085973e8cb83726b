"""What routes about jobs have in common: where they take the id, the expected version and the queue from."""

from __future__ import annotations

import time
from collections.abc import Sequence
from datetime import datetime
from typing import Annotated
from urllib.parse import quote

from fastapi import Depends, Path, Query, Response
from fastapi.concurrency import run_in_threadpool

from skiros_py.api.jobs import AcceptedJob, Job, StateName
from skiros_py.server.access.roles import Caller
from skiros_py.server.etags import VersionDep, etag, expected_version
from skiros_py.server.services import ServicesDep
from skiros_py.station.jobs.templates import TemplateStore
from skiros_py.station.jobs.views import STATES, job_view
from skiros_py.tasks.jobs import Job as Known
from skiros_py.tasks.jobs import JobManager, Page

__all__ = [
    "CursorQuery",
    "ExpectedDep",
    "JobId",
    "JobsDep",
    "NewestFirstQuery",
    "TemplatesDep",
    "accepted",
    "job_location",
    "job_page",
    "said_by",
    "shown",
]

JobId = Annotated[str, Path(min_length=1, max_length=200, description="Id of the job.", examples=["line-1-kit-4711"])]
CursorQuery = Annotated[str | None, Query(pattern=r"^\d{1,15}$", description="The `next` of the page before.")]
NewestFirstQuery = Annotated[bool, Query(description="Go back from the job that was ordered last.")]


# These are asynchronous to spare each request a turn in the thread pool.


async def _jobs(services: ServicesDep) -> JobManager:
    if not services.control.alive:  # the session may be opened just now, and is waited for
        return (await run_in_threadpool(lambda: services.session)).jobs
    return services.session.jobs


async def _templates(services: ServicesDep) -> TemplateStore:
    return TemplateStore(services.documents)


async def _expected(seen: VersionDep) -> int | None:
    return expected_version(seen)


JobsDep = Annotated[JobManager, Depends(_jobs)]
"""For routes: the queue."""
TemplatesDep = Annotated[TemplateStore, Depends(_templates)]
"""For routes: the goal templates."""
ExpectedDep = Annotated[int | None, Depends(_expected)]
"""For routes: the version that the caller has seen; None for any."""


def job_page(
    jobs: JobManager,
    states: Sequence[StateName] | None,
    since: datetime | None,
    limit: int,
    cursor: str | None,
    *,
    newest_first: bool,
) -> Page:
    """Reads a page of jobs as lists of them are asked for."""
    return jobs.page(
        states=[STATES[name] for name in states] if states else None,
        since=None if since is None else since.timestamp(),
        after=None if cursor is None else int(cursor),
        limit=limit,
        newest_first=newest_first,
    )


def job_location(id_: str) -> str:
    """Returns the address of a job."""
    return f"/api/v1/jobs/{quote(id_, safe='')}"


def said_by(caller: Caller, comment: str) -> str:
    """Returns a comment with who made it, for the record."""
    return f"{caller.name}: {comment}" if comment else f"by {caller.name}"


def accepted(job: Known, response: Response) -> AcceptedJob:
    """Returns a job in answer to an order or a command, and its version in the head of the answer."""
    return AcceptedJob.model_construct(**dict(shown(job, response)))


def shown(job: Known, response: Response) -> Job:
    """Returns a job as it is shown, and its version in the head of the answer."""
    response.headers["ETag"] = etag(job.version)
    return job_view(job, time.time())

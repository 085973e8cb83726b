"""What routes about jobs have in common: the id, the expected version, and the answer with a job."""

from __future__ import annotations

from typing import Annotated
from urllib.parse import quote

from fastapi import Depends, Path, Query, Response

from skiros_py.api.jobs import AcceptedJob, Job
from skiros_py.server.etags import SeenDep, with_etag

JobId = Annotated[str, Path(min_length=1, max_length=200, description="Id of the job.", examples=["line-1-kit-4711"])]
CursorQuery = Annotated[str | None, Query(pattern=r"^\d{1,15}$", description="The `next` of the page before.")]
NewestFirstQuery = Annotated[bool, Query(description="Go back from the job that was ordered last.")]


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

"""Jobs of a server, for looking at."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from skiros_py.api.jobs import Job, JobPlan
    from skiros_py.client import Client

_PAGE = 1000


class JobServer:
    """The jobs of a server. Use it in a ``with``.

    Args:
        client: Reaches the server; it is closed with this.
    """

    def __init__(self, client: Client) -> None:
        self._client = client

    def get(self, job: str) -> Job:
        """Returns a job."""
        return self._client.jobs.get(job)

    def list(self, states: tuple[str, ...], limit: int) -> tuple[Job, ...]:
        """Returns the first jobs that are in some states; in any where none is given."""
        from skiros_py.api.jobs import StateName

        return self._client.jobs.list(states=tuple(map(StateName, states)), limit=limit).items

    def plan(self, job: str) -> JobPlan:
        """Returns the last plan of a job."""
        return self._client.jobs.plan(job)

    def trace(self, job: str) -> tuple[dict[str, Any], ...]:
        """Returns what happened for a job."""
        page = self._client.jobs.trace(job, limit=_PAGE)
        entries = page.entries
        while page.next is not None:
            page = self._client.jobs.trace(job, limit=_PAGE, cursor=page.next)
            entries += page.entries
        return entries

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()

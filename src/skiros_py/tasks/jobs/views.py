"""Jobs by their ids, for whoever only looks; safe in any thread, also while others order."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, KeysView, Mapping, ValuesView

from skiros_py.tasks.jobs.job import Job
from skiros_py.tasks.jobs.store import JobStore


class OpenJobs(Mapping[str, Job]):
    """The jobs that are not over. Going through them shows those of one moment.

    Args:
        jobs: What it shows; somebody else changes it.
    """

    def __init__(self, jobs: dict[str, Job]) -> None:
        self._jobs = jobs

    def __getitem__(self, job: str) -> Job:
        return self._jobs[job]

    def __len__(self) -> int:
        return len(self._jobs)

    def __iter__(self) -> Iterator[str]:
        return iter(self._jobs.copy())

    def keys(self) -> KeysView[str]:
        """Returns their ids."""
        return self._jobs.copy().keys()

    def values(self) -> ValuesView[Job]:
        """Returns the jobs."""
        return self._jobs.copy().values()

    def items(self) -> ItemsView[str, Job]:
        """Returns both."""
        return self._jobs.copy().items()


class AllJobs(Mapping[str, Job]):
    """All jobs that were not removed; those that are over are read from the file each time.

    Args:
        open: Those that are not over.
        store: Where all are kept.
    """

    def __init__(self, open: Mapping[str, Job], store: JobStore) -> None:  # noqa: A002 - the word for it
        self._open = open
        self._store = store

    def __getitem__(self, job: str) -> Job:
        found = self._open.get(job) or self._store.job(job)
        if found is None:
            raise KeyError(job)
        return found

    def __len__(self) -> int:
        return len(self._store)

    def __iter__(self) -> Iterator[str]:
        return iter(self._store.ids())

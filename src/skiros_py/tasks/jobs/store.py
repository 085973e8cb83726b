"""The persistent store of jobs: acknowledged writes survive the process and a power cut."""

from __future__ import annotations

import json
import logging
import sqlite3
import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from skiros_py.database import Database
from skiros_py.database_file import DatabaseFile
from skiros_py.errors import DiskFault, FileError, KeyReused, UnknownName
from skiros_py.tasks.jobs.job import Intent, Job, JobState, Transition, Trigger
from skiros_py.tasks.jobs.schema import SCHEMA

CANCELLED, CLEARED = "cancelled", "cleared"
"""Announced for a job that is removed: before its start, and after its end."""

MOST_ANNOUNCEMENTS = 100_000
"""Maximum number kept if they are not forwarded; the oldest are dropped first."""


_LONGEST_GOAL = 2000
"""Longer goals are truncated in announcements [characters]: the client that ordered has the full text."""


@dataclass(frozen=True, slots=True)
class Announcement:
    """A job changed state or was removed.

    Attributes:
        number: Counts announcements without gaps, over restarts as well.
        wall: When [s since 1970].
        job: The job at that time; a large one without its plan and with a truncated goal.
        trigger: What led to it: a value of :class:`~skiros_py.tasks.jobs.job.Trigger`, "cancelled" or "cleared".
    """

    number: int
    wall: float
    job: Job
    trigger: str


def _brief(job: Job) -> Job:
    """Returns a job without its bulky fields: every state change is stored."""
    goal = job.order.goal
    if sum(map(len, goal)) > _LONGEST_GOAL:
        goal = (f"{goal[0][:_LONGEST_GOAL]}…",)
    return job.model_copy(update={"plan": (), "order": job.order.model_copy(update={"goal": goal})})


KEPT = 24 * 3600.0
"""How long a receipt is kept at least [s]."""


@dataclass(frozen=True, slots=True)
class Receipt:
    """Identifies a request, so that a repetition is recognized.

    Attributes:
        caller: The caller; keys of different callers are independent.
        key: Chosen by the caller, unique per request.
        digest: Digest of the request's content.
    """

    caller: str
    key: str
    digest: str


_log = logging.getLogger(__name__)

_LAST = 2**63 - 1
"""The largest number the file can hold."""

_ROOM = 4 << 20
"""Maximum size of a page [characters]; further jobs go to the next page."""


class _Entry(BaseModel, extra="allow"):
    """What each entry of a trace has, besides others."""

    time: float
    what: str
    text: str
    data: dict[str, Any]


_JOB = Job.model_validate_json


def _entry(text: str) -> dict[str, Any]:
    return _Entry.model_validate_json(text).model_dump()


@dataclass(frozen=True, slots=True)
class Page:
    """Some of the jobs.

    Attributes:
        jobs: In order of their numbers, or backwards from the largest.
        next: Where the next page begins: its ``after``; None if this is the last one.
    """

    jobs: tuple[Job, ...]
    next: int | None


@dataclass(frozen=True, slots=True)
class TracePage:
    """Some entries of a job's trace.

    Attributes:
        entries: Those that can be read, in order, as plain data.
        next: How many entries to skip for the next page; None if this is the last one.
    """

    entries: tuple[dict[str, Any], ...]
    next: int | None


class JobStore:
    """The jobs of a data directory; thread-safe. The owner must close it.

    Writes survive the process at once, and a power cut after :meth:`after_sync`.

    Args:
        path: The file; created if missing, migrated if old.

    Raises:
        FileError: It cannot be opened or created, or is damaged.
    """

    def __init__(self, path: Path) -> None:
        self._database = Database(path, SCHEMA, lookups=True)
        self._waiting = ThreadPoolExecutor(1, "skiros-jobs-disk")
        self._calling = ThreadPoolExecutor(1, "skiros-jobs")
        self._caller: threading.Thread | None = None

    # ------------------------------------------------------------------ the disk

    @property
    def fault(self) -> DiskFault | None:
        """Why the disk cannot be written; None if it can."""
        return self._database.fault

    @property
    def unreadable(self) -> Mapping[str, FileError]:
        """The records that were left out because they cannot be read, by name, such as "job kit-7"."""
        return self._database.unreadable

    def probe(self) -> None:
        """Tries to write.

        Raises:
            DiskFault: The disk still cannot be written.
        """
        with self._database.transaction("a trial") as connection:
            connection.execute("UPDATE numbers SET last = last")
        self.sync()

    def sync(self) -> Future[None]:
        """Starts syncing to disk everything written so far.

        Returns:
            A future that is done after the sync; its result raises FileError if the disk failed.
        """
        return self._waiting.submit(self._database.sync)

    def after_sync(self, then: Callable[[], object]) -> Future[None]:
        """Calls back once everything written so far is synced to disk; in a separate thread, in order.

        Returns:
            A future that is done after that, as for :meth:`sync`.
        """
        return self._calling.submit(self._call, then)

    def flush(self) -> None:
        """Waits until all writes are synced to disk and all callbacks have run.

        A callback that calls this does not wait for itself.

        Raises:
            FileError: The disk failed.
        """
        if threading.current_thread() is not self._caller:
            self.after_sync(lambda: None).result()

    def _call(self, then: Callable[[], object]) -> None:
        self._caller = threading.current_thread()
        try:
            self._database.sync()
        except FileError as error:
            _log.error("a power cut may take what became of jobs: %s", error)
            raise
        finally:
            then()

    # ------------------------------------------------------------------ jobs

    def open(self) -> tuple[Job, ...]:
        """Returns the jobs that are not over and can be read, in the order in which they were ordered."""
        sql = "SELECT 'job ' || id, data FROM jobs WHERE state < ? ORDER BY number"
        return tuple(self._database.readable(self._database.rows(sql, (JobState.ENDED.value,)), _JOB))

    def job(self, job: str) -> Job | None:
        """Returns a job; None if there is none with that id."""
        rows = self._database.rows("SELECT data FROM jobs WHERE id = ?", (job,))
        return self._database.read(f"job {job}", _JOB, *rows[0]) if rows else None

    def ids(self) -> tuple[str, ...]:
        """Returns the ids of all jobs, in the order in which they were ordered."""
        return tuple(job for (job,) in self._database.looked_up("SELECT id FROM jobs ORDER BY number"))

    def removed(self, job: str) -> Job | None:
        """Returns the last version, without details, of a job removed in the last days; None if there is none."""
        rows = self._database.rows("SELECT data FROM removed WHERE id = ?", (job,))
        return self._database.read(f"job {job}", _JOB, *rows[0]) if rows else None

    def page(
        self,
        *,
        states: Collection[JobState] | None = None,
        since: float | None = None,
        after: int | None = None,
        limit: int = 100,
        newest_first: bool = False,
    ) -> Page:
        """Returns some of the jobs that can be read, in the order in which they were ordered, or back from the last.

        Args:
            states: Those in these states only; None for all.
            since: Those only that changed at that time or later [s since 1970]; None for all.
            after: Those only that come after the job with this number; None for all.
            limit: How many at most; fewer if they are very large.
            newest_first: True to go back from the last one.
        """
        wanted = tuple(JobState) if states is None else tuple(states)
        # Internal numbers, not user input: they need not be bound.
        among = "1" if states is None else f"state IN ({', '.join(str(state.value) for state in wanted)})"
        beyond, order = ("<", "number DESC") if newest_first else (">", "number")
        where = f"number {beyond} ? AND {among}"
        start = (_LAST if newest_first else 0) if after is None else min(after, _LAST)
        values: tuple[float, ...] = (start,)
        if since is not None:  # answered from the index alone, regardless of their number
            changed = f"FROM jobs INDEXED BY jobs_by_change WHERE changed >= ? AND {where} ORDER BY {order}"
            where = f"id IN (SELECT id {changed} LIMIT {limit + 1})"
            values = (since, *values)
        sql = f"SELECT data, id, number FROM jobs WHERE {where} ORDER BY {order} LIMIT ?"  # noqa: S608
        rows = self._database.looked_up(sql, (*values, limit + 1), room=_ROOM)
        is_last = len(rows) <= limit and sum(len(data) for data, _, _ in rows) < _ROOM
        shown = rows[:limit]
        jobs = self._database.readable(((f"job {id_}", data) for data, id_, _ in shown), _JOB)
        return Page(tuple(jobs), None if is_last else shown[-1][2])

    def add(self, job: Job, trigger: Trigger, comment: str = "", receipt: Receipt | None = None) -> Job:
        """Adds a new job and assigns it a new number.

        Its version is greater than that of any removed job, which may have had the same id.

        Args:
            job: The job; its number and version are ignored.
            trigger: What led to its state.
            comment: Why.
            receipt: The request that led to it, if repetitions are to be recognized.

        Returns:
            The job with its number and version.
        """
        with self._database.transaction(f"job {job.id}, ordered") as connection:
            connection.execute("UPDATE numbers SET last = last + 1")
            ((number, version),) = connection.execute("SELECT last, version FROM numbers").fetchall()
            numbered = job.model_copy(update={"number": int(number), "version": int(version) + 1})
            _write(connection, numbered, trigger, comment)
            if receipt is not None:
                _keep_receipt(connection, receipt, job.id, job.changed)
        return numbered

    def keep(self, job: Job, trigger: Trigger | None = None, comment: str = "", wall: float | None = None) -> None:
        """Stores a job.

        Args:
            job: The job as it is now.
            trigger: What led to its state, where that changed.
            comment: Why.
            wall: When that was, if it could not be stored then [s since 1970]; None for the job's last change.
        """
        with self._database.transaction(f"job {job.id}: {trigger.value if trigger else job.state.name}") as connection:
            _write(connection, job, trigger, comment, wall)

    def forget(self, job: Job, why: str) -> None:
        """Removes a job with its records, except announcements, receipts and the record of its removal.

        Args:
            job: The job as it is now.
            why: What is announced.
        """
        data = job.model_dump_json()
        with self._database.transaction(f"job {job.id}, {why}") as connection:
            connection.execute("DELETE FROM jobs WHERE id = ?", (job.id,))
            connection.execute("UPDATE numbers SET version = max(version, ?)", (job.version,))
            for table in ("transitions", "intents", "trace"):
                connection.execute(f"DELETE FROM {table} WHERE job = ?", (job.id,))  # noqa: S608 - internal names
            # the receipts that led to it keep its last version
            connection.execute("UPDATE receipts SET last = ? WHERE job = ? AND last IS NULL", (data, job.id))
            connection.execute("DELETE FROM removed WHERE wall < ?", (job.changed - REMEMBERED,))
            brief = job.model_copy(update={"plan": (), "actuals": (), "materials": (), "reasons": (), "choices": ()})
            values = (job.id, job.changed, brief.model_dump_json())
            connection.execute("INSERT OR REPLACE INTO removed (id, wall, data) VALUES (?, ?, ?)", values)
            _announce(connection, job, data, why)

    # ------------------------------------------------------------------ requests and announcements

    def known(self, receipt: Receipt) -> Job | None:
        """Returns the job that an earlier identical request led to; None if there was none.

        For a job removed meanwhile, its last version is returned.

        Raises:
            KeyReused: The key was used for another request.
        """
        sql = "SELECT digest, job, coalesce(last, (SELECT data FROM jobs WHERE id = job)) FROM receipts"
        rows = self._database.rows(f"{sql} WHERE caller = ? AND key = ?", (receipt.caller, receipt.key))
        if not rows:
            return None
        ((digest, job, data),) = rows
        if digest != receipt.digest:
            raise KeyReused(
                "the key '{key}' was used for another order: take a new key for each new order", key=receipt.key
            )
        return self._database.read(f"job {job}", _JOB, data)

    def note(self, receipt: Receipt, job: Job, wall: float) -> None:
        """Records that a request led to an existing job."""
        with self._database.transaction(f"a repeated order of job {job.id}") as connection:
            _keep_receipt(connection, receipt, job.id, wall)

    def announcements(self, after: int, most: int) -> tuple[Announcement, ...]:
        """Returns the announcements to forward that can be read, in order.

        Args:
            after: Number of the last one received; 0 for none.
            most: How many at most.
        """
        sql = "SELECT 'announcement ' || number, data, number, wall, trigger FROM announcements WHERE number > ?"
        rows = self._database.looked_up(f"{sql} ORDER BY number LIMIT ?", (after, most))

        def read(data: str, number: int, wall: float, trigger: str) -> Announcement:
            return Announcement(number, wall, _JOB(data), trigger)

        return tuple(self._database.readable(rows, read))

    @property
    def last_announcement(self) -> int:
        """Number of the last announcement, deleted or not; 0 before the first."""
        rows = self._database.rows("SELECT seq FROM sqlite_sequence WHERE name = 'announcements'")
        return int(rows[0][0]) if rows else 0

    def forget_announcements(self, upto: int) -> None:
        """Deletes announcements delivered to all recipients.

        Args:
            upto: Number of the last one of them.
        """
        with self._database.transaction(f"announcements up to {upto}, delivered") as connection:
            connection.execute("DELETE FROM announcements WHERE number <= ?", (upto,))

    # ------------------------------------------------------------------ steps, state changes, trace

    def intend(self, job: str, skill: str, arguments: Mapping[str, str]) -> int:
        """Records that a step is about to start, and returns its number in the job."""
        with self._database.transaction(f"job {job}: step {skill} starts") as connection:
            ((last,),) = connection.execute(
                "SELECT coalesce(max(number), 0) FROM intents WHERE job = ?", (job,)
            ).fetchall()
            intent = Intent(number=last + 1, skill=skill, arguments=dict(arguments))
            connection.execute("INSERT INTO intents VALUES (?, ?, ?)", (job, intent.number, intent.model_dump_json()))
        return intent.number

    def settle(self, job: str, number: int, ended: str) -> None:
        """Records how a step ended."""
        known = {intent.number: intent for intent in self.intents(job)}
        if number not in known:
            raise UnknownName("step", str(number), [str(n) for n in known], where=f"of job '{job}'")
        text = known[number].model_copy(update={"ended": ended}).model_dump_json()
        with self._database.transaction(f"job {job}: step {number} ended") as connection:
            connection.execute("UPDATE intents SET data = ? WHERE job = ? AND number = ?", (text, job, number))

    def intents(self, job: str) -> tuple[Intent, ...]:
        """Returns the steps that were started for a job and can be read, in order."""
        sql = "SELECT 'step ' || number || ' of job ' || job, data FROM intents WHERE job = ? ORDER BY number"
        return tuple(self._database.readable(self._database.rows(sql, (job,)), Intent.model_validate_json))

    def transitions(self, job: str) -> tuple[Transition, ...]:
        """Returns the state changes of a job that can be read, in order."""
        sql = "SELECT 'a state change of job ' || job, data FROM transitions WHERE job = ? ORDER BY rowid"
        return tuple(self._database.readable(self._database.looked_up(sql, (job,)), Transition.model_validate_json))

    def add_trace(self, job: str, entries: Iterable[Mapping[str, Any]]) -> None:
        """Adds to a job's trace."""
        with self._database.transaction(f"job {job}: trace") as connection:
            connection.executemany("INSERT INTO trace VALUES (?, ?)", ((job, json.dumps(dict(e))) for e in entries))

    def trace(self, job: str, *, skip: int = 0, limit: int = _LAST - 1) -> TracePage:
        """Returns entries of a job's trace.

        Args:
            job: Its id.
            skip: How many entries to skip at the beginning.
            limit: How many at most.
        """
        sql = "SELECT data FROM trace WHERE job = ? ORDER BY rowid LIMIT ? OFFSET ?"
        rows = self._database.looked_up(sql, (job, limit + 1, min(skip, _LAST)))
        named = (
            (f"entry {number} of the trace of job {job}", *row) for number, row in enumerate(rows[:limit], skip + 1)
        )
        entries = tuple(self._database.readable(named, _entry))
        return TracePage(entries, skip + limit if len(rows) > limit else None)

    def together(self) -> AbstractContextManager[object]:
        """Commits everything that this thread writes in a ``with`` at its end, or nothing of it if it fails."""
        return self._database.transaction()

    def close(self) -> None:
        """Closes the file; may be called twice."""
        self._waiting.shutdown()
        self._calling.shutdown()
        self._database.close()


_TABLES: Mapping[str, tuple[str, Callable[[str], object]]] = {
    "jobs": ("id", _JOB),
    "announcements": ("number", _JOB),
    "removed": ("id", _JOB),
    "transitions": ("job", Transition.model_validate_json),
    "intents": ("job", Intent.model_validate_json),
    "trace": ("job", _entry),
}
"""The tables of records, each with the column that names them, and what reads them."""


def unreadable_jobs(file: DatabaseFile) -> Iterator[str]:
    """Yields what in a file of jobs cannot be understood.

    Raises:
        FileError: The file cannot be read.
    """
    there = {name for (name,) in file.rows("SELECT name FROM sqlite_schema WHERE type = 'table'")}
    for table, (name, read) in _TABLES.items():
        if table not in there:  # of an earlier version
            continue
        for row, data in file.rows(f"SELECT {name}, data FROM {table}"):  # noqa: S608 - our own names
            try:
                read(data)
            except ValidationError as error:
                yield f"{name} {row} of the table {table} cannot be understood: {error.errors()[0]['msg']}"


def _write(
    connection: sqlite3.Connection, job: Job, trigger: Trigger | None, comment: str, wall: float | None = None
) -> None:
    data = job.model_dump_json()
    connection.execute(
        "INSERT INTO jobs (id, number, data, state, changed) VALUES (?, ?, ?, ?, ?) ON CONFLICT (id) DO UPDATE"
        " SET data = excluded.data, state = excluded.state, changed = excluded.changed",
        (job.id, job.number, data, job.state.value, job.changed),
    )
    if trigger is not None:
        at = job.changed if wall is None else wall
        entry = Transition(wall=at, trigger=trigger.value, state=job.state, comment=comment)
        connection.execute("INSERT INTO transitions VALUES (?, ?)", (job.id, entry.model_dump_json()))
        _announce(connection, job, data, trigger.value)


def _announce(connection: sqlite3.Connection, job: Job, data: str, trigger: str) -> None:
    values = (job.changed, trigger, data if len(data) <= _LONGEST_GOAL else _brief(job).model_dump_json())
    sql = "INSERT INTO announcements (wall, trigger, data) VALUES (?, ?, ?)"
    number = connection.execute(sql, values).lastrowid
    connection.execute("DELETE FROM announcements WHERE number <= ? - ?", (number, MOST_ANNOUNCEMENTS))


def _keep_receipt(connection: sqlite3.Connection, receipt: Receipt, job: str, wall: float) -> None:
    """Stores that a request led to a job and deletes old receipts."""
    connection.execute("DELETE FROM receipts WHERE wall < ?", (wall - KEPT,))
    values = (receipt.caller, receipt.key, receipt.digest, job, wall)
    connection.execute("INSERT INTO receipts (caller, key, digest, job, wall) VALUES (?, ?, ?, ?, ?)", values)


REMEMBERED = 7 * 24 * 3600.0
"""How long removed jobs are remembered [s]."""

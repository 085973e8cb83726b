"""Where jobs are kept: what was acknowledged outlives the process and a power cut."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from skiros_py.database import Database, Schema
from skiros_py.errors import FileError, UnknownName
from skiros_py.tasks.jobs.job import Intent, Job, Transition
from skiros_py.tasks.jobs.states import Trigger

__all__ = ["JobStore"]

T = TypeVar("T")

_TABLES = """
CREATE TABLE jobs (id TEXT PRIMARY KEY, number INTEGER NOT NULL UNIQUE, data TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE transitions (job TEXT NOT NULL, data TEXT NOT NULL);
CREATE INDEX transitions_by_job ON transitions (job);
CREATE TABLE intents (job TEXT NOT NULL, number INTEGER NOT NULL, data TEXT NOT NULL, PRIMARY KEY (job, number))
    WITHOUT ROWID;
CREATE TABLE trace (job TEXT NOT NULL, data TEXT NOT NULL);
CREATE INDEX trace_by_job ON trace (job);
CREATE TABLE numbers (last INTEGER NOT NULL);
INSERT INTO numbers VALUES (0);
"""

_SCHEMA = Schema("list of jobs", "a list of jobs", 0x736B6A6F, (_TABLES,))
"""Such a file is marked "skjo"."""

_TRACE = TypeAdapter(dict[str, Any])


class JobStore:
    """The jobs of a data directory; used by any thread. Close it.

    Args:
        path: The file; made where it is missing.

    Raises:
        FileError: It cannot be opened or made, or is damaged.
    """

    def __init__(self, path: Path) -> None:
        self._database = Database(path, _SCHEMA, durable=True)
        self._path = path

    def next_number(self) -> int:
        """Returns a number that no job had before, not even one that was cleared."""
        with self._database.transaction() as connection:
            ((number,),) = connection.execute("UPDATE numbers SET last = last + 1 RETURNING last").fetchall()
        return int(number)

    def all(self) -> tuple[Job, ...]:
        """Returns all jobs in the order in which they were ordered.

        Raises:
            FileError: One cannot be read.
        """
        rows = self._database.rows("SELECT data FROM jobs ORDER BY number")
        return tuple(self._read(Job.model_validate_json, data) for (data,) in rows)

    def keep(self, job: Job, trigger: Trigger | None = None, comment: str = "") -> None:
        """Writes a job down; when this returns, it is on the disk.

        Args:
            job: The job as it is now.
            trigger: What led to its state, where that changed.
            comment: Why.
        """
        with self._database.transaction() as connection:
            connection.execute(
                "INSERT INTO jobs VALUES (?, ?, ?) ON CONFLICT (id) DO UPDATE SET data = excluded.data",
                (job.id, job.number, job.model_dump_json()),
            )
            if trigger is not None:
                entry = Transition(wall=time.time(), trigger=trigger.value, state=job.state, comment=comment)
                connection.execute("INSERT INTO transitions VALUES (?, ?)", (job.id, entry.model_dump_json()))

    def forget(self, job: str) -> None:
        """Removes a job with all that is known of it."""
        with self._database.transaction() as connection:
            connection.execute("DELETE FROM jobs WHERE id = ?", (job,))
            for table in ("transitions", "intents", "trace"):
                connection.execute(f"DELETE FROM {table} WHERE job = ?", (job,))  # noqa: S608 - our own names

    def intend(self, job: str, skill: str, arguments: Mapping[str, str]) -> int:
        """Writes down that a step is about to begin, and returns its number in the job."""
        with self._database.transaction() as connection:
            ((last,),) = connection.execute(
                "SELECT coalesce(max(number), 0) FROM intents WHERE job = ?", (job,)
            ).fetchall()
            intent = Intent(number=last + 1, skill=skill, arguments=dict(arguments))
            connection.execute("INSERT INTO intents VALUES (?, ?, ?)", (job, intent.number, intent.model_dump_json()))
        return intent.number

    def settle(self, job: str, number: int, ended: str) -> None:
        """Writes down how a step ended."""
        known = {intent.number: intent for intent in self.intents(job)}
        if number not in known:
            raise UnknownName("step", str(number), [str(n) for n in known], where=f"of job '{job}'")
        text = known[number].model_copy(update={"ended": ended}).model_dump_json()
        with self._database.transaction() as connection:
            connection.execute("UPDATE intents SET data = ? WHERE job = ? AND number = ?", (text, job, number))

    def intents(self, job: str) -> tuple[Intent, ...]:
        """Returns the steps that were begun for a job, in order."""
        rows = self._database.rows("SELECT data FROM intents WHERE job = ? ORDER BY number", (job,))
        return tuple(self._read(Intent.model_validate_json, data) for (data,) in rows)

    def transitions(self, job: str) -> tuple[Transition, ...]:
        """Returns a job's changes of state, in order."""
        rows = self._database.rows("SELECT data FROM transitions WHERE job = ? ORDER BY rowid", (job,))
        return tuple(self._read(Transition.model_validate_json, data) for (data,) in rows)

    def tell(self, job: str, entries: Iterable[Mapping[str, Any]]) -> None:
        """Adds to a job's trace."""
        with self._database.transaction() as connection:
            connection.executemany("INSERT INTO trace VALUES (?, ?)", ((job, json.dumps(dict(e))) for e in entries))

    def trace(self, job: str) -> tuple[dict[str, Any], ...]:
        """Returns a job's trace as plain data, in order."""
        rows = self._database.rows("SELECT data FROM trace WHERE job = ? ORDER BY rowid", (job,))
        return tuple(self._read(_TRACE.validate_json, data) for (data,) in rows)

    def close(self) -> None:
        """Closes the file; may be called twice."""
        self._database.close()

    def _read(self, reader: Callable[[str], T], text: str) -> T:
        try:
            return reader(text)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise FileError(self._path, f"a job in it cannot be read: {where}: {first['msg']}") from error

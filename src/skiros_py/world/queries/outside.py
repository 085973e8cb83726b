"""Queries from untrusted users and programs: each gets an answer or an error in time.

A query may be nested so deeply that the engine crashes, run forever, or exhaust the memory. So it never runs in
this process but in a copy of a replica of the world (see :mod:`~skiros_py.world.queries.replica`).
"""

from __future__ import annotations

import pickle
import signal
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType, TracebackType
from typing import Self

from skiros_py.errors import DeviceError, SkirosError, UsageError, WorldError
from skiros_py.world.queries.answering import Binding, Result
from skiros_py.world.queries.replica import OUT_OF_MEMORY, Order
from skiros_py.world.queries.replica_process import Pending, ReplicaProcess
from skiros_py.world.store.store import AnswerLimits
from skiros_py.world.world import World

LONGEST_TIME = 3600.0
"""Maximum time limit of any query [s]."""

_MIB = 1 << 20
_NO_BINDINGS: Mapping[str, Binding] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Limits:
    """Resource limits of one external query.

    Attributes:
        text: Characters of the query.
        time: Seconds.
        memory: Bytes beside what the world itself takes.
        rows: Rows or triples of the answer.
        bytes: Characters of all terms of the answer together.
        at_once: Queries that may run at the same time; others wait for their turn, as long as they may take.
    """

    text: int = 64 * 1024
    time: float = 5.0
    memory: int = 1024 * _MIB
    rows: int = 10_000
    bytes: int = 16 * _MIB
    at_once: int = 4


class OutsideQueries:
    """Answers queries from outside. Close it, or use it in a ``with``; any thread may ask.

    Args:
        world: What is asked; each query sees all that was written before it.
        limits: Limits of a query.
    """

    def __init__(self, world: World, limits: Limits = Limits()) -> None:
        self.limits = limits
        self._world = world
        self._lock = threading.Lock()
        self._turns = threading.BoundedSemaphore(limits.at_once)
        self._replica: ReplicaProcess | None = None
        self._closed = False

    def start(self) -> None:
        """Makes the replica, as the first query does otherwise; of a million triples that takes half a minute."""
        with self._lock:
            self._started()

    def close(self) -> None:
        """Ends the replica and all running queries; no more answers are given."""
        with self._lock:
            self._closed = True
            self._drop()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # ------------------------------------------------------------ asking

    def query(
        self,
        sparql: str,
        bindings: Mapping[str, Binding] = _NO_BINDINGS,
        *,
        entailed: bool = False,
        time_limit: float | None = None,
    ) -> Result:
        """Runs a query of any form; see :func:`~skiros_py.world.queries.answering.query`.

        Args:
            sparql: The query.
            bindings: What its parameters stand for, by name.
            entailed: Whether what OWL entails counts too.
            time_limit: How long it may take [s]; None for the usual time.

        Raises:
            UsageError: It cannot be answered, or not within its limits; the text says which.
            DeviceError: The replica cannot be started, or this was closed.
        """
        if len(sparql) > self.limits.text:
            raise UsageError(f"the query has {len(sparql)} characters, and {self.limits.text} are the most")
        limit = self.limits.time if time_limit is None else time_limit
        if not 0.0 < limit <= LONGEST_TIME:
            raise UsageError(f"a time limit is more than 0 and at most {LONGEST_TIME:g} s, not {limit:g}")
        most = AnswerLimits(self.limits.rows, self.limits.bytes)
        order = Order(sparql, dict(bindings), entailed, limit, self.limits.memory, most)
        if not self._turns.acquire(timeout=limit):
            raise UsageError(f"{self.limits.at_once} queries are running already, and none ended within {limit:g} s")
        try:
            return self._outcome(order)
        finally:
            self._turns.release()

    # ------------------------------------------------------------ the replica

    def _outcome(self, order: Order) -> Result:
        try:
            ended = self._sent(order).wait(order.time_limit)
        except DeviceError:  # the replica was killed: retry with a new one
            ended = self._sent(order).wait(order.time_limit)
        if ended.code != 0:
            raise UsageError(_why(ended.code, order))
        outcome = pickle.loads(ended.answer)  # noqa: S301  from our own process
        if isinstance(outcome, SkirosError):
            raise outcome
        result: Result = outcome
        return result

    def _sent(self, order: Order) -> Pending:
        with self._lock:
            replica = self._started()
            try:
                changes = self._world.changes_since(replica.version)
            except WorldError:  # they are remembered no longer
                self._drop()
                replica, changes = self._started(), ()
            return replica.ask(changes, pickle.dumps(order))

    def _started(self) -> ReplicaProcess:
        if self._closed:  # a thread that was waiting must not start it again
            raise DeviceError("no queries are answered any more: whatever answered them was closed")
        if self._replica is None or not self._replica.is_alive():
            self._drop()
            self._replica = ReplicaProcess(*self._world.state())
        return self._replica

    def _drop(self) -> None:
        if self._replica is not None:
            self._replica.close()
            self._replica = None


def _why(code: int, order: Order) -> str:
    """Why a query ended without an answer."""
    if code == -signal.SIGALRM:
        return f"the query took longer than {order.time_limit:g} s: ask for less, or bind more of it"
    if code in (OUT_OF_MEMORY, -signal.SIGABRT, -signal.SIGKILL):
        return f"the query needs more than {order.memory >> 20} MiB of memory: ask for less, or bind more of it"
    if code in (-signal.SIGSEGV, -signal.SIGBUS):
        return "the query is too deep or too long for the engine: take it apart"
    return f"the query was cancelled (status {code})"

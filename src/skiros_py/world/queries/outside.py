"""Queries from untrusted users and programs: each gets an answer or an error in time, from a process of its own.

A query may be nested so deeply that the engine crashes, run forever, or exhaust the memory. So it never runs in
this process but in a copy of a replica of the world (see :mod:`~skiros_py.world.queries.replica`).
"""

from __future__ import annotations

import os
import pickle
import select
import signal
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Self

from skiros_py.errors import DeviceError, SkirosError, UsageError, WorldError
from skiros_py.processes import end_connected, packed, receive, send, start_python
from skiros_py.world.change import Change
from skiros_py.world.index import Index
from skiros_py.world.queries.answering import Binding, Result
from skiros_py.world.queries.replica import OUT_OF_MEMORY, Order
from skiros_py.world.store.store import AnswerLimits
from skiros_py.world.world import World

QUERIES = "skiros_py.world.queries.replica:QueryReplica"
"""Answers SPARQL queries."""

_LONGEST_START = 120.0
"""How long a replica may take to start a query [s]: there may be many changes to apply first."""
_GRACE = 1.0
"""How much later than the kernel we check the clock [s]."""
_LOOK = 0.1
"""Interval between checks of the clock [s]."""
_PIECE = 1 << 16


class ReplicaProcess:
    """A running replica of a world.

    Attributes:
        version: Number of the last change that it was sent.
    """

    def __init__(self, version: int, index: Index, program: str = QUERIES, *more: object) -> None:
        """Starts one with a state, and waits until it is ready.

        Args:
            version: Number of the last change.
            index: The state.
            program: The class that handles its orders, see :func:`skiros_py.world.queries.replica.main`.
            *more: Further arguments of that class.

        Raises:
            DeviceError: It does not start.
        """
        self.version = version
        state = _packed(version, index, *more)
        self._process, self._control = start_python("skiros_py.world.queries.replica:main", program)
        try:
            self._control.settimeout(_LONGEST_START)
            send(self._control, state)
            receive(self._control)
        except (OSError, EOFError) as error:
            self.close()
            why = "SKIROS_DEBUG=1 shows why"
            raise DeviceError(f"the process with the replica does not start ({why}): {error}") from None

    def is_alive(self) -> bool:
        """Returns True while it runs."""
        return self._process.poll() is None

    @property
    def pid(self) -> int:
        """Its id."""
        return self._process.pid

    def ask(self, changes: Sequence[Change], order: bytes) -> Pending:
        """Sends it a query.

        Args:
            changes: The changes after its version.
            order: The query, as bytes that its program decodes.

        Raises:
            DeviceError: It is gone.
        """
        payload = packed((tuple(changes), order))
        (answer, answer_there), (status, status_there) = os.pipe(), os.pipe()
        pending = Pending(answer, status, self)
        try:
            send(self._control, payload, [answer_there, status_there])
        except OSError as error:
            pending.close()
            self.close()
            raise DeviceError(f"the process with the replica is gone: {error}") from None
        finally:
            os.close(answer_there)
            os.close(status_there)
        if changes:
            self.version = changes[-1].number
        return pending

    def close(self) -> None:
        """Ends it and its running queries."""
        end_connected(self._process, self._control, _GRACE)

    def kill(self) -> None:
        """Kills it."""
        self._process.kill()
        self._process.wait()


@dataclass(frozen=True, slots=True)
class Ended:
    """A query that has ended.

    Attributes:
        answer: Its output.
        code: Its exit status, or the negative number of the signal that ended it.
    """

    answer: bytes
    code: int


class Pending:
    """A query that was sent to a replica.

    Args:
        answer, status: Descriptors of the pipes for its answer, and for its start and exit status.
        replica: The replica.
    """

    def __init__(self, answer: int, status: int, replica: ReplicaProcess) -> None:
        self._answer = answer
        self._status = status
        self._replica = replica
        self._begun: float | None = None

    def wait(self, time_limit: float) -> Ended:
        """Waits until it has ended.

        Args:
            time_limit: How long it may run from when it begins [s]; the kernel ends it then.

        Raises:
            DeviceError: The replica died.
        """
        asked = time.monotonic()

        def hangs() -> bool:
            limit = time_limit + _GRACE if self._begun is not None else _LONGEST_START
            return time.monotonic() - (self._begun or asked) > limit

        try:
            ended = self.wait_unless(hangs, _LOOK)
        except DeviceError:
            self._replica.kill()  # its pipes close a moment before it counts as ended
            raise
        if ended is None:  # the replica itself hangs; the next query gets a new one
            self._replica.kill()
        return ended or Ended(b"", -signal.SIGALRM)

    def wait_unless(self, stopped: Callable[[], bool], every: float) -> Ended | None:
        """Waits until it has ended; returns None if that is no longer wanted.

        Args:
            stopped: Returns True once it is no longer needed.
            every: Interval at which that is checked [s].

        Raises:
            DeviceError: The replica died.
        """
        try:
            answer, status = bytearray(), bytearray()
            waiting = select.poll()
            waiting.register(self._answer, select.POLLIN)
            waiting.register(self._status, select.POLLIN)
            left = {self._answer, self._status}
            while left:
                if stopped():
                    return None
                for source, _ in waiting.poll(every * 1e3):
                    piece = os.read(source, _PIECE)
                    (answer if source == self._answer else status).extend(piece)
                    if not piece:
                        waiting.unregister(source)
                        left.remove(source)
                    elif source == self._status:
                        self._begun = self._begun or time.monotonic()
                if self._status not in left and status.count(b"\n") < 2:
                    raise DeviceError("the process with the replica died")
            return Ended(bytes(answer), int(status.split()[-1]))
        finally:
            self.close()

    def close(self) -> None:
        """Stops waiting."""
        os.close(self._answer)
        os.close(self._status)


class FollowingReplica:
    """The replica of a live world: started for the first order, up to date for each, started again if it died.

    Any thread may ask. Close it.

    Args:
        world: The world.
        program: The class that handles its orders; see :class:`ReplicaProcess`.
        *more: Further arguments of that class.
        on_death: Called with the process id of one that died before it was closed.
    """

    def __init__(
        self, world: World, program: str = QUERIES, *more: object, on_death: Callable[[int], None] = lambda _: None
    ) -> None:
        self._world = world
        self._program, self._more = program, more
        self._on_death = on_death
        self._lock = threading.Lock()
        self._replica: ReplicaProcess | None = None
        self._closed = False

    @property
    def pid(self) -> int | None:
        """Id of the process; None if it does not run."""
        replica = self._replica
        return None if replica is None or not replica.is_alive() else replica.pid

    def start(self) -> None:
        """Starts the replica, as the first order would; a million triples take half a minute."""
        with self._lock:
            self._started()

    def ask(self, order: bytes) -> tuple[int, Pending]:
        """Sends it an order about the present world; returns the version of that, too.

        Raises:
            DeviceError: It died, cannot be started, or was closed.
        """
        with self._lock:
            replica = self._started()
            try:
                changes = self._world.changes_since(replica.version)
            except WorldError:  # they are no longer kept
                self._drop()
                replica, changes = self._started(), ()
            pending = replica.ask(changes, order)
            return replica.version, pending

    def close(self) -> None:
        """Ends the process and its running orders; may be called twice."""
        with self._lock:
            self._closed = True
            self._drop()

    def _started(self) -> ReplicaProcess:
        if self._closed:  # a thread that was waiting must not start it again
            raise DeviceError("nothing is answered any more: the process with the replica was closed")
        if self._replica is None or not self._replica.is_alive():
            self._drop()
            self._replica = ReplicaProcess(*self._world.state(), self._program, *self._more)
        return self._replica

    def _drop(self) -> None:
        replica, self._replica = self._replica, None
        if replica is not None:
            died = not replica.is_alive()
            replica.close()
            if died:
                self._on_death(replica.pid)


def _packed(*state: object) -> bytes:
    try:
        return packed(state)
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise DeviceError(f"the world cannot be copied to another process: {error}") from None


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
        memory: Bytes in addition to the memory of the world itself.
        rows: Rows or triples of the answer.
        bytes: Characters of all terms of the answer together.
        at_once: Queries that may run at the same time; others wait for their turn, up to their time limit.
    """

    text: int = 64 * 1024
    time: float = 5.0
    memory: int = 1024 * _MIB
    rows: int = 10_000
    bytes: int = 16 * _MIB
    at_once: int = 4


class OutsideQueries:
    """Answers external queries. Close it, or use it in a ``with``; any thread may ask.

    Args:
        world: The world; each query sees everything written before it.
        limits: Limits of a query.
    """

    def __init__(self, world: World, limits: Limits = Limits()) -> None:
        self.limits = limits
        self._turns = threading.BoundedSemaphore(limits.at_once)
        self._replica = FollowingReplica(world)

    def start(self) -> None:
        """Starts the replica, as the first query would; a million triples take half a minute."""
        self._replica.start()

    def close(self) -> None:
        """Ends the replica and all running queries; no more answers are given."""
        self._replica.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
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
            bindings: Values of its parameters, by name.
            entailed: Whether to include triples entailed by OWL.
            time_limit: Time limit [s]; None for the default.

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
        packed_order = pickle.dumps(order)
        try:
            ended = self._replica.ask(packed_order)[1].wait(order.time_limit)
        except DeviceError:  # the replica was killed: retry with a new one
            ended = self._replica.ask(packed_order)[1].wait(order.time_limit)
        if ended.code != 0:
            raise UsageError(_why(ended.code, order))
        outcome = pickle.loads(ended.answer)  # noqa: S301  from our own process
        if isinstance(outcome, SkirosError):
            raise outcome
        result: Result = outcome
        return result


def _why(code: int, order: Order) -> str:
    """Returns why a query ended without an answer."""
    if code == -signal.SIGALRM:
        return f"the query took longer than {order.time_limit:g} s: ask for less, or bind more of it"
    if code in (OUT_OF_MEMORY, -signal.SIGABRT, -signal.SIGKILL):
        return f"the query needs more than {order.memory >> 20} MiB of memory: ask for less, or bind more of it"
    if code in (-signal.SIGSEGV, -signal.SIGBUS):
        return "the query is too deep or too long for the engine: take it apart"
    return f"the query was cancelled (status {code})"

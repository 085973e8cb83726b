"""Queries from untrusted users and programs: each gets an answer or an error in time, from a process of its own.

A query may be nested so deeply that the engine crashes, run forever, or exhaust the memory. So it never runs in
this process but in a copy of a replica of the world (see :mod:`~skiros_py.world.queries.replica`).
"""

from __future__ import annotations

import os
import pickle
import select
import signal
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from types import MappingProxyType

from skiros_py.errors import DeviceError, SkirosError, UsageError, WorldError
from skiros_py.processes import end_connected, is_stopped, packed, receive, send, start_python
from skiros_py.world.queries.answering import Binding, Result
from skiros_py.world.queries.replica import OUT_OF_MEMORY, USUAL_LIMITS, Limits, Order
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
        replica: The process of the replica.
    """

    def __init__(self, answer: int, status: int, replica: subprocess.Popen[bytes]) -> None:
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
            self._kill()  # its pipes close a moment before it counts as ended
            raise
        if ended is None:  # the replica itself hangs; the next query gets a new one
            self._kill()
        return ended or Ended(b"", -signal.SIGALRM)

    def wait_unless(self, stopped: Callable[[], bool], every: float) -> Ended | None:
        """Waits until it has ended; returns None if that is no longer wanted.

        Args:
            stopped: Returns True once it is no longer needed.
            every: Interval at which that is checked [s].

        Raises:
            DeviceError: The replica died, or was suspended and therefore killed.
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
                if is_stopped(self._replica.pid):
                    self._kill()
                    raise DeviceError("the process with the replica was suspended")
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

    def _kill(self) -> None:
        self._replica.kill()
        self._replica.wait()


class FollowingReplica:
    """The replica of a live world: started for the first order, up to date for each, started again if it died.

    Any thread may ask. Close it.

    Args:
        world: The world.
        program: The class that handles its orders, see :func:`skiros_py.world.queries.replica.main`.
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
        self._running: tuple[subprocess.Popen[bytes], socket.socket] | None = None
        self._version = 0
        self._closed = False

    @property
    def pid(self) -> int | None:
        """Id of the process; None if it does not run."""
        running = self._running
        return None if running is None or running[0].poll() is not None else running[0].pid

    def start(self) -> None:
        """Starts the replica, as the first order would; a million triples take half a minute."""
        with self._lock:
            self._started()

    def ask(self, order: bytes) -> tuple[int, Pending]:
        """Sends it an order about the current world; returns the version of that, too.

        Args:
            order: The order, as bytes that its program decodes.

        Raises:
            DeviceError: It died, cannot be started, or was closed.
        """
        with self._lock:
            process, control = self._started()
            try:
                changes = self._world.changes_since(self._version)
            except WorldError:  # they are no longer kept
                self._drop()
                (process, control), changes = self._started(), ()
            payload = packed((tuple(changes), order))
            (answer, answer_there), (status, status_there) = os.pipe(), os.pipe()
            pending = Pending(answer, status, process)
            try:
                send(control, payload, [answer_there, status_there])
            except OSError as error:
                pending.close()
                self._drop()
                raise DeviceError(f"the process with the replica is gone: {error}") from None
            finally:
                os.close(answer_there)
                os.close(status_there)
            if changes:
                self._version = changes[-1].number
            return self._version, pending

    def close(self) -> None:
        """Ends the process and its running orders; may be called twice."""
        with self._lock:
            self._closed = True
            self._drop()

    def _started(self) -> tuple[subprocess.Popen[bytes], socket.socket]:
        if self._closed:  # a thread that was waiting must not start it again
            raise DeviceError("nothing is answered any more: the process with the replica was closed")
        if self._running is not None and self._running[0].poll() is None:
            return self._running
        self._drop()
        index = self._world.snapshot()
        self._version = index.version
        state = _packed(index, *self._more)
        process, control = start_python("skiros_py.world.queries.replica:main", self._program)
        try:
            control.settimeout(_LONGEST_START)
            send(control, state)
            receive(control)
        except (OSError, EOFError) as error:
            end_connected(process, control, _GRACE)
            why = "SKIROS_DEBUG=1 shows why"
            raise DeviceError(f"the process with the replica does not start ({why}): {error}") from None
        self._running = process, control
        return self._running

    def _drop(self) -> None:
        running, self._running = self._running, None
        if running is not None:
            died = running[0].poll() is not None
            end_connected(*running, _GRACE)
            if died:
                self._on_death(running[0].pid)


def _packed(*state: object) -> bytes:
    try:
        return packed(state)
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise DeviceError(f"the world cannot be copied to another process: {error}") from None


LONGEST_TIME = 3600.0
"""Maximum time limit of any query [s]."""

_NO_BINDINGS: Mapping[str, Binding] = MappingProxyType({})


class OutsideQueries(AbstractContextManager["OutsideQueries"]):
    """Answers external queries. Close it, or use it in a ``with``; any thread may ask.

    Args:
        world: The world; each query sees everything written before it.
        limits: Limits of a query.
    """

    def __init__(self, world: World, limits: Limits = USUAL_LIMITS) -> None:
        self.limits = limits
        self._turns = threading.BoundedSemaphore(limits.at_once)
        self._replica = FollowingReplica(world)

    def start(self) -> None:
        """Starts the replica, as the first query would; a million triples take half a minute."""
        self._replica.start()

    def close(self) -> None:
        """Ends the replica and all running queries; no more answers are given."""
        self._replica.close()

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
        order = Order(sparql, dict(bindings), entailed, replace(self.limits, time=limit))
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
            ended = self._replica.ask(packed_order)[1].wait(order.limits.time)
        except DeviceError:  # the replica was killed: retry with a new one
            ended = self._replica.ask(packed_order)[1].wait(order.limits.time)
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
        return f"the query took longer than {order.limits.time:g} s: ask for less, or bind more of it"
    if code in (OUT_OF_MEMORY, -signal.SIGABRT, -signal.SIGKILL):
        return f"the query needs more than {order.limits.memory >> 20} MiB of memory: ask for less, or bind more of it"
    if code in (-signal.SIGSEGV, -signal.SIGBUS):
        return "the query is too deep or too long for the engine: take it apart"
    return f"the query was cancelled (status {code})"

"""The replica as its parent sees it: a process to start, to hand queries to, and to wait for."""

from __future__ import annotations

import os
import pickle
import select
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from skiros_py.errors import DeviceError
from skiros_py.processes import packed, receive, send, start_python
from skiros_py.world.change import Change
from skiros_py.world.index import Index

QUERIES = "skiros_py.world.queries.replica:QueryReplica"
"""Answers SPARQL queries."""

_LONGEST_START = 120.0
"""How long a replica may take to begin with a query [s]: there may be much to write into it first."""
_GRACE = 1.0
"""How much later than the kernel we look at the clock [s]."""
_LOOK = 0.1
"""Time between two looks at the clock [s]."""
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
            program: What it does for an order, see :func:`skiros_py.world.queries.replica.main`.
            *more: What that program is made with besides.

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
        """Hands it a query.

        Args:
            changes: What was written after its version.
            order: The query, as bytes that the program reads.

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
        """Ends it, and the queries that it runs."""
        self._control.close()
        try:
            self._process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            self.kill()

    def kill(self) -> None:
        """Ends it at once."""
        self._process.kill()
        self._process.wait()


@dataclass(frozen=True, slots=True)
class Ended:
    """A query that has ended.

    Attributes:
        answer: What it wrote.
        code: Its exit status, or the negative number of the signal that ended it.
    """

    answer: bytes
    code: int


class Pending:
    """A query that was handed to a replica.

    Args:
        answer, status: Descriptors of the pipes on which its answer, and what becomes of it, come.
        replica: What it was handed to.
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
            every: Time between two looks whether it is [s].

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
        """Waits no longer."""
        os.close(self._answer)
        os.close(self._status)


def _packed(*state: object) -> bytes:
    try:
        return packed(state)
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise DeviceError(f"the world cannot be copied to another process: {error}") from None

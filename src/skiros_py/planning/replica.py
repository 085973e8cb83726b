"""The planning process: a replica of the world with workers, forked copies that answer requests.

A worker answers one request at a time and stays for the next: its planners and everything it has loaded stay warm. A
worker that hangs, crashes or is killed affects no other.
"""

from __future__ import annotations

import contextlib
import math
import os
import pickle
import select
import selectors
import signal
import socket
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from skiros_py.errors import SkirosError, UsageError
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.requests import Request, answered
from skiros_py.processes import packed, receive, send
from skiros_py.programs import kill_marked
from skiros_py.world.change import Change
from skiros_py.world.index import Index
from skiros_py.world.queries.replica import Replica

MARK = "SKIROS_PLANNING"
"""Environment variable that marks programs started by workers."""
PROCESSOR_TIME = 120.0
"""CPU time limit of a worker per answer; external planner programs have their own limits [s]."""

_KEPT = 2
"""How many idle workers are kept."""
_MOST_MISSED = 1000
"""An idle worker that is more world changes behind is replaced by a new fork."""
_PATIENCE = 1.0
"""How long a worker may go on with a request that was cancelled [s]."""
_ENDING = 0.5
"""How long workers may take to end their planners when the process ends [s]."""


@dataclass(slots=True, eq=False)
class _Worker:
    """A worker as the replica sees it.

    Attributes:
        pid: Its process id.
        mark: Environment marker of the programs it starts.
        orders: The socket to it.
        missed: World changes since its last request.
        status: Descriptor of the pipe on which the end of its request is reported; None while it has none.
        deadline: When it is killed, on the monotonic clock [s].
        is_leaving: True when it gets no more requests.
    """

    pid: int
    mark: str
    orders: socket.socket
    missed: list[Change] = field(default_factory=list)
    status: int | None = None
    deadline: float = math.inf
    is_leaving: bool = False


class PlanningReplica(Replica):
    """The replica and its workers.

    Args:
        index: The state of the world.
        make_planners: Pickled; makes the planners of a worker.
        mark: Identifies the programs of this process.
    """

    def __init__(self, index: Index, make_planners: bytes, mark: str) -> None:
        super().__init__(index)
        self._make_planners: Callable[[], Planners] = pickle.loads(make_planners)  # noqa: S301  from our own parent
        self._marks = (f"{mark}.{number}." for number in count())
        self._workers: list[_Worker] = []
        self._selector = selectors.DefaultSelector()

    def serve(self, parent: socket.socket) -> None:
        """Hands requests to workers until the parent goes."""
        self._selector.register(parent, selectors.EVENT_READ)
        self._fork((parent.fileno(),))
        try:
            while True:
                self._kill_late_workers()
                for key, _ in self._selector.select(self._time_left())[:1]:  # what comes next may be of another request
                    if key.fileobj is parent:
                        self._take_order(parent)
                    elif key.fileobj is key.data.orders:
                        self._hear(key.data)
                    else:
                        self._cancel(key.data)
        except EOFError:
            self._end()

    def _take_order(self, parent: socket.socket) -> None:
        payload, (answer, status) = receive(parent, files=2)
        changes, order = pickle.loads(payload)  # noqa: S301  from our own parent
        self.follow(changes)
        for worker in self._workers:
            worker.missed += changes
        idle = self._idle()
        for worker in idle:
            if len(worker.missed) > _MOST_MISSED:
                _dismiss(worker)
        worker = next((one for one in idle if not one.is_leaving), None) or self._fork(
            (parent.fileno(), answer, status), order
        )
        worker.status = status
        self._selector.register(status, selectors.EVENT_READ, worker)  # it is "readable" once the reader has closed it
        with contextlib.suppress(OSError):  # it has died: its end is reported elsewhere
            send(worker.orders, pickle.dumps((worker.missed, order)), [answer])
        worker.missed = []
        os.close(answer)
        _write(status, "started")

    def _fork(self, not_its: Iterable[int], order: bytes | None = None) -> _Worker:
        """Starts a worker; modules its first request needs are imported here, so that later forks have them.

        Args:
            not_its: Open descriptors that the worker must not have.
            order: Its first request.
        """
        if order is not None:
            with contextlib.suppress(Exception):
                pickle.loads(order)  # noqa: S301  from our own parent
        ours, theirs = socket.socketpair()
        mark = next(self._marks)
        pid = os.fork()
        if pid == 0:
            ours.close()
            self._selector.close()
            for descriptor in not_its:
                os.close(descriptor)
            for other in self._workers:
                other.orders.close()
                if other.status is not None:
                    os.close(other.status)
            os.environ[MARK] = mark
            self._work(theirs)
        theirs.close()
        worker = _Worker(pid, mark, ours)
        self._workers.append(worker)
        self._selector.register(ours, selectors.EVENT_READ, worker)
        return worker

    def _idle(self) -> list[_Worker]:
        return [worker for worker in self._workers if worker.status is None and not worker.is_leaving]

    # ------------------------------------------------------------ end of workers

    def _hear(self, worker: _Worker) -> None:
        """Reports that a worker has answered, or has ended."""
        try:
            receive(worker.orders)
            code = 0
        except (EOFError, OSError):
            code = self._reap(worker)
        worker.deadline = math.inf
        if worker.status is not None:
            with contextlib.suppress(KeyError):  # cancelled
                self._selector.unregister(worker.status)
            _write(worker.status, str(code))
            os.close(worker.status)
            worker.status = None
        for one in self._idle()[_KEPT:]:
            _dismiss(one)

    def _reap(self, worker: _Worker) -> int:
        self._selector.unregister(worker.orders)
        self._workers.remove(worker)
        worker.orders.close()
        code = os.waitstatus_to_exitcode(os.waitpid(worker.pid, 0)[1])
        if code != 0:
            kill_marked(MARK, worker.mark)
        return code

    def _cancel(self, worker: _Worker) -> None:
        """Marks a request as cancelled: the worker notices by itself, unless it hangs."""
        assert worker.status is not None
        self._selector.unregister(worker.status)
        worker.deadline = time.monotonic() + _PATIENCE

    def _time_left(self) -> float | None:
        first = min((worker.deadline for worker in self._workers), default=math.inf)
        return None if math.isinf(first) else max(0.0, first - time.monotonic())

    def _kill_late_workers(self) -> None:
        for worker in self._workers:
            if worker.deadline <= time.monotonic():
                os.kill(worker.pid, signal.SIGKILL)
                worker.deadline = math.inf

    def _end(self) -> None:
        """Gives workers a short time to end their planners."""
        for worker in self._workers:
            worker.orders.close()
        deadline, left = time.monotonic() + _ENDING, list(self._workers)
        while left and time.monotonic() < deadline:
            left = [worker for worker in left if os.waitpid(worker.pid, os.WNOHANG)[0] == 0]
            time.sleep(0.002)
        for worker in left:
            os.kill(worker.pid, signal.SIGKILL)
            os.waitpid(worker.pid, 0)
            kill_marked(MARK, worker.mark)

    # ------------------------------------------------------------ in a worker

    def _work(self, orders: socket.socket) -> None:
        """Answers requests until the replica is gone, then exits the process."""
        code, planners = 1, None
        try:
            with contextlib.suppress(Exception):  # a request will report what is wrong with them
                planners = self._make_planners()
                planners.warm_up()
            with contextlib.suppress(EOFError, OSError):
                while True:
                    payload, (answer,) = receive(orders, files=1)
                    changes, order = pickle.loads(payload)  # noqa: S301  from our own parent
                    self.follow(changes)
                    with contextlib.suppress(BrokenPipeError), os.fdopen(answer, "wb") as file:
                        try:
                            planners = planners or self._make_planners()
                            value = self._value(order, planners, answer, orders)
                        except SkirosError as error:
                            value = error
                        file.write(packed(value))
                    send(orders, b"done")
            if planners is not None:
                planners.close()
            code = 0
        finally:
            os._exit(code)

    def _value(self, order: bytes, planners: Planners, answer: int, orders: socket.socket) -> object:
        """Answers one request; stops when it is cancelled or the replica is gone.

        Raises:
            SkirosError: There is no answer.
        """
        waiting = select.poll()
        waiting.register(answer, select.POLLERR)
        waiting.register(orders, select.POLLHUP)
        signal.signal(signal.SIGVTALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_VIRTUAL, PROCESSOR_TIME)
        try:
            request: Request[Any] = _request(order)
            return answered(request, self.index, planners, lambda: bool(waiting.poll(0)))
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)


def _request(order: bytes) -> Request[Any]:
    try:
        request: Request[Any] = pickle.loads(order)  # noqa: S301  from our own parent
    except Exception as error:
        why = f"{type(error).__name__}: {error}"
        raise UsageError(f"it cannot be read in another process: {why}") from error
    return request


def _dismiss(worker: _Worker) -> None:
    """Ends an idle worker."""
    worker.is_leaving = True
    with contextlib.suppress(OSError):
        worker.orders.shutdown(socket.SHUT_WR)


def _write(status: int, line: str) -> None:
    with contextlib.suppress(BrokenPipeError):
        os.write(status, f"{line}\n".encode())

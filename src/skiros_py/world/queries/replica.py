"""A process with a replica of the world, which forks for each order: a query from outside, a request for a plan.

A copy costs next to nothing and is a process with limits of its own: whatever an order does to it, the replica stays as
it is. The replica has one thread, so forking is safe.
"""

from __future__ import annotations

import contextlib
import gc
import math
import os
import pickle
import selectors
import signal
import socket
import time
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module

from skiros_py.errors import SkirosError, UsageError
from skiros_py.processes import is_stopped, limit, packed, receive, send
from skiros_py.world.change import Change
from skiros_py.world.index import Index
from skiros_py.world.queries.answering import Binding, Question, Result, typed
from skiros_py.world.store.projection import Projection
from skiros_py.world.store.store import AnswerLimits

OUT_OF_MEMORY = 77
"""Exit status of a query that could get no more memory; the engine itself aborts."""


def main(control: int, program: str) -> None:
    """Runs until the process that started it goes away.

    Args:
        control: Descriptor of the socket to that process.
        program: The subclass of :class:`Replica` that handles orders: "package.module:Class".
    """
    module, name = program.split(":")
    make = getattr(import_module(module), name)
    with socket.socket(fileno=control) as parent:
        replica: Replica = make(*pickle.loads(receive(parent)[0]))  # noqa: S301  from our own parent
        gc.freeze()  # these objects stay: collecting would copy their pages into each order's process
        send(parent, b"ready")
        replica.serve(parent)


_LOOK = 1.0
"""Interval between checks for suspended runs [s]."""


@dataclass(slots=True, eq=False)
class _Run:
    """An order under way.

    Attributes:
        pid: Id of its process.
        ended: Descriptor that becomes readable when that process ends.
        status: The pipe on which its end is reported; "readable" once its reader has closed it.
        deadline: When it is killed, on the monotonic clock [s].
    """

    pid: int
    ended: int
    status: int
    deadline: float = math.inf


class Replica(ABC):
    """A replica of the world in a process of its own; each order of its parent is handled in a forked copy.

    Attributes:
        index: The world.
        patience: How long an order may go on when its answer is no longer wanted [s].
    """

    patience = 0.0

    def __init__(self, index: Index) -> None:
        self.index = index
        self._selector = selectors.DefaultSelector()
        self._runs: list[_Run] = []
        self._is_open = True

    def follow(self, changes: Sequence[Change]) -> None:
        """Applies changes."""
        for change in changes:
            self.index.take(change)

    @abstractmethod
    def answer(self, order: bytes, answer: int) -> object:
        """Handles an order, in a forked copy of the replica.

        Args:
            order: The order, pickled.
            answer: The pipe for the answer; it reports an error once its reader is gone.

        Raises:
            SkirosError: There is no answer; the error is sent instead.
        """

    def after(self, pid: int, code: int) -> None:  # noqa: B027 - most have nothing to do
        """Called when the process of an order has ended, with its exit code."""

    def serve(self, parent: socket.socket) -> None:
        """Handles orders until the parent exits; those under way are then cancelled."""
        self._selector.register(parent, selectors.EVENT_READ)
        while self._is_open or self._runs:
            for key, _ in self._selector.select(self._kill_late_runs())[:1]:  # the next may be of a run that is over
                run: _Run | None = key.data
                if run is None:
                    self._take_order(parent)
                elif key.fd == run.ended:
                    self._report_end(run)
                else:
                    self._selector.unregister(run.status)
                    run.deadline = time.monotonic() + self.patience

    def _take_order(self, parent: socket.socket) -> None:
        """Starts an order; or cancels those under way if no more will come."""
        try:
            payload, (answer, status) = receive(parent, files=2)
        except EOFError:
            self._selector.unregister(parent)
            self._is_open = False
            for run in self._runs:
                run.deadline = min(run.deadline, time.monotonic() + self.patience)
            return
        changes, order = pickle.loads(payload)  # noqa: S301  from our own parent
        self.follow(changes)
        with contextlib.suppress(Exception):  # modules that it imports are then there for all
            pickle.loads(order)  # noqa: S301  from our own parent
        pid = os.fork()
        if pid == 0:
            parent.close()
            self._selector.close()
            for descriptor in (status, *(run.status for run in self._runs)):
                os.close(descriptor)
            self._handle(order, answer)
        os.close(answer)
        _write(status, "started")
        run = _Run(pid, os.pidfd_open(pid), status)
        self._runs.append(run)
        for descriptor in (run.ended, run.status):
            self._selector.register(descriptor, selectors.EVENT_READ, run)

    def _report_end(self, run: _Run) -> None:
        self._runs.remove(run)
        self._selector.unregister(run.ended)
        with contextlib.suppress(KeyError):  # cancelled
            self._selector.unregister(run.status)
        code = os.waitstatus_to_exitcode(os.waitpid(run.pid, 0)[1])
        self.after(run.pid, code)
        if self._is_open:  # otherwise it has been cancelled with the replica
            _write(run.status, str(code))
        os.close(run.ended)
        os.close(run.status)

    def _kill_late_runs(self) -> float | None:
        """Kills runs after their deadline, or that are suspended; returns when to look again [s], None for never."""
        now = time.monotonic()
        for run in self._runs:
            if run.deadline <= now or is_stopped(run.pid):
                os.kill(run.pid, signal.SIGKILL)
                run.deadline = math.inf
        return min((min(run.deadline - now, _LOOK) for run in self._runs), default=None)

    def _handle(self, order: bytes, answer: int) -> None:
        """Handles an order in this process and ends it."""
        code = 1
        try:
            try:
                value = self.answer(order, answer)
            except SkirosError as error:
                value = error
            with os.fdopen(answer, "wb") as file:
                file.write(packed(value))
            code = 0
        except MemoryError:
            code = OUT_OF_MEMORY
        except BrokenPipeError:
            code = 0  # the answer is no longer wanted
        finally:
            os._exit(code)


def _write(status: int, line: str) -> None:
    with contextlib.suppress(BrokenPipeError):  # it may no longer be wanted
        os.write(status, f"{line}\n".encode())


_MIB = 1 << 20


@dataclass(frozen=True, slots=True)
class Limits(AnswerLimits):
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


USUAL_LIMITS = Limits()


@dataclass(frozen=True, slots=True)
class Order:
    """A query to answer.

    Attributes:
        sparql: The query.
        bindings: Values of its parameters, by name.
        entailed: Whether to include triples entailed by OWL.
        limits: Its limits.
    """

    sparql: str
    bindings: Mapping[str, Binding]
    entailed: bool
    limits: Limits


class QueryReplica(Replica):
    """Answers external queries."""

    def __init__(self, index: Index) -> None:
        super().__init__(index)
        _warm_up()
        self._projection = Projection(index)

    def follow(self, changes: Sequence[Change]) -> None:
        """Applies changes, to the triples too."""
        super().follow(changes)
        self._projection.follow(changes)

    def answer(self, order: bytes, answer: int) -> Result:  # noqa: ARG002 - the kernel ends what takes too long
        """Answers a query.

        Raises:
            SkirosError: There is no answer.
        """
        query: Order = pickle.loads(order)  # noqa: S301  from our own parent
        limit(seconds=query.limits.time, memory=query.limits.memory)
        gc.disable()
        os.nice(5)  # queries from outside come after everything else
        try:
            return self._result(query)
        except (SkirosError, MemoryError):
            raise
        except Exception as error:  # a reasoner's fault
            raise UsageError(f"the query cannot be answered: {type(error).__name__}: {error}") from error

    def _result(self, order: Order) -> Result:
        names = self.index.ontology.names
        question = Question.of(names, order.sparql, order.bindings)
        store = self._projection.entailed() if order.entailed else self._projection.store
        return typed(names, question.answer(store, self.index, order.limits))


def _warm_up() -> None:
    """Does once what each query would repeat in its copy: imports, and the tables of rdflib's parser."""
    from skiros_py.world.queries.computed import query_groups

    query_groups("ASK { ?a ?b ?c }", lambda _: True)

"""A process with a replica of the world, which forks for each query from outside.

A copy costs next to nothing and is a process with limits of its own: whatever a query does to it, the replica stays as
it is. The replica has one thread, so forking is safe.
"""

from __future__ import annotations

import contextlib
import gc
import os
import pickle
import selectors
import signal
import socket
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module

from loky.backend.reduction import dumps

from skiros_py.errors import SkirosError, UsageError
from skiros_py.processes import limit, receive, send
from skiros_py.world.change import Change
from skiros_py.world.index import Index
from skiros_py.world.queries.answering import Binding, Question, Result, typed
from skiros_py.world.store import Projection
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


class Replica(ABC):
    """A replica of the world in a process of its own, which handles orders of its parent.

    Attributes:
        index: The world.
    """

    def __init__(self, index: Index) -> None:
        self.index = index

    def follow(self, changes: Sequence[Change]) -> None:
        """Applies changes."""
        for change in changes:
            self.index.take(change)

    @abstractmethod
    def serve(self, parent: socket.socket) -> None:
        """Handles orders until the parent exits."""


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
        self._selector = selectors.DefaultSelector()

    def follow(self, changes: Sequence[Change]) -> None:
        """Applies changes, to the triples too."""
        super().follow(changes)
        self._projection.follow(changes)

    def serve(self, parent: socket.socket) -> None:
        """Handles orders until the parent exits."""
        self._selector.register(parent, selectors.EVENT_READ)
        try:
            while True:
                for key, _ in self._selector.select():
                    if key.fileobj is parent:
                        self._take_order(parent)
                    else:
                        self._report_end(key)
        except EOFError:
            for key in self._selector.get_map().values():
                if key.data is not None:
                    os.kill(key.data[0], signal.SIGKILL)

    def _take_order(self, parent: socket.socket) -> None:
        payload, (answer, status) = receive(parent, files=2)
        changes, packed = pickle.loads(payload)  # noqa: S301  from our own parent
        self.follow(changes)
        order = pickle.loads(packed)  # noqa: S301  from our own parent
        child = os.fork()
        if child == 0:
            parent.close()
            for other in (status, *(key.data[1] for key in self._selector.get_map().values() if key.data is not None)):
                os.close(other)
            self._run(order, answer)
        os.close(answer)
        os.write(status, b"started\n")
        self._selector.register(os.pidfd_open(child), selectors.EVENT_READ, (child, status))

    def _report_end(self, key: selectors.SelectorKey) -> None:
        """Reports how a query's process has ended."""
        child, status = key.data
        self._selector.unregister(key.fileobj)
        assert isinstance(key.fileobj, int)
        os.close(key.fileobj)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        with contextlib.suppress(BrokenPipeError):  # the answer may no longer be wanted
            os.write(status, f"{code}\n".encode())
        os.close(status)

    def _run(self, order: Order, answer: int) -> None:
        """Answers one order in this process and ends it."""
        code = 1
        try:
            limit(seconds=order.limits.time, memory=order.limits.memory)
            gc.disable()
            os.nice(5)  # queries from outside come after everything else
            outcome = self._outcome(order)
            with os.fdopen(answer, "wb") as file:
                file.write(dumps(outcome))
            code = 0
        except MemoryError:
            code = OUT_OF_MEMORY
        except BrokenPipeError:
            code = 0  # the answer is no longer wanted
        finally:
            os._exit(code)

    def _outcome(self, order: Order) -> object:
        """Returns the answer, or the error instead of it."""
        try:
            return self._result(order)
        except SkirosError as error:
            return error
        except MemoryError:
            raise
        except Exception as error:  # noqa: BLE001  a reasoner's fault: it is reported to the caller
            return UsageError(f"the query cannot be answered: {type(error).__name__}: {error}")

    def _result(self, order: Order) -> Result:
        names = self.index.ontology.names
        question = Question.of(names, order.sparql, order.bindings)
        store = self._projection.entailed() if order.entailed else self._projection.store
        return typed(names, question.answer(store, self.index, order.limits))


def _warm_up() -> None:
    """Does once what each query would repeat in its copy: imports, and the tables of rdflib's parser."""
    from skiros_py.world.queries.computed import query_groups

    query_groups("ASK { ?a ?b ?c }", lambda _: True)

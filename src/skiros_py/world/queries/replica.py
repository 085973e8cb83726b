"""The process that answers queries from outside: a replica of the world, of which each query gets a copy.

It forks for each query. The copy costs nothing, is a process of its own with limits of its own, and whatever a query
does to it, be it to kill it, hurts nobody: the kernel ends it. The replica has one thread, so that forking is safe.
"""

from __future__ import annotations

import contextlib
import gc
import os
import pickle
import resource
import selectors
import signal
import socket
from pathlib import Path

from skiros_py.errors import SkirosError, UsageError
from skiros_py.world.index import Index
from skiros_py.world.queries.answering import Question, Result, typed
from skiros_py.world.queries.wire import OUT_OF_MEMORY, Order, receive, send
from skiros_py.world.store import Projection

__all__ = ["main"]


def main(control: int) -> None:
    """Runs until whoever started it goes away.

    Args:
        control: Descriptor of the socket to that.
    """
    with socket.socket(fileno=control) as parent:
        version, index = pickle.loads(receive(parent)[0])  # noqa: S301  from our own parent
        replica = _Replica(version, index, parent)
        send(parent, b"ready")
        replica.serve()


class _Replica:
    def __init__(self, version: int, index: Index, parent: socket.socket) -> None:
        _warm_up()
        self._index = index
        self._projection = Projection(version, index)
        self._parent = parent
        self._selector = selectors.DefaultSelector()
        self._selector.register(parent, selectors.EVENT_READ)
        gc.freeze()  # what is here stays: looking at it would copy it into each query's process

    def serve(self) -> None:
        """Answers until the parent goes."""
        try:
            while True:
                for key, _ in self._selector.select():
                    if key.fileobj is self._parent:
                        self._take_order()
                    else:
                        self._bury(key)
        except EOFError:
            for key in self._selector.get_map().values():
                if key.data is not None:
                    os.kill(key.data[0], signal.SIGKILL)

    def _take_order(self) -> None:
        payload, (answer, status) = receive(self._parent, files=2)
        changes, order = pickle.loads(payload)  # noqa: S301  from our own parent
        for change in changes:
            for edit in change.edits:
                self._index.apply(edit)
        self._projection.follow(changes)
        child = os.fork()
        if child == 0:
            self._be_the_query(order, answer)
        os.close(answer)
        os.write(status, b"started\n")
        self._selector.register(os.pidfd_open(child), selectors.EVENT_READ, (child, status))

    def _bury(self, key: selectors.SelectorKey) -> None:
        """A query's process has ended: says how."""
        child, status = key.data
        self._selector.unregister(key.fileobj)
        assert isinstance(key.fileobj, int)
        os.close(key.fileobj)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        with contextlib.suppress(BrokenPipeError):  # nobody may wait any more
            os.write(status, f"{code}\n".encode())
        os.close(status)

    def _be_the_query(self, order: Order, answer: int) -> None:
        """Lives and dies as the process of one query."""
        code = 1
        try:
            self._parent.close()
            _limit(order)
            with os.fdopen(answer, "wb") as file:
                pickle.dump(self._outcome(order), file)
            code = 0
        except MemoryError:
            code = OUT_OF_MEMORY
        finally:
            os._exit(code)

    def _outcome(self, order: Order) -> Result | SkirosError:
        try:
            return self._result(order)
        except SkirosError as error:
            return error
        except MemoryError:
            raise
        except Exception as error:  # noqa: BLE001  a reasoner's: it is for whoever asked
            return UsageError(f"the query cannot be answered: {type(error).__name__}: {error}")

    def _result(self, order: Order) -> Result:
        names = self._index.ontology.names
        question = Question.of(names, order.sparql, order.bindings)
        if order.form is not None:
            question.must_be(order.form)
        store = self._projection.entailed() if order.entailed else self._projection.store
        return typed(names, question.answer(store, self._index, order.most))


def _warm_up() -> None:
    """Does once what each query would do in its copy: imports, and what rdflib's parser makes when first used."""
    from skiros_py.world.queries.patterns import query_groups

    query_groups("ASK { ?a ?b ?c }", lambda _: True)


def _limit(order: Order) -> None:
    """Lets the kernel watch over this process."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, order.time_limit)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    most = pages * resource.getpagesize() + order.memory
    resource.setrlimit(resource.RLIMIT_AS, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    gc.disable()
    os.nice(5)  # who waits for nobody from outside goes first

"""Worker processes for what would hold the interpreter: planners, perception, rendering.

A worker owns one object, built inside its own process; calls are answered in order. The processes are loky's, which
need no ``if __name__ == "__main__"`` in the user's script; they ignore Ctrl-C and SIGTERM (the parent decides) and end
with their parent.
"""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from typing import Any, Generic, TypeVar

from loky import ProcessPoolExecutor
from loky.process_executor import BrokenProcessPool, ShutdownExecutorError, TerminatedWorkerError

from skiros_py.errors import DeviceError

T = TypeVar("T")

_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
_DEAD = (BrokenProcessPool, TerminatedWorkerError, ShutdownExecutorError)
_STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that ask a run to end; its parent hears them and ends the workers in order."""
_subject: Any = None


class Call(Generic[T]):
    """A call under way in a worker; a :class:`skiros_py.ports.values.Pending`.

    Attributes:
        latency: Declared time from request to answer [s].
    """

    def __init__(self, future: Future[T], worker: str, latency: float) -> None:
        self._future = future
        self._worker = worker
        self.latency = latency

    def done(self) -> bool:
        """Returns True when :meth:`result` will not block."""
        return self._future.done()

    def result(self) -> T:
        """Waits for the answer and returns it.

        Raises:
            DeviceError: The worker process died, or was ended meanwhile.
        """
        try:
            return self._future.result()
        except _DEAD as error:
            raise DeviceError(f"the {self._worker} worker process died (killed, or out of memory?)") from error


class Worker:
    """One process that owns one object.

    Numerical libraries run on one thread there, so that results do not depend on the number of cores.

    Args:
        name: For messages ("perception").
        factory: Picklable; builds the object inside the process, where its heavy imports happen too.
    """

    def __init__(self, name: str, factory: Callable[[], object]) -> None:
        self.name = name
        with _signals_ignored():
            self._pool = ProcessPoolExecutor(
                max_workers=1, timeout=None, initializer=_build, initargs=(factory, os.getpid()), env=_ONE_THREAD
            )
            self._pool.submit(os.getpid)  # starts the process, which builds its object while the caller goes on

    def call(self, method: str, *args: object, latency: float = 0.0) -> Call[Any]:
        """Calls a method of the worker's object.

        Args:
            method: Name of the method.
            *args: Picklable arguments.
            latency: Declared time from request to answer [s].
        """
        try:
            return Call(self._pool.submit(_call, method, args), self.name, latency)
        except _DEAD as error:
            raise DeviceError(f"the {self.name} worker process died (killed, or out of memory?)") from error

    def close(self) -> None:
        """Ends the process and waits for it; work under way is thrown away."""
        self._pool.shutdown(wait=True, kill_workers=True)


@contextmanager
def _signals_ignored() -> Iterator[None]:
    """Lets a process start that never sees a stop meant for its parent: an ignored signal stays ignored over exec."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, signal.SIG_IGN) for number in _STOPS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _build(factory: Callable[[], object], parent: int) -> None:
    global _subject
    for number in _STOPS:
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
    _subject = factory()


def _end_with(parent: int) -> None:
    """Ends this process when its parent is gone (killed, crashed), so that no orphan stays behind."""
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)


def _call(method: str, args: tuple[object, ...]) -> object:
    return getattr(_subject, method)(*args)

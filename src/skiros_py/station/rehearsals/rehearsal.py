"""Use case: rehearsals, each in a process of its own that is killed when it is cancelled."""

from __future__ import annotations

import contextlib
import pickle
import socket
import threading
import uuid
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from skiros_py.errors import DeviceError, SkirosError
from skiros_py.messages import Message
from skiros_py.processes import end_connected, packed, receive, send, start_python
from skiros_py.programs import kill_marked
from skiros_py.station.rehearsals.order import MARK, RehearsalOrder
from skiros_py.tasks.rehearsal import Rehearsal, RehearsedStep, Round

_PROGRAM = "skiros_py.station.rehearsals.playing:main"
_GRACE = 3.0
"""Time in which a cancelled rehearsal may close what it has opened [s]."""


class RunningRehearsal:
    """A rehearsal under way, in a process of its own. Thread-safe.

    Args:
        order: What is to be rehearsed.
        listener: Called in another thread with each step that has ended, and each round.

    Raises:
        OSError: The process cannot be started.
    """

    def __init__(
        self, order: RehearsalOrder, listener: Callable[[Round | RehearsedStep], object] = lambda _event: None
    ) -> None:
        self._mark = uuid.uuid4().hex
        self._listener = listener
        self._cancelled = threading.Event()
        self._future: Future[Rehearsal] = Future()
        self._process, self._line = start_python(_PROGRAM, self._mark)
        self._thread = threading.Thread(target=self._follow, args=(packed(order),), name="skiros-rehearsal")
        self._thread.start()

    @property
    def pid(self) -> int:
        """Id of the process."""
        return self._process.pid

    def done(self) -> bool:
        """Returns True when :meth:`result` will not block."""
        return self._future.done()

    def result(self) -> Rehearsal:
        """Waits for the result.

        Raises:
            SkirosError: There is none: the second world cannot be opened, the goal cannot be read, the process died, or
                it was cancelled.
        """
        return self._future.result()

    def cancel(self) -> None:
        """Ends it, with its process and all that has started; does nothing if it is done."""
        if not self._future.done():
            self._cancelled.set()
            with contextlib.suppress(OSError):
                self._line.shutdown(socket.SHUT_RDWR)  # wakes up what waits for it, here and there

    def close(self) -> None:
        """Ends it, and waits until nothing of it is left; may be called twice."""
        self.cancel()
        self._thread.join()

    def _follow(self, order: bytes) -> None:
        """Passes on what happens, and ends the process; runs in a thread of its own."""
        answer: Any = None
        try:
            send(self._line, order)
            while not isinstance(answer, Rehearsal | SkirosError):
                answer = pickle.loads(receive(self._line)[0])  # noqa: S301  from our own process
                if isinstance(answer, RehearsedStep | Round):
                    self._listener(answer)
        except (OSError, EOFError):
            answer = None
        except Exception as error:  # noqa: BLE001 - of the listener: what waits must not wait for ever
            answer = DeviceError(f"the rehearsal broke: {type(error).__name__}: {error}")
        self._end()
        if isinstance(answer, Rehearsal):
            self._future.set_result(answer)
        elif isinstance(answer, SkirosError):
            self._future.set_exception(answer)
        else:
            self._future.set_exception(DeviceError(self._why_none()))

    def _end(self) -> None:
        end_connected(self._process, self._line, _GRACE)
        kill_marked(MARK, self._mark)

    def _why_none(self) -> str:
        if self._cancelled.is_set():
            return Message("the rehearsal was stopped")
        status = self._process.returncode
        return Message("the process of the rehearsal ended with status {status}", status=status)


def rehearsed(
    order: RehearsalOrder, listener: Callable[[Round | RehearsedStep], object] = lambda _event: None
) -> Rehearsal:
    """Rehearses, and waits for the result; an interruption ends the rehearsal, too.

    Raises:
        SkirosError: As for :meth:`RunningRehearsal.result`.
    """
    running = RunningRehearsal(order, listener)
    try:
        return running.result()
    finally:
        running.close()

"""The control thread: owns the session, runs its cycle, and executes requested work between two cycles."""

from __future__ import annotations

import gc
import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, wait
from contextlib import nullcontext, suppress
from typing import Any, TypeVar

from skiros_py.errors import Busy, DeviceError, SkirosError, UsageError
from skiros_py.messages import Message, joined
from skiros_py.station.requests import admitted
from skiros_py.station.session import Session

T = TypeVar("T")

_log = logging.getLogger(__name__)

_BUDGET = 0.02
"""Maximum delay of the next cycle by queued work [s]; the rest is executed after that cycle."""


class _Queue:
    """Work for the control thread: queued by any thread, executed by one. It accepts nothing before :meth:`open`."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[Future[Any], Callable[[], Any]]] = deque()
        self._guard = threading.Lock()
        self._asked = threading.Event()
        self._takes = False

    def open(self) -> None:
        """Accepts work from now on."""
        self._takes = True

    def ask(self, work: Callable[[], T]) -> Future[T]:
        """Queues work, and returns the future of its result; if cancelled in time, the work is not executed.

        Raises:
            Busy: The queue accepts nothing now.
        """
        answer: Future[T] = Future()
        with self._guard:
            if not self._takes:
                raise Busy(Message("the station is not running: the server begins or ends"), retry_after=5.0)
            self._waiting.append((answer, work))
        self._asked.set()
        return answer

    # ------------------------------------------------------------------ in the control thread

    def do_some(self) -> None:
        """Executes the work queued so far, within a time limit: continuous requests must not stop the cycle."""
        end = time.perf_counter() + _BUDGET
        for _ in range(len(self._waiting)):
            _do(*self._waiting.popleft())
            if time.perf_counter() > end:
                return

    def wait(self, seconds: float) -> None:
        """Waits until work is queued; work queued since the last check counts."""
        if not self._waiting:
            self._asked.wait(seconds)
        self._asked.clear()

    def wake(self) -> None:
        """Ends the wait; callable from any thread."""
        self._asked.set()

    def refuse_all(self) -> None:
        """Closes the queue, and refuses the work that waits."""
        with self._guard:
            self._takes = False
        while self._waiting:
            answer, _ = self._waiting.popleft()
            if answer.set_running_or_notify_cancel():
                answer.set_exception(Busy(Message("the station was shut down before that was done"), retry_after=5.0))


def _do(answer: Future[Any], work: Callable[[], Any]) -> None:
    """Executes work, unless it was cancelled."""
    if not answer.set_running_or_notify_cancel():
        return
    try:
        answer.set_result(work())
    except Exception as error:  # noqa: BLE001 - raised in the thread that requested the work
        answer.set_exception(error)
    except BaseException as error:  # noqa: BLE001 - in that thread it would end more than the request
        answer.set_exception(DeviceError(f"it was aborted: {error!r}"))


def _log_failure(answer: Future[object]) -> None:
    error = None if answer.cancelled() else answer.exception()
    if error is not None and not isinstance(error, Busy):
        _log.error("what was asked of the control thread failed: %s", error, exc_info=trace_of(error))


def trace_of(error: BaseException) -> BaseException | None:
    """Returns the error whose traceback is logged besides its message; None for our own, whose message suffices."""
    return None if isinstance(error, SkirosError) else error


OpenSession = Callable[[], Session]
Listener = Callable[[Session], object]


CLOSING = "the station shuts down"
"""Reason for braking everything before a session is closed: not a halt, so the next session is not halted by it."""
_PATIENCE = 10.0
"""Maximum time that a caller waits for its turn between two cycles [s]."""
_OPENING = 60.0
"""Maximum time that a caller waits while the session is being reopened [s]."""
_PLACES = 24
"""Maximum number of waiting callers, of the 40 threads that answer requests: the others answer requests that do not
need the control thread, even if the control cycle hangs."""
_FULL = "very many requests wait for the control cycle already"

_REST = 0.005
"""In lockstep, the pause between two cycles while there is nothing to do [s]."""


class ControlThread:
    """Runs a session in a thread of its own. Start it, and close it.

    Args:
        opening: Opens the session; called in the control thread, and again for each :meth:`reopen`.

    Attributes:
        beat: Number of cycles, over all sessions; stands still only if the thread does.
        fault: Why there is no session any more; None if there is no fault.
    """

    def __init__(self, opening: OpenSession) -> None:
        self.beat = 0
        self.fault: BaseException | None = None
        self._opening = opening
        self._session: Session | None = None
        self._ready = threading.Condition()
        self._queue = _Queue()
        self._places = threading.BoundedSemaphore(_PLACES)
        self._ending = False
        self._stepped = time.monotonic()
        self._on_open: list[Listener] = []
        self._thread = threading.Thread(target=self._run, name="skiros-control", daemon=True)

    # ------------------------------------------------------------------ life cycle

    def on_open(self, listener: Listener) -> None:
        """Calls the listener in the control thread with each session before its first cycle; before :meth:`start`.

        If it raises, that session is not opened. A part of the station attaches itself to the session like this, and
        names by :meth:`Session.on_close <skiros_py.station.session.Session.on_close>` what detaches it.
        """
        self._on_open.append(listener)

    def start(self) -> None:
        """Starts the thread, and returns when the session is open.

        Raises:
            SkirosError: It cannot be opened.
        """
        self._queue.open()
        self._thread.start()
        with self._ready:
            self._ready.wait_for(lambda: self._session is not None or self.fault is not None)
        if self._session is None and self.fault is not None:
            self._thread.join()
            raise self.fault

    def close(self) -> None:
        """Stops everything, waits for a standstill, closes the session and ends the thread; may be called twice."""
        self._ending = True
        self._queue.wake()
        if self._thread.ident is not None and not self._is_mine:
            self._thread.join()

    @property
    def alive(self) -> bool:
        """True while there is a session whose cycle runs."""
        return self._session is not None and self._thread.is_alive() and self.fault is None

    @property
    def opening(self) -> bool:
        """True while a session is being opened or reopened."""
        return self._session is None and self.fault is None and self._thread.is_alive()

    @property
    def failed(self) -> bool:
        """True if the session was closed after a fault; :meth:`reopen` opens it again."""
        return self.fault is not None and self._session is None and not self._ending

    def stuck_for(self) -> float:
        """Returns the time since an open session last completed a cycle [s]; 0 while no session is open."""
        return time.monotonic() - self._stepped if self._session is not None else 0.0

    @property
    def session(self) -> Session:
        """The session; waits while it is being reopened.

        Raises:
            Busy: There is none, and none is being opened; or too many callers wait for it already.
        """
        session = self._session
        if session is not None:
            return session
        if not self._is_mine:  # the control thread would wait for itself
            with admitted(self._places, _FULL):
                self._await_session()
        return self._present()

    def _await_session(self) -> None:
        with self._ready:
            self._ready.wait_for(lambda: self._session is not None or self.fault is not None, timeout=_OPENING)

    def _present(self) -> Session:
        session = self._session
        if session is None:
            text = Message("the station is not running")
            raise Busy(text if self.fault is None else joined(": ", (text, str(self.fault))), retry_after=5.0)
        return session

    @property
    def _is_mine(self) -> bool:
        return threading.get_ident() == self._thread.ident

    # ------------------------------------------------------------------ requests

    def call(self, work: Callable[[Session], T], *, urgent: bool = False) -> T:
        """Executes short work in the control thread between two cycles, and returns its result.

        In the control thread itself (in a listener or an observer of the cycle) the work is executed immediately.

        Args:
            work: Called with the session at that moment, which may be another one than at the time of the call.
            urgent: True to queue the work regardless of the number of waiting callers.

        Raises:
            Busy: Its turn did not come in time, there is no session, or too many callers wait; nothing was done.
            DeviceError: The work did not end; its effects are unknown.
            Exception: Any exception that the work raises.
        """
        if self._is_mine:
            return work(self._present())
        with nullcontext() if urgent else admitted(self._places, _FULL):
            self._await_session()  # while the session is being reopened, this may take longer than a turn
            self._present()
            return self._outcome(self._queue.ask(lambda: work(self._present())))

    def soon(self, work: Callable[[Session], object]) -> None:
        """Executes short work in the control thread between two cycles, without waiting for it.

        For listeners that must not wait. Exceptions are logged; without a session, nothing is done.
        """
        with suppress(Busy):
            self._queue.ask(lambda: work(self._present())).add_done_callback(_log_failure)

    def reopen(
        self,
        prepare: Callable[[Session], object] = lambda _session: None,
        restore: Callable[[], object] | None = None,
    ) -> None:
        """Closes the session and opens it again, for example after another scene was loaded; returns when that is done.

        If everything was halted, it stays halted in the new session until a reset.

        Args:
            prepare: Called in the control thread after the last cycle, before the session is closed; its exceptions are
                raised here, and the session continues. It is not called if the session has failed before.
            restore: Called in the control thread if the new session cannot be opened: reverts ``prepare``, after which
                opening is tried once more. The error is raised here all the same.

        Raises:
            SkirosError: The new session cannot be opened; if the restored one cannot either, there is no session until
                the next :meth:`reopen`.
            Busy: The server is shutting down.
            UsageError: It is called in the control thread itself, whose cycle cannot end while it runs.
        """
        if self._is_mine:
            raise UsageError("the control thread cannot reopen its own session: ask for it in another thread")
        self._queue.ask(lambda: self._renew(prepare, restore)).result()

    def _outcome(self, answer: Future[T]) -> T:
        wait([answer], _PATIENCE)
        if not answer.done() and self._session is None:  # another caller has requested reopening first
            wait([answer], _OPENING)
        if not answer.done() and answer.cancel():
            raise Busy(Message("the control cycle did not run within {seconds:g} s", seconds=_PATIENCE))
        wait([answer], _PATIENCE)
        if not answer.done():
            raise DeviceError(
                "the control cycle is held up by what was asked for: whether it takes effect is not known"
            )
        return answer.result()

    # ------------------------------------------------------------------ in the thread

    def _run(self) -> None:
        try:
            self._enter()
        except BaseException as error:  # noqa: BLE001 - raised by start()
            self._tell_fault(error)
        else:
            while not self._ending:
                self._go_round()
            if self._session is not None:
                self._leave(self._session)
        self._tell_fault(self.fault or DeviceError("the station was shut down"))
        self._queue.refuse_all()

    def _go_round(self) -> None:
        self._queue.do_some()
        session = self._session
        if session is None:  # failed: only a new session helps
            self._queue.wait(0.1)
            return
        try:
            session.cycle.step()
            rests = session.cycle.pace is None and session.resting
        except BaseException as error:  # noqa: BLE001 - the server outlives its station, and reports the fault
            _log.critical("the control cycle broke: %s", error, exc_info=error)
            self._break(session, error)
            return
        self.beat += 1
        self._stepped = time.monotonic()
        if rests:
            self._queue.wait(_REST)

    def _renew(self, prepare: Callable[[Session], object], restore: Callable[[], object] | None) -> None:
        session, halted = self._session, ""
        if session is not None:
            prepare(session)
            halted = session.cycle.halted
            self._leave(session)
        try:
            try:
                self._enter(halted)
            except BaseException:
                if restore is not None and session is not None:
                    restore()
                    self._enter(halted)
                raise
        except BaseException as error:
            if self._session is None:
                self._tell_fault(error)
            raise

    def _enter(self, halted: str = "") -> None:
        self.fault = None
        session = self._opening()
        try:
            if halted:
                session.cycle.halt(halted)
            session.jobs  # noqa: B018 - opens the queue, whose jobs continue
            for listener in self._on_open:
                listener(session)
        except BaseException:
            self._end(session)
            raise
        gc.freeze()  # what was opened stays: searching it for garbage would hold up everything for 0.1 to 0.2 s
        self._stepped = time.monotonic()
        with self._ready:
            self._session = session
            self._ready.notify_all()

    def _leave(self, session: Session) -> None:
        """Brings everything to a standstill, and closes the session."""
        try:
            session.cycle.stop_all(CLOSING)  # devices halted a moment ago may still move
        except BaseException as error:  # noqa: BLE001 - the session is closed all the same
            _log.error("not everything came to a standstill: %s", error, exc_info=trace_of(error))
        self._part(session)

    def _break(self, session: Session, error: BaseException) -> None:
        """Brakes all devices that can be braked, and closes the session, whose state is no longer known."""
        fault = error if isinstance(error, SkirosError) else DeviceError(f"the control cycle broke: {error}")
        with self._ready:
            self.fault = fault
        try:
            session.cycle.halt(str(fault))
        except BaseException as worse:  # noqa: BLE001 - the session is closed all the same
            _log.error("the devices cannot be halted: %s", worse, exc_info=trace_of(worse))
        self._part(session)

    def _part(self, session: Session) -> None:
        with self._ready:
            self._session = None
        self._end(session)

    def _end(self, session: Session) -> None:
        """Closes the session, which detaches all parts of the station first."""
        gc.unfreeze()
        try:
            session.close()
        except BaseException as error:  # noqa: BLE001 - the thread outlives any fault here
            _log.error("closing a session failed: %s", error, exc_info=trace_of(error))

    def _tell_fault(self, error: BaseException) -> None:
        with self._ready:
            self.fault = error
            self._ready.notify_all()

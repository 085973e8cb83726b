"""The control thread: owns the session, runs its cycle, and does what others ask between two cycles (D12)."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeout
from typing import TypeVar

from skiros_py.errors import Busy, DeviceError, SkirosError
from skiros_py.runtime import Session

__all__ = ["ControlThread", "OpenSession"]

T = TypeVar("T")
OpenSession = Callable[[], Session]

_log = logging.getLogger(__name__)

_PATIENCE = 10.0
"""How long a caller waits for its turn between two cycles [s]."""
_OPENING = 60.0
"""How long a caller waits while the session is being opened anew [s]."""
_REST = 0.005
"""In lockstep, the pause between two cycles while nothing is to be done [s]: time stands still for nobody's sake."""


class ControlThread:
    """Runs a session in a thread of its own. Start it, and close it.

    Args:
        opening: Opens the session; called in the control thread, once more for each :meth:`reopen`.

    Attributes:
        beat: Counts cycles, over all sessions; stands still only when the thread does.
        fault: Why there is no session any more; None in good times.
    """

    def __init__(self, opening: OpenSession) -> None:
        self.beat = 0
        self.fault: BaseException | None = None
        self._opening = opening
        self._session: Session | None = None
        self._ready = threading.Condition()
        self._commands: deque[Callable[[], None]] = deque()
        self._asked = threading.Event()
        self._ending = False
        self._reopen: Callable[[], None] | None = None
        self._on_open: list[Callable[[Session], None]] = []
        self._on_close: list[Callable[[Session], None]] = []
        self._thread = threading.Thread(target=self._run, name="skiros-control", daemon=True)

    # ------------------------------------------------------------------ life

    def on_open(self, listener: Callable[[Session], None]) -> None:
        """Calls the listener in the control thread with each session before its first cycle; before :meth:`start`."""
        self._on_open.append(listener)

    def on_close(self, listener: Callable[[Session], None]) -> None:
        """Calls the listener in the control thread with each session after its last cycle; before :meth:`start`."""
        self._on_close.append(listener)

    def start(self) -> None:
        """Starts the thread, and returns when the session is open.

        Raises:
            SkirosError: It cannot be opened.
        """
        self._thread.start()
        with self._ready:
            self._ready.wait_for(lambda: self._session is not None or self.fault is not None)
        if self.fault is not None:
            self._thread.join()
            raise self.fault

    def close(self) -> None:
        """Stops everything, waits until all stands, closes the session and ends the thread; may be called twice."""
        self._ending = True
        self._asked.set()
        if self._thread.ident is not None:
            self._thread.join()

    @property
    def alive(self) -> bool:
        """True while there is a session whose cycle runs."""
        return self._session is not None and self._thread.is_alive() and self.fault is None

    @property
    def session(self) -> Session:
        """The session; while it is being opened anew, that is waited for.

        Raises:
            Busy: There is none, and there will be none soon.
        """
        session = self._session
        if session is not None:
            return session
        with self._ready:
            self._ready.wait_for(lambda: self._session is not None or self.fault is not None, timeout=_OPENING)
            if self._session is None:
                why = f": {self.fault}" if self.fault is not None else ""
                raise Busy(f"the station is not running{why}", retry_after=5.0)
            return self._session

    # ------------------------------------------------------------------ asking

    def call(self, work: Callable[[Session], T]) -> T:
        """Has something quick done in the control thread between two cycles, and returns what comes of it.

        Raises:
            Busy: Its turn did not come in time.
            Exception: Whatever the work raises.
        """
        session = self.session
        answer: Future[T] = Future()

        def do() -> None:
            if not answer.set_running_or_notify_cancel():
                return
            try:
                answer.set_result(work(session))
            except BaseException as error:  # noqa: BLE001 - it is raised where the work was asked for
                answer.set_exception(error)

        self._commands.append(do)
        self._asked.set()
        try:
            return answer.result(_PATIENCE)
        except FutureTimeout:
            answer.cancel()
            raise Busy(f"the control cycle did not come round within {_PATIENCE:g} s") from None

    def reopen(self, prepare: Callable[[Session], None] = lambda _session: None) -> None:
        """Closes the session and opens it anew, such as after another scene was loaded; returns when that is done.

        Args:
            prepare: Called in the control thread between its last cycle and its end; what it raises is raised here,
                and the session goes on.

        Raises:
            SkirosError: The new one cannot be opened; then there is none until the next :meth:`reopen`.
        """
        done: Future[None] = Future()

        def do() -> None:
            session = self._session
            try:
                if session is not None:
                    prepare(session)
                    self._leave(session)
                self._enter()
            except BaseException as error:  # noqa: BLE001 - it is raised where it was asked for
                done.set_exception(error)
            else:
                done.set_result(None)

        self._commands.append(do)
        self._asked.set()
        done.result()

    # ------------------------------------------------------------------ in the thread

    def _run(self) -> None:
        try:
            self._enter()
        except BaseException:  # noqa: BLE001 - told by start()
            return
        while not self._ending:
            self._do_commands()
            session = self._session
            if session is None:  # broken: only a new session helps
                self._asked.wait(0.1)
                self._asked.clear()
                continue
            try:
                session.cycle.step()
                self.beat += 1
            except BaseException as error:  # noqa: BLE001 - the server outlives its station, and says what broke
                _log.critical("the control cycle broke: %s", error, exc_info=error)
                self._break(session, error)
                continue
            if session.cycle.pace is None and session.resting:
                self._asked.wait(_REST)
            self._asked.clear()
        if self._session is not None:
            self._leave(self._session)
        self._refuse_commands()

    def _do_commands(self) -> None:
        while self._commands:
            self._commands.popleft()()

    def _refuse_commands(self) -> None:
        self.fault = self.fault or DeviceError("the station was shut down")
        with self._ready:
            self._ready.notify_all()

    def _enter(self) -> None:
        self.fault = None
        session = None
        try:
            session = self._opening()
            for listener in self._on_open:
                listener(session)
        except BaseException as error:
            if session is not None:
                session.close()
            with self._ready:
                self.fault = error
                self._ready.notify_all()
            raise
        with self._ready:
            self._session = session
            self._ready.notify_all()

    def _leave(self, session: Session) -> None:
        """Lets everything come to a standstill, and closes the session."""
        try:
            if not session.cycle.halted:
                session.cycle.stop_all("the station shuts down")
        except SkirosError as error:
            _log.error("not everything came to a standstill: %s", error)
        self._part(session)

    def _break(self, session: Session, error: BaseException) -> None:
        fault = error if isinstance(error, SkirosError) else DeviceError(f"the control cycle broke: {error}")
        with self._ready:
            self.fault = fault
        self._part(session)

    def _part(self, session: Session) -> None:
        with self._ready:
            self._session = None
        for listener in self._on_close:
            listener(session)
        session.close()

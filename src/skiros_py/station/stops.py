"""Stops everything immediately, bypassing all queues and thread pools; a stop holds until it is reset."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
import time
from pathlib import Path
from typing import NamedTuple

from skiros_py.api.alarms import StopInfo
from skiros_py.api.wire import moment
from skiros_py.errors import FileError, SkirosError, WrongState
from skiros_py.messages import Message
from skiros_py.station.control import CLOSING, ControlThread
from skiros_py.station.events.log import EventLog, Kind
from skiros_py.station.session import Session
from skiros_py.world.scene.files import write_atomically

_log = logging.getLogger(__name__)


class Halt(NamedTuple):
    """A stop.

    Attributes:
        why: The reason, for a person.
        by: Name of the caller who requested it.
        since: Time of the stop [s since 1970].
    """

    why: str
    by: str
    since: float


_AGAIN = 1.0
"""Time until the next attempt to store a stop that could not be stored [s]."""


class HaltMark:
    """The file whose presence keeps everything halted; thread-safe.

    Args:
        path: The file; it exists only while a requested stop holds.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._guard = threading.Lock()
        self._wanted: Halt | None = None
        self._is_reported = False

    def read(self) -> Halt | None:
        """Returns the stop left by a previous server; an unreadable file counts as a stop, too."""
        try:
            text = self._path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return None
        except OSError as error:
            return Halt(
                Message("the stored stop cannot be read, so everything is halted: {error}", error=error), "", 0.0
            )
        try:
            why, by, since = json.loads(text)
            self._wanted = Halt(str(why), str(by), float(since))
        except (TypeError, ValueError):
            self._wanted = Halt("everything was stopped before the server was restarted", "", 0.0)
        return self._wanted

    def keep(self, halt: Halt) -> None:
        """Writes a stop in a thread of its own: a stop does not wait for a disk, even a full one."""
        self._wanted = halt
        try:
            threading.Thread(target=self._settle_at_last, name="skiros-halt-mark", daemon=True).start()
        except RuntimeError:  # no more threads: write in this one
            self._settle()

    def forget(self) -> None:
        """Removes the stop; quick if there is none."""
        if self._wanted is not None:
            self._wanted = None
            self._settle()

    def _settle_at_last(self) -> None:
        """Writes the current state, again and again until the disk takes it."""
        while not self._settle():
            time.sleep(_AGAIN)

    def _settle(self) -> bool:
        """Writes the current state to the file: a reset may have been requested before the stop was written.

        Returns:
            Whether it is written.
        """
        with self._guard:
            wanted = self._wanted
            try:
                if wanted is None:
                    self._path.unlink(missing_ok=True)
                else:
                    write_atomically(self._path, json.dumps(wanted), private=True)
            except (OSError, FileError) as error:
                if not self._is_reported:
                    _log.error("a stop would not outlive the server, until the disk can be written: %s", error)
                self._is_reported = True
                return False
            self._is_reported = False
            return True


_PATIENCE = 0.5
"""Maximum time that a stop waits for the control thread to complete a cycle before reporting that it does not [s]."""
_LOOK = 0.002
"""Period at which a waiting stop checks [s]."""


class Stops:
    """Halts the station, and resets it.

    Args:
        control: Runs the session.
        events: Receives stops and resets.
        mark: Stores a stop beyond the end of the server.
    """

    def __init__(self, control: ControlThread, events: EventLog, mark: HaltMark) -> None:
        self._control = control
        self._events = events
        self._mark = mark
        self._guard = threading.Lock()
        self._session: Session | None = None
        self._wanted = ""
        self._seen = ""
        self._by = ""
        self._since: float | None = None

    def restore(self) -> None:
        """Restores a stop left by a previous server: the first session is opened halted."""
        left = self._mark.read()
        if left is not None:
            self._wanted = left.why
            self._note(left.why, left.by, left.since)

    # ------------------------------------------------------------------ sessions

    def open(self, session: Session) -> None:
        """Controls a session from now on; halts it immediately if a stop was requested and not reset since."""
        self._session, self._seen = session, ""
        session.on_close(self._leave)
        session.cycle.observe(self._look)
        if self._wanted:
            session.cycle.halt(self._wanted)
        else:
            self._forget()

    def _leave(self) -> None:
        self._session = None

    # ------------------------------------------------------------------ stopping

    async def stop(self, reason: str, by: str) -> StopInfo:
        """Halts everything immediately, and reports shortly after whether that was obeyed.

        Args:
            reason: The reason, for a person.
            by: Name of the caller.
        """
        before, deadline = self._control.beat, time.monotonic() + _PATIENCE
        brake = self._halt(reason, by)
        while not (obeyed := self._has_heard(before, brake)) and time.monotonic() < deadline:
            await asyncio.sleep(_LOOK)
            if self._session is not None and not self._session.cycle.halted:
                brake = self._halt(reason, by)  # the stop came during a reset, which must not swallow it
        if self._wanted:  # not reset meanwhile
            self._mark.keep(Halt(reason, by, time.time()))
        return self.now(obeyed=obeyed)

    def _halt(self, reason: str, by: str) -> threading.Thread | None:
        self._note(reason, by)
        self._wanted = reason  # first, so that a session being opened is halted, too
        session = self._session
        if session is None:
            return None
        session.cycle.forbid(reason)  # an assignment: even if braking fails, nothing more is commanded
        self._wanted = reason
        return _braking(session)

    def _has_heard(self, before: int, brake: threading.Thread | None) -> bool:
        """Returns whether a whole cycle has passed: the current one may have sent its commands before."""
        braked = brake is None or not brake.is_alive()
        return self._session is None or (self._control.beat >= before + 2 and braked)

    def now(self, *, obeyed: bool | None = None) -> StopInfo:
        """Returns whether everything is halted, and why.

        Args:
            obeyed: Whether the control thread has completed a cycle; determined if omitted.
        """
        session = self._session
        round_ = self._control.stuck_for() < _PATIENCE if obeyed is None else obeyed
        why = self._why()
        standing = session is None or session.cycle.board.still
        with self._guard:
            return StopInfo(
                halted=bool(why),
                why=why,
                by=self._by if why else "",
                since=moment(self._since) if why else None,
                standing=standing if round_ else None,
                obeyed=round_,
            )

    # ------------------------------------------------------------------ reset

    def reset(self, by: str) -> StopInfo:
        """Lets motions start again; has no effect if nothing is halted.

        If the station was closed after a fault, such as one of a device, it is opened, its drivers connected again.

        Args:
            by: Name of the caller, who has examined the reason of the halt.

        Raises:
            WrongState: A device still moves, or the fault of the station persists.
            Busy: The control thread does not run.
        """

        def do(session: Session) -> bool:
            if not session.cycle.halted:
                return False
            try:
                session.reset()
            except SkirosError as error:
                raise WrongState("not yet: {error}", error=error) from None
            self._forget()
            return True

        failed = self._control.failed
        if failed:
            try:
                self._control.reopen()
            except SkirosError as error:
                raise WrongState("the station cannot be opened again: {error}", error=error) from None
        done = self._control.call(do, urgent=True)
        if done or failed:
            self._events.append(Kind.SYSTEM, "reset", data={"by": by})
        return self.now()

    # ------------------------------------------------------------------ state

    def _look(self) -> None:
        """Detects halts from any source; called in the control thread at the end of each cycle."""
        halted = self._why()
        if halted != self._seen:
            self._seen = halted
            if halted:
                self._note(halted, "")
            else:
                self._forget()

    def _why(self) -> str:
        """Returns why everything is halted; while a session is closed or opened, the reason for the next session."""
        session = self._session
        halted = CLOSING if session is None else session.cycle.halted
        return self._wanted if halted == CLOSING else halted

    def _forget(self) -> None:
        """Records that nothing is halted."""
        with self._guard:
            self._seen, self._wanted, self._by, self._since = "", "", "", None
        self._mark.forget()

    def _note(self, why: str, by: str, since: float | None = None) -> None:
        """Records when everything was halted (now if omitted), and by whom first."""
        with self._guard:
            if self._since is not None:
                return
            self._by, self._since = by, time.time() if since is None else since
        self._events.append(Kind.SYSTEM, "halted", data={"why": why, "by": by})


def _braking(session: Session) -> threading.Thread:
    """Brakes in a thread of its own, so that the server can report a driver that hangs."""

    def brake() -> None:
        try:
            session.cycle.board.halt()
        except Exception:  # noqa: BLE001 - a driver's fault must not end a stop
            _log.exception("braking failed; no further commands are sent")

    thread = threading.Thread(target=brake, name="skiros-brake", daemon=True)
    try:
        thread.start()
    except RuntimeError:  # no more threads: brake in this one
        brake()
    return thread

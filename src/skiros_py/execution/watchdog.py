"""The watchdog: when code holds the control cycle, the robots brake, the code is named and interrupted.

It looks from a thread of its own at what the cycle is doing (:class:`~skiros_py.interruptions.Activity`). Python code
gets an exception; a call into C that does not come back cannot be ended, only reported.

A tick is charged with wall time, less the time in which it could not run: the control thread waited for a processor, or
the whole process (and so this thread) stood still. An overloaded machine therefore does not halt a healthy station.
"""

from __future__ import annotations

import logging
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import ParamSpec, Self

from skiros_py.execution.cycle import ControlCycle
from skiros_py.interruptions import Overrun, WatchedTask
from skiros_py.listeners import Listeners
from skiros_py.ports.device_faults import described
from skiros_py.skills.primitive import Primitive

P = ParamSpec("P")

_log = logging.getLogger(__name__)

_PERIODS = 20
"""How many periods of wall time the ticks of a cycle may take when the run has a pace."""
_LOCKSTEP_LIMIT = 5.0
"""How long they may take in lockstep, where the simulated time waits for everybody [s]."""
_LOOKS = 10
"""How often within the limit the watchdog looks."""
_LATE = 3
"""A look that comes later than so many intervals after the one before shows that this thread could not run either."""


class Watchdog:
    """Watches a control cycle from a thread of its own. Start it, or use it in a ``with``.

    Args:
        cycle: The control cycle.
        limit: Wall time that the ticks of one cycle may take [s]; where left out, 20 periods, or 5 s in lockstep.
        again: Time after which code that goes on nevertheless is interrupted again [s].
        patience: Time after the first interruption when the task counts as lost [s].

    Attributes:
        limit: Wall time that the ticks of one cycle may take [s].
    """

    def __init__(
        self, cycle: ControlCycle, limit: float | None = None, *, again: float = 0.5, patience: float = 3.0
    ) -> None:
        self.limit = _limit(cycle) if limit is None else limit
        self._cycle = cycle
        self._again = again
        self._patience = patience
        self._overruns = Listeners[[Overrun]]("overruns")
        self._losses = Listeners[[WatchedTask]]("lost tasks")
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="skiros-watchdog", daemon=True)
        self._interval = min(self.limit, again) / _LOOKS
        self._seen = -1
        self._looked = 0.0
        self._held = 0.0
        self._worked = 0.0
        self._waited: float | None = None
        self._overrun: Overrun | None = None
        self._interrupted = 0.0
        self._lost = False

    def on_overrun(self, listener: Callable[[Overrun], None]) -> None:
        """Calls a function, in the watchdog's thread, once for each tick that takes too long."""
        self._overruns.add(listener)

    def on_lost(self, listener: Callable[[WatchedTask], None]) -> None:
        """Calls a function, in the watchdog's thread, once for a task that does not end although it was interrupted."""
        self._losses.add(listener)

    def start(self) -> None:
        """Begins to watch."""
        self._thread.start()

    def close(self) -> None:
        """Ends the thread; may be called twice."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _watch(self) -> None:
        while not self._ended.wait(self._interval):
            _surely(self._look, time.monotonic())

    def _look(self, now: float) -> None:
        activity = self._cycle.activity
        limit = max(self.limit, activity.allowed)  # first of all: see Activity.allowing
        tick, task = activity.tick, activity.task
        passed, self._looked = now - self._looked, now
        worked = time.process_time() - self._worked
        self._worked += worked
        if tick != self._seen or task is None or activity.waits:
            self._seen, self._held, self._waited, self._overrun, self._lost = tick, 0.0, None, None, False
            return
        self._held += self._charged(passed, worked)
        if self._overrun is not None and self._overrun.task is not task:  # that one ended; this one has a limit, too
            self._held, self._overrun, self._lost = 0.0, None, False
        elif self._held > limit:
            self._act(tick, task, now, limit)

    def _charged(self, passed: float, worked: float) -> float:
        """Returns how much of the time since the last look the tick is charged with [s].

        Args:
            passed: Wall time since the last look [s].
            worked: Processor time of this process in it [s].
        """
        paused = passed - self._interval - worked if passed > _LATE * self._interval else 0.0
        before, self._waited = self._waited, _waited_for_processor(self._cycle.activity.thread)
        waited = self._waited - before if before is not None and self._waited is not None else 0.0
        return max(0.0, passed - max(paused, waited, 0.0))

    def _act(self, tick: int, task: WatchedTask, now: float, limit: float) -> None:
        if self._overrun is None:
            self._overrun = self._describe(task, tick, self._held, limit)
            self._interrupted = now
            self._interrupt(self._overrun)
        elif self._held > limit + self._patience and not self._lost:
            self._lost = True
            _log.error("%s is lost: it does not come back from where it is", task.name)
            self._losses.notify(task)
        elif now - self._interrupted > self._again:
            self._interrupted = now
            self._cycle.activity.interrupt(self._overrun)

    def _interrupt(self, overrun: Overrun) -> None:
        """Says that all is halted, strikes the tick, brakes: in this order, for a brake may break or hang."""
        self._cycle.forbid(str(overrun))
        if overrun.device is not None:
            self._cycle.board.guard.switch_off(overrun.device, str(overrun))
        self._cycle.activity.interrupt(overrun)
        _surely(self._cycle.board.halt)
        _log.error("%s\n%s", overrun, overrun.stack)
        self._overruns.notify(overrun)

    def _describe(self, task: WatchedTask, tick: int, seconds: float, limit: float) -> Overrun:
        frame = sys._current_frames().get(self._cycle.activity.thread)  # noqa: SLF001 - documented, for debugging
        stack = "" if frame is None else "".join(traceback.format_stack(frame)).rstrip()
        module, calling = _primitive_in(frame) or task.name, self._cycle.board.guard.calling
        if calling is None:
            return Overrun(task, tick, seconds, limit, module, stack)
        device, function = calling
        return Overrun(task, tick, seconds, limit, f"{function} of {described(device)}", stack, device)


def _waited_for_processor(ident: int) -> float | None:
    """Returns for how long a thread waited for a processor so far [s]; None where the system does not say."""
    native = next((thread.native_id for thread in threading.enumerate() if thread.ident == ident), None)
    try:
        return int(Path(f"/proc/self/task/{native}/schedstat").read_text(encoding="ascii").split()[1]) * 1e-9
    except (OSError, ValueError, IndexError):
        return None


def _surely(action: Callable[P, object], *args: P.args, **kwargs: P.kwargs) -> None:
    """Calls a listener or driver; whatever it raises is logged, because the watchdog has to go on."""
    try:
        action(*args, **kwargs)
    except BaseException:  # noqa: BLE001 - the last one who watches must not be brought down
        _log.exception("the watchdog goes on, though this broke: %s", getattr(action, "__qualname__", action))


def _primitive_in(frame: FrameType | None) -> str:
    """Returns the name of the innermost primitive whose code is running; empty where there is none."""
    while frame is not None:
        owner = frame.f_locals.get("self")
        if isinstance(owner, Primitive):
            return owner.name
        frame = frame.f_back
    return ""


def _limit(cycle: ControlCycle) -> float:
    if cycle.pace is None:
        return _LOCKSTEP_LIMIT
    return _PERIODS * cycle.board.period / min(cycle.pace, 1.0)

"""A task: a generator that is ticked once per cycle, with a name and a clock of its own; its faults end only itself."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, Generic, TypeVar

from skiros_py.errors import DeviceError, ModuleError
from skiros_py.execution.module_faults import words
from skiros_py.interruptions import CycleOverrun, by_user
from skiros_py.ports.board import DeviceBoard
from skiros_py.skills.context import Clock

T = TypeVar("T")

_CLOSE_TRIES = 3
"""How often a generator that yields again when it is closed is closed once more."""


class Task(Generic[T]):
    """A generator that is ticked once per cycle until it returns, breaks, or is stopped.

    Whatever its code raises ends this task only. Its devices brake by themselves as soon as it commands them no more.

    Args:
        generator: What is ticked.
        board: The devices.
        name: For messages; the generator's own name where left out.
        clock: Its clock, where others read it too; one of its own where left out.
        ended: Called at its end, once or more; without it, every task would have to be looked at in every cycle.

    Attributes:
        name: For messages.
        clock: Its own time.
        done: True when nothing more of it will run: it returned, broke, or was stopped.
        fault: What its code raised, with the traceback; None if nothing was raised.
        reason: Why it was stopped; may be empty.
        devices: The devices that it may command; None for all.
        generator: What is ticked.
        aborted: True when it was stopped or failed.
        interruptible: The watchdog may interrupt it anywhere.
    """

    interruptible = True

    def __init__(
        self,
        generator: Generator[None, None, T],
        board: DeviceBoard,
        name: str = "",
        clock: RunClock | None = None,
        ended: Callable[[Task[Any]], None] = lambda _: None,
    ) -> None:
        self.name = name or getattr(generator, "__qualname__", type(generator).__name__)
        self.clock = clock or RunClock(board)
        self.done = False
        self.fault: BaseException | None = None
        self.reason = ""
        self.devices: frozenset[str] | None = None
        self.generator = generator
        self._board = board
        self._activity = board.guard.activity
        self._ended = ended
        self._result: T | None = None
        self.aborted = False
        self._deadline: float | None = None
        self._runs_away = False
        self._steps = 0
        self._stepping = False

    # ------------------------------------------------------------------ running

    def finish(self, result: T) -> None:
        """Ends it with what it returned."""
        self._result = result
        self._ended(self)
        self.done = True

    def pause(self) -> None:
        """Slows its clock down; when that stands, it is ticked no more until :meth:`resume`."""
        self._steps = 0
        self.clock.slow_down()

    def resume(self) -> None:
        """Goes on where it paused, taking up speed again."""
        self._steps = 0
        self.clock.speed_up()

    def step(self) -> None:
        """Lets a paused task do one tick in the coming cycle; its clock moves on by one period."""
        self._steps += 1

    @property
    def paused(self) -> bool:
        """True when it was paused and its clock stands."""
        return self.clock.stands

    @property
    def pausing(self) -> bool:
        """True from a pause until it is resumed, or until the tick of a single step."""
        return self.clock.slowing and not self._stepping

    @property
    def rate(self) -> float:
        """How fast its time goes: 1 with the run and in a single step, 0 standing still."""
        return 1.0 if self._stepping else self.clock.rate

    def has_turn(self) -> bool:
        """Moves an unsteady clock on; returns whether this cycle has a tick."""
        self.clock.advance()
        self._stepping = self.clock.stands and self._steps > 0
        if not self._stepping:
            return not self.clock.stands
        self._steps -= 1
        self.clock.jump(self._board.period)
        return True

    # ------------------------------------------------------------------ ending

    def stop(self, reason: str = "") -> None:
        """Ends it now; its ``finally`` blocks run, its commands cease, and nothing more of it runs afterwards.

        Args:
            reason: Why, for a person.
        """
        if self.done:
            return
        self._ended(self)
        self.done = self.aborted = True
        self.reason = reason
        if not getattr(self.generator, "gi_running", False):  # else it stops itself: closed when this tick is over
            self.close()

    def fail(self, fault: BaseException) -> None:
        """Ends it with a fault; its commands cease."""
        if self.fault is None or isinstance(fault, CycleOverrun):
            before = self.fault
            self.fault = fault if before is None else fault.with_traceback(before.__traceback__)
        if not self.done:
            self._ended(self)
            self.done = self.aborted = True
            self.close()

    def settle(self) -> None:
        """Checks whether the devices that it commanded stand; in each cycle after it was stopped."""
        board = self._board
        if self._deadline is None:
            return
        if not board.moving(self):
            self._deadline = None
        elif board.snapshot.time > self._deadline:
            moving = ", ".join(board.moving(self))
            self._deadline, self._runs_away = None, True
            self.fault = self.fault or DeviceError(f"{moving}: still moving after the time for braking from full speed")

    @property
    def stopping(self) -> bool:
        """True while something that it commanded still brakes after it was stopped."""
        return self._deadline is not None

    @property
    def stopped(self) -> bool:
        """True when it was ended by a stop or a fault, and all devices that it commanded stand.

        A device that does not stand after its braking time is a fault; then the task never counts as stopped.
        """
        return self.aborted and self._deadline is None and not self._runs_away

    @property
    def result(self) -> T:
        """What it returned.

        Raises:
            Exception: What its code raised.
            ModuleError: Its code tried to end the program or held the control cycle, or everything was halted.
            RuntimeError: It still runs or was stopped.
        """
        if isinstance(self.fault, Exception):
            raise self.fault
        if self.fault is not None:
            raise ModuleError(f"{self.name}: {_words(self.fault)}") from self.fault
        if self.aborted and self.reason:
            raise ModuleError("{name} was stopped: {reason}", name=self.name, reason=self.reason)
        if not self.done or self.aborted:
            raise RuntimeError("a task has a result only after it ended by itself")
        return self._result  # type: ignore[return-value]  # T may include None

    def close(self) -> None:
        """Closes its generator, and withdraws its commands; only for the control cycle."""
        board = self._board
        owner, board.owner = board.owner, self
        try:
            self._activity.run(self, self._close_generator)
        except CycleOverrun:  # it came late, when the generator was closed already
            pass
        finally:
            board.owner = owner
        board.withdraw(self)
        if board.moving(self):
            self._deadline = board.snapshot.time + board.braking_time

    def _close_generator(self) -> None:
        """Closes the generator, even if its clean-up raises or yields."""
        for _ in range(_CLOSE_TRIES):
            try:
                self.generator.close()
            except BaseException as fault:  # the same: the others have to be stopped, too
                if by_user(fault):
                    raise
                self.fault = self.fault or fault
            else:
                return


def _words(fault: BaseException) -> str:
    if isinstance(fault, CycleOverrun):
        return str(fault) if fault.overrun is None else f"{fault}\n{fault.overrun.stack}"
    return words(fault)


_RAMP = 0.3
"""Time in which a clock slows down to standing still, and takes up speed again [s]."""


class RunClock:
    """Stands still while its task is paused, and gets there smoothly.

    A motion that is sampled at :attr:`now` therefore brakes along its own path and takes it up again where it left it.

    Args:
        run: Gives the time of the run.

    Attributes:
        rate: How fast it goes: 1 with the run, 0 standing still.
        lag: How far it is behind the run [s].
        steady: True while it goes with the run; then it needs no :meth:`advance`.
    """

    __slots__ = ("_now", "_run", "_wanted", "lag", "rate", "steady")

    def __init__(self, run: Clock) -> None:
        self._run = run
        self._now = 0.0
        self.rate = 1.0
        self.lag = 0.0
        self.steady = True
        self._wanted = 1.0

    @property
    def now(self) -> float:
        """The task's own time [s]; the same as the run's for a task that never was paused."""
        return self._run.now - self.lag if self.steady else self._now

    @property
    def stands(self) -> bool:
        """True when it stands still and shall stay so."""
        return self.rate == self._wanted == 0.0

    @property
    def slowing(self) -> bool:
        """True when it stands still, or is on its way there."""
        return self._wanted == 0.0

    def slow_down(self) -> None:
        """Lets it come to a standstill."""
        self._now = self.now
        self._wanted = 0.0
        self.steady = False

    def speed_up(self) -> None:
        """Lets it go with the run again."""
        self._wanted = 1.0
        self.steady = self.rate == 1.0

    def advance(self) -> None:
        """Moves on to the time of the run, in each cycle in which it is not steady."""
        time = self._run.now
        elapsed = time - self.lag - self._now
        before, step = self.rate, elapsed / _RAMP
        self.rate = min(1.0, before + step) if self._wanted else max(0.0, before - step)
        self._now += elapsed * (before + self.rate) / 2.0
        self.lag = time - self._now
        self.steady = self.rate == self._wanted == 1.0

    def jump(self, seconds: float) -> None:
        """Moves on by so much while it stands: one step of a paused task."""
        self._now += seconds
        self.lag -= seconds

"""Wishes for a task that come from other threads at any moment."""

from __future__ import annotations

from skiros_py.tasks.context import Control, Mode
from skiros_py.testing import Bench, tiny_world


class Hasty(Control):
    """Somebody resumes the task as soon as the control thread has read that it does a single step."""

    armed = False

    @property
    def mode(self) -> Mode:  # type: ignore[override]
        read = self._mode
        if self.armed and read is Mode.SINGLE:
            self.armed, self._mode = False, Mode.RUN
        return read

    @mode.setter
    def mode(self, mode: Mode) -> None:
        self._mode = mode


def test_a_resume_while_a_single_step_is_ended_is_not_lost() -> None:
    with Bench(tiny_world()) as bench:
        task = bench.tasks.begin(bench.goal("In(ball_1, slot_1)"))
        task.control = control = Hasty()
        task.step()
        bench.until(lambda: bench.tasks.steps, limit=1.0)
        control.armed = True
        bench.until(lambda: task.done, limit=10.0)

    assert task.report is not None
    assert task.report.reached


def test_after_a_single_step_it_pauses_unless_somebody_wants_something_else_by_then() -> None:
    control = Control()
    control.wish(Mode.SINGLE)
    assert control.end_single() is Mode.PAUSE
    control.wish(Mode.SINGLE)
    control.wish(Mode.RUN)
    assert control.end_single() is Mode.RUN
    assert control.mode is Mode.RUN


def test_the_first_stop_counts() -> None:
    control = Control()
    control.end("lunch")
    control.end("really")

    assert control.stop == "lunch"

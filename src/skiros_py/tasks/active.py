"""A step that runs."""

from __future__ import annotations

from dataclasses import dataclass

from skiros_py.execution.running import Running
from skiros_py.planning.plan import Step
from skiros_py.tasks.handle import StepRun


@dataclass(slots=True, eq=False)
class Active:
    """A step that runs.

    Attributes:
        index: Its index in the present agenda.
        run: The step, its number and who does it.
        robot: Id of the robot of that.
        running: What runs.
        leaving: Why it was broken off; empty while it is wanted.
    """

    index: int
    run: StepRun
    robot: str
    running: Running
    leaving: str = ""

    @property
    def step(self) -> Step:
        """The skill with its arguments."""
        return self.run.step

"""One run of a skill or primitive, with all data that a test may need."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.skills.conditions import Verdict
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.questions import Question
from skiros_py.world.change import Change
from skiros_py.world.scene import describe


@dataclass(frozen=True, slots=True, repr=False)
class SkillTrial:
    """The result of running a module; true if it succeeded.

    Attributes:
        module: Its name.
        outcome: How it ended.
        events: Module events during the run.
        changes: Changes of the world during the run.
        seconds: Duration, in time of the run [s].
        verdicts: Whether its postconditions hold afterwards, with reasons, by their keys' order; none of a primitive.
        questions: The questions to a person.
    """

    module: str
    outcome: Outcome
    events: tuple[ModuleEvent, ...]
    changes: tuple[Change, ...]
    seconds: float
    verdicts: tuple[Verdict, ...] = ()
    questions: tuple[Question, ...] = ()

    @property
    def succeeded(self) -> bool:
        """True when it succeeded."""
        return isinstance(self.outcome, Success)

    @property
    def reason(self) -> str:
        """Why it failed, or its message upon success."""
        return self.outcome.message if isinstance(self.outcome, Success) else self.outcome.reason

    def check(self) -> Self:
        """Returns itself if it succeeded.

        Raises:
            AssertionError: It failed; with the reasons, the events and the changes.
        """
        if not self.succeeded:
            raise AssertionError(str(self))
        return self

    def lines(self) -> list[str]:
        """Returns all of it as lines."""
        return [
            f"{self.module} {'succeeded' if self.succeeded else 'failed'} after {self.seconds:.2f} s: {self.reason}",
            *_section("postconditions", [line for verdict in self.verdicts for line in verdict.lines()]),
            *_section("events", [_event(event) for event in self.events]),
            *_section("changes", [line for change in self.changes for line in _change(change)]),
            *_section("questions", [question.text for question in self.questions]),
        ]

    def __bool__(self) -> bool:
        return self.succeeded

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def __repr__(self) -> str:
        return f"<{self.module} {'succeeded' if self.succeeded else 'failed'}: {self.reason}>"


def _section(title: str, lines: list[str]) -> list[str]:
    return [f"  {title}:", *(f"    {line}" for line in lines)] if lines else []


def _event(event: ModuleEvent) -> str:
    code = f" ({event.code})" if event.status in (Status.RUNNING, Status.ERROR) else ""
    return f"{event.time:7.3f} s  {event.kind} {event.module}: {event.status.value}{code} {event.text}".rstrip()


def _change(change: Change) -> list[str]:
    head = f"{change.time:7.3f} s  {change.author}: {change.reason}"
    return [head, *(f"           {line}" for line in describe(None, change.edits))]

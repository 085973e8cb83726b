"""What a rehearsal says: for each round the steps of its plan, which would fail and why, and what that rules out."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol, TypeVar

from skiros_py.messages import Message, joined
from skiros_py.planning.requests import RuledOut
from skiros_py.skills.conditions import Condition


class StepState(enum.StrEnum):
    """How a step of a plan went."""

    DONE = "done"
    """It succeeded, perhaps after some tries."""
    FAILED = "failed"
    """It failed, in its last try too."""
    NOT_TRIED = "not tried"
    """The plan was given up before."""


@dataclass(frozen=True, slots=True)
class RehearsedStep:
    """A step of a plan, as it went.

    Attributes:
        text: The step in short ("pick pallet_a starter_1").
        skill: Its skill.
        arguments: Element id by parameter key.
        state: How it went.
        tries: How often it was tried.
        reason: Why its last failed try failed; empty if none did.
        cause: The kind of that reason ("reach", "collision", "not grasped", …); empty if unknown.
        bodies: Ids of what was in the way or out of reach.
        seconds: How long it took, with all tries [s].
        picture: File with a picture of its last failure; empty if there is none.
    """

    text: str
    skill: str
    arguments: dict[str, str]
    state: StepState
    tries: int = 0
    reason: str = ""
    cause: str = ""
    bodies: tuple[str, ...] = ()
    seconds: float = 0.0
    picture: str = ""


@dataclass(frozen=True, slots=True)
class Play:
    """A plan that was carried out once, in a second physics world.

    Attributes:
        draw: Number of the draw of what no belief says, such as where in its place a part lies; from 0.
        steps: The steps: those that were run, in order, then those that were not.
        reached: Whether the goal held at the end, in that world.
        reason: Why not; empty if it did.
        seconds: How long it took [s].
        ruled_out: What it has shown to be impossible; the play ends with that.
    """

    draw: int
    steps: tuple[RehearsedStep, ...]
    reached: bool
    reason: str
    seconds: float
    ruled_out: tuple[RuledOut, ...] = ()

    @property
    def as_planned(self) -> bool:
        """True if it reached the goal, and each step succeeded in the end."""
        return self.reached and all(step.state is StepState.DONE for step in self.steps)


@dataclass(frozen=True, slots=True)
class Round:
    """One plan, carried out once for each draw until one shows that something is impossible.

    Attributes:
        plays: How it went; empty if there was no plan.
        no_plan: Why there was no plan.
    """

    plays: tuple[Play, ...] = ()
    no_plan: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """True if the goal was reached in each draw."""
        return bool(self.plays) and all(play.reached for play in self.plays)


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """The result: a plan that passed, or why none does.

    Attributes:
        rounds: Plans in turn; each avoids what was ruled out before.
        ruled_out: All that was ruled out; a plan made with that is the one that was rehearsed last.
        assumptions: What no belief says, and was assumed.
        wall: Wall time used [s].
    """

    rounds: tuple[Round, ...]
    ruled_out: tuple[RuledOut, ...]
    assumptions: tuple[str, ...]
    wall: float

    @property
    def passed(self) -> bool:
        """True if the last plan reached the goal in each draw."""
        return bool(self.rounds) and self.rounds[-1].passed

    @property
    def first_fails(self) -> bool:
        """True if the plan that would be made without a rehearsal fails: another one has to be made on the way."""
        plays = self.rounds[0].plays if self.rounds else ()
        return not (plays and all(play.as_planned for play in plays))

    @property
    def seconds(self) -> float | None:
        """How long the plan that passed takes, on average over the draws [s]; None if none did."""
        plays = self.rounds[-1].plays if self.passed else ()
        return sum(play.seconds for play in plays) / len(plays) if plays else None

    @property
    def reason(self) -> str:
        """Why the goal would not be reached; empty if a plan passed."""
        if self.passed or not self.rounds:
            return ""
        last = self.rounds[-1]
        failed = [play.reason for play in last.plays if not play.reached]
        found = joined("; ", (one.reason for one in self.ruled_out))
        if last.no_plan:
            return joined("; ", filter(None, (found, *last.no_plan)))
        return Message("{reason} (in {count} of {all} draws)", reason=failed[0], count=len(failed), all=len(last.plays))

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        said = {"passed": self.passed, "first_fails": self.first_fails, "seconds": self.seconds, "reason": self.reason}
        return {**said, **asdict(self)}


T_co = TypeVar("T_co", covariant=True)


class Cancellable(Protocol[T_co]):
    """Work that goes on elsewhere."""

    def done(self) -> bool:
        """Returns True when :meth:`result` will not block."""

    def result(self) -> T_co:
        """Waits for the result.

        Raises:
            SkirosError: There is none: something broke, or it was cancelled.
        """

    def cancel(self) -> None:
        """Ends it; does nothing if it is done."""


class Rehearser(Protocol):
    """Starts rehearsals of goals from present beliefs."""

    def __call__(self, goal: Sequence[Condition]) -> Cancellable[Rehearsal]:
        """Starts one and returns at once."""

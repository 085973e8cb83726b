"""Writes effects without sensing them, for fakes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import check_seconds
from skiros_py.messages import Message
from skiros_py.skills.behaviour import Behaviour, Scope, Uses, check_texts, require
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success


@dataclass(frozen=True, slots=True)
class AssertEffects(Behaviour):
    """Writes postconditions of the skill into the world after a while. Only fakes may do this.

    Attributes:
        seconds: How long the pretended work takes.
        only: Keys of the postconditions to write (:attr:`Condition.key`); all of them where left out.
    """

    kind: ClassVar[str] = "assert_effects"

    seconds: float = 1.0
    only: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_seconds("assert effects", self.seconds)
        require(isinstance(self.only, tuple), "assert effects", "a tuple of keys such as ('held',)", self.only)
        check_texts("assert effects", "the key of a postcondition", *self.only)

    @property
    def title(self) -> str:
        """How long, and what is pretended."""
        return f"pretend for {self.seconds:g} s{': ' + ', '.join(self.only) if self.only else ''}"

    def uses(self) -> Uses:
        """What it pretends."""
        return Uses(pretends=self.only)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Waits, then writes."""
        yield from scope.context.sleep(self.seconds)
        effects = scope.context.effects
        if effects is None:
            return Failure(Message("there is no skill here whose effects could be pretended"))
        effects.write(*self.only, author=scope.author, reason=Message("pretended by a fake"), pretended=True)
        return Success(Message("pretended"))

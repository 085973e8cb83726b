"""Children one after the other, until one succeeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import check_children, in_turn, numbered
from skiros_py.skills.behaviour import Behaviour, Scope, Uses
from skiros_py.skills.outcome import Execution, Outcome, Success


@dataclass(frozen=True, slots=True)
class Fallback(Behaviour):
    """One after the other until one succeeds."""

    kind: ClassVar[str] = "fallback"

    children: tuple[Behaviour, ...]

    def __post_init__(self) -> None:
        check_children("fallback", self.children)

    @classmethod
    def of(cls, *children: Behaviour) -> Fallback:
        """Makes one."""
        return cls(children)

    @property
    def title(self) -> str:
        """Its kind."""
        return "fallback"

    def uses(self) -> Uses:
        """One child has to succeed."""
        return Uses(needs="any")

    def named_children(self) -> Mapping[str, Behaviour]:
        """Its children by number."""
        return numbered(self.children)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the children in turn."""
        return in_turn(self.children, scope, ends_with=Success)

"""Children one after the other, until one fails."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from skiros_py.behaviours.children import check_children, in_turn, numbered
from skiros_py.skills.behaviour import Behaviour, Scope
from skiros_py.skills.outcome import Execution, Failure, Outcome


@dataclass(frozen=True, slots=True)
class Sequence(Behaviour):
    """One after the other; the first failure ends it."""

    kind: ClassVar[str] = "sequence"

    children: tuple[Behaviour, ...]

    def __post_init__(self) -> None:
        check_children("sequence", self.children)

    @classmethod
    def of(cls, *children: Behaviour) -> Sequence:
        """Makes one."""
        return cls(children)

    @property
    def title(self) -> str:
        """Its kind."""
        return "sequence"

    def named_children(self) -> Mapping[str, Behaviour]:
        """Its children by number."""
        return numbered(self.children)

    def run(self, scope: Scope) -> Execution[Outcome]:
        """Runs the children in turn."""
        return in_turn(self.children, scope, ends_with=Failure)

"""The answer to "does this hold?": yes or no, and why, as a tree."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

_SHOWN = 5
"""So many reasons are said in one sentence."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether something holds, and why.

    Attributes:
        holds: The answer.
        text: What was asked, with the answer in words ("starter_1 is not in pallet_a").
        parts: The verdicts this one was made from.
        vague: True when it only says that nothing was found; of several reasons the others say more.
    """

    holds: bool
    text: str
    parts: tuple[Verdict, ...] = ()
    vague: bool = False

    def __bool__(self) -> bool:
        return self.holds

    def lines(self, indent: int = 0) -> list[str]:
        """Returns the tree as indented lines, the decisive parts only: where it fails, why it fails."""
        mark = "holds" if self.holds else "does not hold"
        own = f"{'  ' * indent}{self.text}" + (f" ({mark})" if self.parts else "")
        return [own, *(line for part in self.decisive for line in part.lines(indent + 1))]

    @property
    def why(self) -> str:
        """What decides it, in one line for people: "ball_1 is not in box_b: it is in box_a"."""
        return self.sentence if all(end.vague for end in _ends(self)) else self._reasons

    @property
    def sentence(self) -> str:
        """What was asked, and what decides it: "In(ball_1, box_b): ball_1 is not in box_b: it is in box_a"."""
        return f"{self.text}: {self._reasons}" if self.parts else self.text

    @property
    def _reasons(self) -> str:
        """The ends of the tree of reasons, each once."""
        ends = tuple(_ends(self))
        said = list(dict.fromkeys(end.text for end in ends if not end.vague) or dict.fromkeys(end.text for end in ends))
        rest = [f"and {len(said) - _SHOWN} more"] if len(said) > _SHOWN else []
        return "; ".join((*said[:_SHOWN], *rest))

    @property
    def decisive(self) -> tuple[Verdict, ...]:
        """The parts that decide it: where it fails, those that fail."""
        return tuple(part for part in self.parts if part.holds == self.holds) or self.parts


def _ends(verdict: Verdict) -> Iterator[Verdict]:
    if not verdict.parts:
        yield verdict
    for part in verdict.decisive:
        yield from _ends(part)

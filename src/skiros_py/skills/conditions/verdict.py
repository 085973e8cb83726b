"""The answer to "does this hold?": yes or no, and why, as a tree."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Verdict"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether something holds, and why.

    Attributes:
        holds: The answer.
        text: What was asked, with the answer in words ("starter_1 is not in pallet_a").
        parts: The verdicts this one was made from.
    """

    holds: bool
    text: str
    parts: tuple[Verdict, ...] = ()

    def __bool__(self) -> bool:
        return self.holds

    def lines(self, indent: int = 0) -> list[str]:
        """Returns the tree as indented lines, the decisive parts only: where it fails, why it fails."""
        mark = "holds" if self.holds else "does not hold"
        own = f"{'  ' * indent}{self.text}" + (f" ({mark})" if self.parts else "")
        shown = [part for part in self.parts if part.holds == self.holds] or list(self.parts)
        return [own, *(line for part in shown for line in part.lines(indent + 1))]

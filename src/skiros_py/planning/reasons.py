"""Why there is no plan, as data: causes, and the smallest changes that would make one."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any, Protocol

from skiros_py.skills.conditions import Condition
from skiros_py.world.change import Writer
from skiros_py.world.transaction import Transaction
from skiros_py.world.world import World


class CauseKind(enum.StrEnum):
    """What kind of thing stands in the way."""

    NO_SKILL = "no skill"
    """No robot that is there has a skill that brings it about."""
    MISSING_FACT = "missing fact"
    """Something that no skill changes does not hold."""
    MISSING_ELEMENT = "missing element"
    """There is no thing of the class that is needed."""
    TOO_FEW = "too few"
    """There are such things, but fewer than are wanted."""
    FULL = "full"
    """The place is taken, and nothing takes away what is there."""
    DOES_NOT_FIT = "does not fit"
    """What is wanted there fits into no place there is."""
    CONTRADICTION = "contradiction"
    """Conditions of the goal exclude each other."""
    CONFLICT = "conflict"
    """Each condition could be reached alone, but not all of these together."""


@dataclass(frozen=True, slots=True)
class Cause:
    """One reason.

    Attributes:
        kind: What kind of reason.
        text: The whole of it in the operator's words.
        conditions: The conditions of the goal that it keeps from being reached.
        skill: The skill that would bring it about; None if there is none.
        precondition: What that skill needs and never gets, in words; empty if that is not it.
        elements: The elements and classes it is about, ids or CURIEs.
        why: The heart of it, without the conditions and without the way down to it; empty if they say all.
    """

    kind: CauseKind
    text: str
    conditions: tuple[Condition, ...] = ()
    skill: str | None = None
    precondition: str = ""
    elements: tuple[str, ...] = ()
    why: str = ""

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        return {
            "kind": str(self.kind),
            "text": self.text,
            "why": self.why,
            "conditions": [str(condition) for condition in self.conditions],
            "skill": self.skill,
            "precondition": self.precondition,
            "elements": list(self.elements),
        }


class Edit(Protocol):
    """One change to the scene."""

    def __str__(self) -> str:
        """Says it as an instruction: "put starter_2 in pallet_a"."""
        ...

    @property
    def elements(self) -> tuple[str, ...]:
        """Ids of the elements that it speaks of."""
        ...

    def write(self, tx: Transaction) -> None:
        """Writes it into a transaction."""
        ...


@dataclass(frozen=True, slots=True)
class Exchange:
    """A condition of the goal that is wanted otherwise.

    Attributes:
        condition: The condition, as it was wanted.
        by: What to want instead.
    """

    condition: Condition
    by: Condition

    def __str__(self) -> str:
        return f"want {self.by} instead of {self.condition}"

    def as_json(self) -> dict[str, str]:
        """Returns it as plain data."""
        return {"condition": str(self.condition), "by": str(self.by)}


@dataclass(frozen=True, slots=True)
class Repair:
    """A smallest change after which there is a plan.

    What has edits or changes the goal was tried out. What does neither cannot be done in the scene: it says what
    somebody has to see to, such as a skill that a robot lacks.

    Attributes:
        text: What to do, in the operator's words.
        edits: The changes to the world.
        without: Conditions to take out of the goal.
        instead: Conditions to want otherwise.
    """

    text: str
    edits: tuple[Edit, ...] = ()
    without: tuple[Condition, ...] = ()
    instead: tuple[Exchange, ...] = ()

    @property
    def done(self) -> str:
        """What of it is done by applying it, in the operator's words: the changes to the world, without the goal."""
        return " and ".join(dict.fromkeys(map(str, self.edits)))

    def apply(self, world: World, author: str = "repair", writer: Writer = Writer.PERSON, holder: str = "") -> None:
        """Makes the changes to the world, as one transaction; the goal is the caller's.

        Args:
            world: The world.
            author: Who decided it.
            writer: What kind of author that is.
            holder: Whose locks let it through, where they are not the author's.

        Raises:
            WorldError: The world is no longer such that it can be done; nothing is changed then.
            Locked: Somebody else has locked one of the elements.
        """
        if not self.edits:
            return
        with world.transaction(author, f"so that there is a plan: {self.text}", writer=writer, holder=holder) as tx:
            for edit in self.edits:
                edit.write(tx)

    def as_json(self) -> dict[str, Any]:
        """Returns it as plain data."""
        return {
            "text": self.text,
            "edits": [str(edit) for edit in self.edits],
            "without": [str(condition) for condition in self.without],
            "instead": [exchange.as_json() for exchange in self.instead],
            "elements": list(dict.fromkeys(name for edit in self.edits for name in edit.elements)),
        }

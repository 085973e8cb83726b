"""A parsed goal: its structure, with words that have not been looked up yet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class Name:
    """The name of an argument.

    Attributes:
        text: Id, label or class of an element, or a variable.
        variable: True if it can only be a variable (PDDL's ``?x``), False if it cannot be one (in quotes, or
            without a question mark in PDDL).
    """

    text: str
    variable: bool | None = None


@dataclass(frozen=True, slots=True)
class Word:
    """A condition's word with its arguments."""

    word: str
    arguments: tuple[Name, ...]


@dataclass(frozen=True, slots=True)
class Negation:
    """It must not hold."""

    part: Said


@dataclass(frozen=True, slots=True)
class Joined:
    """All of them, or any of them."""

    word: Literal["and", "or"]
    parts: tuple[Said, ...]


@dataclass(frozen=True, slots=True)
class Quantification:
    """For all elements of a class, or for some."""

    quantifier: Literal["for all", "exists"]
    variable: str
    class_: str
    part: Said


Said = Word | Negation | Joined | Quantification


def implication(premises: Sequence[Said]) -> Said:
    """Returns "a implies b implies c", that is "not a or (not b or c)"; a single one is returned as it is."""
    result = premises[-1]
    for premise in reversed(premises[:-1]):
        result = Joined("or", (Negation(premise), result))
    return result

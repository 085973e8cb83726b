"""What a data type is, and how long a text may be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from skiros_py.world.element import Value

__all__ = ["LONGEST_TEXT", "Datatype", "check_length"]

LONGEST_TEXT = 64 * 1024
"""Characters that one literal may have: what is longer belongs into a file of its own."""


@dataclass(frozen=True, slots=True)
class Datatype:
    """One kind of value that a property may have.

    Attributes:
        says: What a value looks like, for messages.
        accepts: CURIEs of the literal types that it is read from.
        check: Returns the value in its own form, or raises ValueError where it is none.
        parse: Reads the text of a literal.
        format: Writes it; numbers are the same after reading again, poses to 1e-9.
    """

    says: str
    accepts: frozenset[str]
    check: Callable[[object], Value]
    parse: Callable[[str], Value]
    format: Callable[[Value], str]


def check_length(text: str) -> str:
    """Returns the text.

    Raises:
        ValueError: It is longer than a literal may be.
    """
    if len(text) > LONGEST_TEXT:
        raise ValueError(f"a text may have {LONGEST_TEXT} characters, and this has {len(text)}")
    return text

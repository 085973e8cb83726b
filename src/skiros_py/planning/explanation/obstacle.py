"""What keeps a fact from ever becoming true."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from skiros_py.planning.domain.model import Atom
from skiros_py.planning.reasons import CauseKind


@dataclass(frozen=True, slots=True)
class Obstacle:
    """The first thing in the way.

    Attributes:
        kind: What kind of thing.
        text: The way down to it in words.
        core: The last of that by itself: what is the case instead of what would be needed.
        skill: The skill that would give what is lacking; None where there is none.
        precondition: What that skill needs and never gets, in words.
        elements: Elements and classes it is about.
        missing: The fact that never holds, perhaps with variables left; None where it is not one fact.
        types: Classes of the variables of that fact.
    """

    kind: CauseKind
    text: str
    skill: str | None = None
    precondition: str = ""
    elements: tuple[str, ...] = ()
    missing: Atom | None = None
    types: Mapping[str, str] = field(default_factory=dict)
    core: str = ""

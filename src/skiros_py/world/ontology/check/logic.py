"""The port of reasoners: whether statements can all be true, and which classes nothing can be of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import pyoxigraph as ox

from skiros_py.world.ontology.check.owl import rdf

__all__ = ["NoAnswer", "NotStarted", "Reasoner", "Verdict", "one_of", "some"]


class NoAnswer(Exception):
    """A reasoner could not answer: too little time, or statements that it does not take; the text says which."""


class NotStarted(NoAnswer):
    """A reasoner could not even be started, whatever the statements are; the text says why."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a reasoner found.

    Attributes:
        consistent: False when the statements contradict each other.
        unsatisfiable: IRIs of the classes that nothing can be of, sorted; empty where not consistent.
        near: IRIs of individuals at which a contradiction shows; empty where the reasoner does not say.
    """

    consistent: bool
    unsatisfiable: tuple[str, ...] = ()
    near: tuple[str, ...] = ()


class Reasoner(Protocol):
    """What the check asks of a reasoner."""

    @property
    def name(self) -> str:
        """What people call it."""
        ...

    @property
    def is_complete(self) -> bool:
        """True when it sees every contradiction of OWL 2 DL."""
        ...

    def judge(self, triples: Sequence[ox.Triple], classes: Sequence[str]) -> Verdict:
        """Looks for contradictions, and for classes (IRIs) that nothing can be of.

        Raises:
            NoAnswer: It could not be found out.
        """
        ...

    def consistent(self, triples: Sequence[ox.Triple]) -> bool:
        """Returns False when the statements contradict each other.

        Raises:
            NoAnswer: It could not be found out.
        """
        ...


def some(class_: str) -> str:
    """Returns the IRI of the one thing that is made up to be of a class (IRI)."""
    return f"urn:skiros-check:one-of:{class_}"


def one_of(class_: str) -> ox.Triple:
    """Returns the statement that there is something of a class (IRI): a contradiction where nothing can be."""
    return ox.Triple(ox.NamedNode(some(class_)), ox.NamedNode(rdf("type")), ox.NamedNode(class_))

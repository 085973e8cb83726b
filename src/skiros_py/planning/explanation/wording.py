"""Causes with the findings behind them, in the operator's words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from skiros_py.messages import Message, joined
from skiros_py.planning.domain.literals import BY_CLASS, CAN, HAS, IS, NOT, NOTHING, VALUE, compared
from skiros_py.planning.domain.matching import is_variable
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.plan import Cause, CauseKind
from skiros_py.world.names import local_name
from skiros_py.world.ontology import Ontology


class Wording:
    """Words atoms in natural language."""

    def __init__(self, ontology: Ontology) -> None:
        self._ontology = ontology

    def atom(self, atom: Atom, types: Mapping[str, str]) -> str:
        """Words an atom.

        Args:
            atom: The atom, perhaps with variables left.
            types: Classes of the variables.
        """
        predicate = atom.predicate
        names = [some(local_name(types.get(a, "")) or "thing") if is_variable(a) else a for a in atom.arguments]
        if predicate.startswith(CAN):
            skill = predicate.removeprefix(CAN)
            return Message("{agent} has the skill '{skill}'", agent=names[0], skill=skill)
        if predicate.startswith(HAS):
            return Message("{thing} has a {property}", thing=names[0], property=self.term(predicate.removeprefix(HAS)))
        if predicate.startswith(NOTHING):
            return self.stated(Message("nothing"), predicate.removeprefix(NOTHING), names[0])
        if predicate.startswith(NOT):
            said = self.atom(Atom(predicate.removeprefix(NOT), atom.arguments), types)
            return Message("it is not true that {said}", said=said)
        if predicate.startswith(IS):
            kind = some(local_name(predicate.removeprefix(IS)))
            return Message("{thing} is {kind}", thing=names[0], kind=kind)
        if predicate.startswith(BY_CLASS):
            relation = self.term(predicate.removeprefix(BY_CLASS))
            like = {"thing": names[0], "relation": relation, "other": names[1]}
            return Message("what is like {thing} {relation} what is like {other}", **like)
        if predicate.startswith(VALUE):
            property_, comparison = compared(predicate)
            of = {"property": self.term(property_), "thing": names[0], "comparison": str(comparison)}
            return Message("the {property} of {thing} is {comparison}", **of)
        return self.stated(names[0], predicate, *names[1:])

    def stated(self, subject: str, relation: str, *objects: str) -> str:
        """Words a relation between two things, or what is said of one."""
        term = self.term(relation)
        if not objects:
            return Message("{subject} {relation}", subject=subject, relation=term)
        verb = term.removesuffix(" a")  # "has a": the name has its article
        return Message("{subject} {relation} {object}", subject=subject, relation=verb, object=joined(" ", objects))

    def none(self, atom: Atom, types: Mapping[str, str]) -> str:
        """Words that a relation with variables holds for none: "compressor_1 fits in no Compartment"."""
        names: list[str] = []
        first = True
        for argument in atom.arguments:
            kind = local_name(types.get(argument, "thing"))
            if is_variable(argument):
                names.append(Message("no {kind}", kind=kind) if first else Message("any {kind}", kind=kind))
                first = False
            else:
                names.append(argument)
        return self.stated(names[0], atom.predicate, *names[1:])

    def term(self, term: str) -> str:
        """Returns the display name of a relation or property."""
        if term in self._ontology.relations:
            label = self._ontology.relations[term].label
            return Message("is {relation}", relation=label) if self._ontology.is_placement(term) else label
        return self._ontology.properties[term].label if term in self._ontology.properties else local_name(term)


def some(noun: str) -> str:
    """Returns a noun with its article."""
    return Message("an {kind}", kind=noun) if noun[:1].lower() in "aeiou" else Message("a {kind}", kind=noun)


@dataclass(frozen=True, slots=True)
class Shortage:
    """More is required than there is.

    Attributes:
        wanted: How many different ones are required.
        there: The existing things or places.
        things: The things that need the places and could be removed; empty if things are short.
    """

    wanted: int
    there: tuple[str, ...]
    things: tuple[str, ...] = ()

    @property
    def excess(self) -> int:
        """How many more are required than there are."""
        return self.wanted - len(self.there)


@dataclass(frozen=True, slots=True)
class Found:
    """A cause with the findings behind it.

    Attributes:
        cause: The cause.
        reason: What never holds; None for conditions that exclude each other.
        shortage: What is short; None if the cause is not a shortage.
    """

    cause: Cause
    reason: Reason | None = None
    shortage: Shortage | None = None


@dataclass(frozen=True, slots=True)
class Reason:
    """The reason why a fact never becomes true.

    Attributes:
        kind: The kind of cause.
        text: The chain of reasons in words.
        core: The last link alone: the actual state that prevents the required one.
        skill: The skill that would provide the missing fact; None if there is none.
        precondition: The unreachable precondition of that skill, in words.
        elements: The elements and classes involved.
        missing: The fact that never holds, perhaps with variables left; None if it is not one fact.
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

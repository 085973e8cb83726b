"""Possible placements: the placement relations that an element can have, and the present elements that accept it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from contextlib import suppress

from skiros_py.api.ontology import PlacementOption, PlacementOptions, PlaceOption
from skiros_py.errors import UsageError, WorldError
from skiros_py.messages import joined
from skiros_py.skills.conditions.effects import Relate, brought_about
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.change import Writer
from skiros_py.world.element import Placement
from skiros_py.world.ids import Ids
from skiros_py.world.index import Index
from skiros_py.world.ontology.ontology import Ontology
from skiros_py.world.reasoners.registry import Proposal
from skiros_py.world.terms import End, Relation
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import ELEMENT, PLACEMENT

_TRIAL = "placed_on_trial"
"""Id of the element placed as a trial; never published."""


def placement_options(
    view: Index,
    class_: str,
    element: str | None,
    limit: int,
    relation: str | None = None,
    after: str = "",
    skills: Iterable[SkillDescription] = (),
    language: str = "en",
) -> PlacementOptions:
    """Returns the possible places of an element, and for each whether it would accept the element now.

    Args:
        view: The state.
        class_: Class of the element to place.
        element: Id of the element; None for a new one of the class.
        limit: Maximum number of places for each relation.
        relation: Only this relation.
        after: Only places after this id.
        skills: Skills of the present robots.
        language: Language tag of the labels.

    Raises:
        UnknownName: There is no such relation.
        UsageError: It is not a placement relation.
    """
    wanted = _placements(view) if relation is None else [_placement(view, relation)]
    accepted = _relations_for(class_, skills, view.ontology)
    options = []
    for one in wanted:
        guests, places = (one.domains, one.ranges) if one.place_end == "object" else (one.ranges, one.domains)
        if view.ontology.missed_end(class_, guests):
            continue
        found = sorted(set(_candidates(view, places)) - {element})
        start = bisect_right(found, after)
        shown = found[start : start + limit]
        options.append(
            PlacementOption(
                relation=one.curie,
                label=one.in_language(language).label,
                accepted=one.curie in accepted,
                places=[_place(view, name, _why_not(view, class_, element, one.curie, name)) for name in shown],
                total=len(found),
                next=shown[-1] if shown and start + limit < len(found) else None,
            )
        )
    return PlacementOptions(class_=class_, element=element, options=options)


def _relations_for(class_: str, skills: Iterable[SkillDescription], ontology: Ontology) -> set[str]:
    """Returns the relations that skills need to hold for parameters that accept the class."""
    found = set()
    for skill in skills:
        accepting = {p.key for p in skill.params if ontology.is_a(class_, p.element_class)}
        effects = (effect for condition in skill.pre for effect in brought_about(condition))
        found |= {e.relation for e in effects if isinstance(e, Relate) and e.subject in accepting}
    return found


def _placements(view: Index) -> list[Relation]:
    names = sorted(name for name in view.ontology.sub_relations(PLACEMENT) if name != PLACEMENT)
    return [view.ontology.relation(name) for name in names]


def _placement(view: Index, name: str) -> Relation:
    relation = view.ontology.relation(name)
    placements = _placements(view)
    if relation not in placements:
        raise UsageError(
            "{name} does not place anything: use one of {relations}",
            name=name,
            relations=", ".join(r.curie for r in placements),
        )
    return relation


def _candidates(view: Index, end: End) -> Iterator[str]:
    first = end[0] if end else (ELEMENT,)
    for class_ in first:
        for name in view.instances(class_):
            if not view.ontology.missed_end(view.element(name).type, end):
                yield name


def _place(view: Index, name: str, why_not: str) -> PlaceOption:
    element = view.element(name)
    return PlaceOption.view_of(element, id=name, class_=element.type, fits=not why_not, why_not=why_not)


def _why_not(view: Index, class_: str, element: str | None, relation: str, place: str) -> str:
    """Returns why an element, or a new one of a class, cannot be placed there; empty if it can.

    It is placed in a private state.
    """
    tx = Transaction(view, Ids())
    if element is not None:
        tx.place(element, relation, place)
        problems = [sentence for _, sentence in tx.problems()]
    else:
        tx.add(class_, id=_TRIAL, placement=Placement(relation, place))
        # Other faults of a new element, such as missing pieces, are reported when it is added.
        problems = [sentence for name, sentence in tx.problems() if name == place]
    if not problems:
        with suppress(WorldError):
            after, edits = tx.finish()
            proposal = Proposal(view, after, edits, "somebody", Writer.PERSON)
            problems = list(view.reasoners.vetoes(proposal)) if edits else []
    text = joined("; ", problems)
    return text.replace(_TRIAL, "it") if _TRIAL in text else text

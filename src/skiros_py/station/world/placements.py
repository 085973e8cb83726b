"""Possible placements: the placement relations that an element can have, and the present elements that accept it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator

from skiros_py.api.ontology import PlacementOption, PlacementOptions, PlaceOption
from skiros_py.errors import UsageError, WorldError
from skiros_py.world.change import Writer
from skiros_py.world.element import Placement
from skiros_py.world.ids import Ids
from skiros_py.world.index import Index
from skiros_py.world.reasoners.registry import Proposal
from skiros_py.world.terms import End, Relation
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import ELEMENT, PLACEMENT

_TRIAL = "placed_on_trial"
"""Id of the element placed as a trial; never published."""


def placement_options(
    view: Index, class_: str, element: str | None, limit: int, relation: str | None = None, after: str = ""
) -> PlacementOptions:
    """Returns the possible places of an element, and for each whether it would accept the element now.

    Args:
        view: The state.
        class_: Class of the element to place.
        element: Id of the element; None for a new one of the class.
        limit: Maximum number of places for each relation.
        relation: Only this relation.
        after: Only places after this id.

    Raises:
        UnknownName: There is no such relation.
        UsageError: It is not a placement relation.
    """
    wanted = _placements(view) if relation is None else [_placement(view, relation)]
    trial = _Trial(view, class_, element)
    shown = [_option(view, trial, r, limit, after) for r in wanted if not view.ontology.missed_end(class_, _guests(r))]
    return PlacementOptions(class_=class_, element=element, options=shown)


def _placements(view: Index) -> list[Relation]:
    names = sorted(name for name in view.ontology.sub_relations(PLACEMENT) if name != PLACEMENT)
    return [view.ontology.relation(name) for name in names]


def _placement(view: Index, name: str) -> Relation:
    relation = view.ontology.relation(name)
    placements = _placements(view)
    if relation not in placements:
        raise UsageError(f"{name} does not place anything: use one of {', '.join(r.curie for r in placements)}")
    return relation


def _guests(relation: Relation) -> End:
    return relation.domains if relation.place_end == "object" else relation.ranges


def _places(relation: Relation) -> End:
    return relation.ranges if relation.place_end == "object" else relation.domains


def _option(view: Index, trial: _Trial, relation: Relation, limit: int, after: str) -> PlacementOption:
    found = sorted(set(_candidates(view, _places(relation))) - {trial.element})
    start = bisect_right(found, after)
    shown = found[start : start + limit]
    return PlacementOption(
        relation=relation.curie,
        label=relation.label,
        places=[_place(view, name, trial.why_not(relation.curie, name)) for name in shown],
        total=len(found),
        next=shown[-1] if shown and start + limit < len(found) else None,
    )


def _candidates(view: Index, end: End) -> Iterator[str]:
    first = end[0] if end else (ELEMENT,)
    for class_ in first:
        for name in view.instances(class_):
            if not view.ontology.missed_end(view.element(name).type, end):
                yield name


def _place(view: Index, name: str, why_not: str) -> PlaceOption:
    element = view.element(name)
    return PlaceOption(id=name, class_=element.type, label=element.label, fits=not why_not, why_not=why_not)


class _Trial:
    """Places an element in a private state, to find the reasons against it.

    Args:
        view: The state.
        class_: Class of the element to place.
        element: Id of the element; None for a new one.
    """

    def __init__(self, view: Index, class_: str, element: str | None) -> None:
        self.element = element
        self._view = view
        self._class = class_

    def why_not(self, relation: str, place: str) -> str:
        """Returns why it cannot be placed there; empty if it can."""
        tx = Transaction(self._view, Ids())
        if self.element is not None:
            tx.place(self.element, relation, place)
            about = None
        else:
            tx.add(self._class, id=_TRIAL, placement=Placement(relation, place))
            about = place  # other faults of a new element, such as missing pieces, are reported when it is added
        problems = [sentence for name, sentence in tx.problems() if about is None or name == about]
        return ("; ".join(problems) or self._objection(tx)).replace(_TRIAL, "it")

    def _objection(self, tx: Transaction) -> str:
        try:
            after, edits = tx.finish()
        except WorldError:
            return ""
        proposal = Proposal(self._view, after, edits, "somebody", Writer.PERSON)
        return "; ".join(self._view.reasoners.vetoes(proposal)) if edits else ""

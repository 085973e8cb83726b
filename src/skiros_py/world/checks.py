"""Rules for writes (checked at once) and for states (checked before they are published).

Problems are returned as sentences for the author of the write, not raised.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache, partial

from skiros_py.errors import UnknownName
from skiros_py.geometry import Solid
from skiros_py.messages import Message, joined, listed
from skiros_py.world.element import Value, is_abstract, is_learned
from skiros_py.world.ids import is_valid_id
from skiros_py.world.index import Index
from skiros_py.world.literals import CLASS_NAME, DATATYPES, LONGEST_TEXT, check_string, shown
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Cardinality, Family
from skiros_py.world.vocabulary import ELEMENT, LABEL, POSE_FRAME, ROOT, SOLID, SPATIAL_THING


def number_problems(view: Index, element_id: str) -> Iterator[str]:
    """Yields a sentence for each relation or property by which an element has too much or too little.

    What is abstract may leave things open, so it never has too little.
    """
    for number in _numbers(view.ontology, view.element(element_id).type):
        yield from _number_problem(view, element_id, number)
    for relation in _one_subject(view.ontology):
        subjects = view.subjects(relation, element_id)
        if len(subjects) > 1:
            yield Message(
                "{thing} is the {relation} of {subjects}: it can be so of one only",
                thing=element_id,
                relation=relation,
                subjects=" and ".join(subjects),
            )


def _number_problem(view: Index, element_id: str, number: Cardinality) -> Iterator[str]:
    found = _counted(view, element_id, number)
    if number.most is not None and len(found) > number.most:
        said = {"said": _said(view, element_id, number), "most": number.most, "count": len(found)}
        if found[0]:
            yield Message(
                "{said} at most {most}, and there are {count} ({things})", things=", ".join(found[:10]), **said
            )
        else:
            yield Message("{said} at most {most}, and there are {count}", **said)
    elif len(found) < number.least and not is_abstract(element_id):
        said = {"said": _said(view, element_id, number), "least": number.least}
        if found:
            yield Message("{said} at least {least}, and there are {count}", count=len(found), **said)
        else:
            yield Message("{said} at least {least}, and there is none", **said)


def _said(view: Index, element_id: str, number: Cardinality) -> Message:
    said = {"thing": element_id, "kind": view.element(element_id).type, "relation": number.relation}
    if number.of:
        return Message("{thing} ({kind}) must have by {relation} a {other}", other=number.of, **said)
    return Message("{thing} ({kind}) must have by {relation}", **said)


def _counted(view: Index, element_id: str, number: Cardinality) -> tuple[str, ...]:
    """The objects of a relation; for a property, "" for its value."""
    ontology = view.ontology
    if number.relation in ontology.properties:
        return () if view.value(element_id, number.relation) is None else ("",)
    found = view.objects(element_id, number.relation)
    if number.of is None or number.of not in ontology.classes:
        return found
    return tuple(name for name in found if ontology.is_a(view.element(name).type, number.of))


@lru_cache(maxsize=4096)
def _numbers(ontology: Ontology, class_: str) -> tuple[Cardinality, ...]:
    """The cardinalities for individuals of a class; computed relations are not stored and so not counted."""
    said = {number for number in ontology.cardinalities(class_) if _is_counted(ontology, number.relation)}
    one = {
        Cardinality(relation.curie, 0, 1, None)
        for relation in ontology.relations.values()
        if relation.functional
        and _is_counted(ontology, relation.curie)
        and not ontology.missed_end(class_, relation.domains)
    }
    return tuple(sorted(said | one, key=lambda number: (number.relation, number.least, repr(number))))


@lru_cache(maxsize=4096)
def _guest_numbers(ontology: Ontology, class_: str) -> tuple[Cardinality, ...]:
    """The cardinalities of placements whose subject is the place."""
    relations = ontology.relations
    return tuple(
        number
        for number in _numbers(ontology, class_)
        if number.relation in relations and relations[number.relation].place_end == "subject"
    )


def _is_counted(ontology: Ontology, name: str) -> bool:
    if name in ontology.relations:
        return ontology.family(name) is not Family.COMPUTED
    return name in ontology.properties


@lru_cache(maxsize=64)
def _one_subject(ontology: Ontology) -> tuple[str, ...]:
    return tuple(
        sorted(r.curie for r in ontology.relations.values() if r.inverse_functional and r.family is not Family.COMPUTED)
    )


# ---------------------------------------------------------------- writes and states


_UNCHANGED = Message("the ontology is never changed at run time")


def class_problem(ontology: Ontology, class_: str) -> str | None:
    """Returns why there can be no element of a class, or None."""
    if class_ not in ontology.classes:
        if class_.partition(":")[0] in ("owl", "rdf", "rdfs"):
            return Message("'{name}' makes a term of the ontology, and {why}", name=class_, why=_UNCHANGED)
        return str(UnknownName("class", class_, ontology.subclasses(ELEMENT)))
    if not ontology.is_a(class_, ELEMENT):
        return Message("{name} is no {kind}, so there can be no element of it", name=class_, kind=ELEMENT)
    return None


def id_problem(element_id: str) -> str | None:
    """Returns why a text cannot be the id of a new element, or None."""
    if element_id == "this":
        return Message("'this' stands for the scene itself and is no id of an element")
    if not is_valid_id(element_id):
        shown = element_id if len(element_id) <= 60 else f"{element_id[:60]}…"
        return Message(
            "'{id}' is no id: use letters, digits and underscores (200 at most), and no digit first", id=shown
        )
    return None


def goal_problem(goal: object) -> str | None:
    """Returns why something cannot be the text of a goal, or None."""
    try:
        fits = check_string(goal).strip() != ""
    except ValueError:
        fits = False
    if fits:
        return None
    return Message("a goal is a text of at most {most} characters, got {given}", most=LONGEST_TEXT, given=shown(goal))


def element_problem(view: Index, element_id: str) -> str | None:
    """Returns why an id names no writable element, or None."""
    if view.has(element_id):
        if is_abstract(element_id) and not is_learned(element_id):
            return Message("'{name}' is an individual of the ontology, and {why}", name=element_id, why=_UNCHANGED)
        return None
    ontology = view.ontology
    if any(element_id in terms for terms in (ontology.classes, ontology.relations, ontology.properties)):
        return Message("'{name}' is a term of the ontology, and {why}", name=element_id, why=_UNCHANGED)
    return str(view.unknown(element_id))


def relation_problem(view: Index, subject: str, relation: str, object_: str) -> str | None:
    """Returns why a relation between two existing elements cannot be stated, or None."""
    ontology = view.ontology
    if relation not in ontology.relations:
        if relation.partition(":")[0] in ("owl", "rdf", "rdfs"):
            return Message("'{name}' speaks of the ontology, and {why}", name=relation, why=_UNCHANGED)
        return str(UnknownName("relation", relation, ontology.relations))
    declared = ontology.relations[relation]
    if declared.family is Family.COMPUTED:
        return Message("{relation} is computed by a reasoner and never stored", relation=relation)
    if is_learned(subject) != is_learned(object_):
        return Message(
            "{subject} {relation} {object}: what is learned outlives the scene, so neither may refer to the other;"
            " say by sk:appliesTo which class it is about",
            subject=subject,
            relation=relation,
            object=object_,
        )
    faults = [
        Message(
            "its {end} must be a {kind}, and {thing} is a {other}",
            end=end,
            kind=listed(missed, either=True),
            thing=name,
            other=view.element(name).type,
        )
        for end, name, allowed in (("subject", subject, declared.domains), ("object", object_, declared.ranges))
        if (missed := ontology.missed_end(view.element(name).type, allowed))
    ]
    if not faults:
        return None
    return Message(
        "{subject} {relation} {object}: {faults}. {allowed}",
        subject=subject,
        relation=relation,
        object=object_,
        faults=joined("; ", faults),
        allowed=_allowed(view, subject, object_),
    )


def checked_value(ontology: Ontology, element_id: str, type_: str, property_: str, value: Value | None) -> Value | None:
    """Returns a checked value in the form in which elements of a class store it; None stays None.

    Raises:
        ValueError: The element cannot have it; the text says why.
    """
    if property_ == LABEL:
        return _checked_label(element_id, value)
    declared = ontology.properties.get(property_)
    if declared is None:
        raise ValueError(str(UnknownName("property", property_, ontology.properties)))
    if value is None:
        return None
    missed = ontology.missed_end(type_, declared.domains)
    if missed:
        raise ValueError(
            Message(
                "{property} belongs to a {kind}, and {thing} is a {other}",
                property=property_,
                kind=listed(missed, either=True),
                thing=element_id,
                other=type_,
            )
        )
    try:
        checked = DATATYPES[declared.range].check(value)
        if property_ == SOLID:
            Solid.from_json(str(checked))
        if declared.range == CLASS_NAME and checked not in ontology.classes:
            raise ValueError(UnknownName("class", str(checked), ontology.classes))
    except ValueError as error:
        says = DATATYPES[declared.range].says
        raise ValueError(_not_fitting(property_, element_id, says, value, error)) from None
    return checked


def state_problems(view: Index, touched: Iterable[str], places: Iterable[str] = ()) -> Iterator[tuple[str, str]]:
    """Yields (element, problem) for the elements that a transaction touched.

    Args:
        view: The state after the transaction.
        touched: Elements that were written to, existing or not.
        places: Elements where something was placed or removed.
    """
    present = sorted(name for name in touched if view.has(name))
    for element_id in present:
        for problem in (*_tie_problems(view, element_id), *number_problems(view, element_id)):
            yield element_id, problem
    for place in sorted(name for name in places if view.has(name)):
        for number in _guest_numbers(view.ontology, view.element(place).type):
            yield from ((place, problem) for problem in _number_problem(view, place, number))
    yield from _cycles(present, lambda name: _parents(view, name), partial(Message, "{thing} is inside itself: {ring}"))
    framed = partial(Message, "{thing} has its own frame as {relation}: {ring}", relation=POSE_FRAME)
    yield from _cycles(present, lambda name: view.objects(name, POSE_FRAME), framed)


def _checked_label(element_id: str, value: Value | None) -> str:
    says = Message("a text of at most {most} characters", most=LONGEST_TEXT)
    try:
        text = check_string(value)
    except ValueError as error:
        raise ValueError(_not_fitting(LABEL, element_id, says, value, error)) from None
    if not text:
        raise ValueError(_not_fitting(LABEL, element_id, says, value))
    return text


def _not_fitting(property_: str, element_id: str, says: str, value: object, error: object = "") -> Message:
    text = {"property": property_, "thing": element_id, "wanted": says, "given": shown(value)}
    if str(error):
        return Message("{property} of {thing} needs {wanted}, got {given} ({error})", error=error, **text)
    return Message("{property} of {thing} needs {wanted}, got {given}", **text)


def _allowed(view: Index, subject: str, object_: str) -> str:
    ontology = view.ontology
    types = view.element(subject).type, view.element(object_).type
    fitting = [
        r.curie
        for r in sorted(ontology.relations.values(), key=lambda r: r.curie)
        if r.family is not Family.COMPUTED
        and len(ontology.sub_relations(r.curie)) == 1
        and not any(ontology.missed_end(t, end) for t, end in zip(types, (r.domains, r.ranges), strict=True))
    ]
    there = ", ".join(fitting) or Message("nothing")
    return Message(
        "From a {kind} to a {other} there may be: {relations}", kind=types[0], other=types[1], relations=there
    )


def _tie_problems(view: Index, element_id: str) -> Iterator[str]:
    """Checks that every element is in one place, or part of one thing and moves with it."""
    owners, placement = view.owners(element_id), view.placement(element_id)
    if len(owners) > 1:
        yield Message(
            "{thing} is a piece of {owners}: a piece has one owner", thing=element_id, owners=" and ".join(owners)
        )
    if owners and placement is not None:
        yield Message(
            "{thing} is a piece of {owners} and goes with it: it can have no placement of its own",
            thing=element_id,
            owners=owners[0],
        )
    if owners or placement is not None or is_abstract(element_id):
        return
    ontology, type_ = view.ontology, view.element(element_id).type
    if ontology.is_a(type_, SPATIAL_THING) and not ontology.is_a(type_, ROOT):
        relations = sorted(r for r in ontology.relations if ontology.is_placement(r))
        leaves = ", ".join(r for r in relations if len(ontology.sub_relations(r)) == 1)
        yield Message(
            "{thing} ({kind}) is nowhere: give it a placement ({relations}) or an owner",
            thing=element_id,
            kind=type_,
            relations=leaves,
        )


def _parents(view: Index, element_id: str) -> tuple[str, ...]:
    placement = view.placement(element_id)
    owners = view.owners(element_id)
    return owners if placement is None else (*owners, placement.place)


def _cycles(
    names: list[str], parents: Callable[[str], tuple[str, ...]], says: Callable[..., Message]
) -> Iterator[tuple[str, str]]:
    """Yields cycles that are met on the way up from the names, by first parents: two parents are refused anyway."""
    climbed: set[str] = set()
    for name in names:
        path: list[str] = []
        current: str | None = name
        while current is not None and current not in climbed:
            climbed.add(current)
            path.append(current)
            current = next(iter(parents(current)), None)
        if current is not None and current in path:
            ring = [*path[path.index(current) :], current]
            yield current, says(thing=current, ring=" -> ".join(ring))

"""The ontology for people and forms: classes with the properties of their elements, and where they are used."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from skiros_py.api import ontology as api
from skiros_py.catalogue import Catalogue
from skiros_py.station.world.values import plain
from skiros_py.world.index import Index
from skiros_py.world.literals import DATATYPES
from skiros_py.world.ontology import Ontology
from skiros_py.world.taught import class_value
from skiros_py.world.terms import Property, Relation
from skiros_py.world.vocabulary import ELEMENT

_MOST_SHOWN = 100
"""Maximum number of individuals returned with a class."""


# ------------------------------------------------------------------ classes


def class_tree(view: Index, root: str, depth: int) -> api.ClassNode:
    """Returns a class with its subclasses, each below its primary parent.

    Raises:
        UnknownName: It is not a class.
    """
    view.ontology.ancestors(root)
    return _node(view, root, _primary_children(view.ontology), depth)


def _primary_children(ontology: Ontology) -> Mapping[str, list[str]]:
    children: dict[str, list[str]] = {}
    for name, class_ in sorted(ontology.classes.items()):
        if class_.primary_parent is not None:
            children.setdefault(class_.primary_parent, []).append(name)
    return children


def _node(view: Index, name: str, children: Mapping[str, list[str]], depth: int) -> api.ClassNode:
    class_, below = view.ontology.classes[name], children.get(name, [])
    return api.ClassNode.view_of(
        class_,
        name=name,
        instances=view.count(name),
        children=[_node(view, child, children, depth - 1) for child in below] if depth else [],
        children_total=len(below),
    )


def class_details(view: Index, name: str, catalogue: Catalogue) -> api.ClassDetails:
    """Describes a class.

    Raises:
        UnknownName: It is not a class.
    """
    ontology = view.ontology
    ancestors = ontology.ancestors(name)
    properties = [one for _, one in sorted(ontology.properties.items()) if not ontology.missed_end(name, one.domains)]
    return api.ClassDetails.view_of(
        ontology.classes[name],
        name=name,
        ancestors=list(ancestors),
        subclasses=list(ontology.subclasses(name)),
        properties=[
            api.ClassProperty.view_of(property_info(one), value=plain(class_value(view, name, one.curie)))
            for one in properties
        ],
        relations_from=[r.curie for r in _relations(ontology) if not ontology.missed_end(name, r.domains)],
        relations_to=[r.curie for r in _relations(ontology) if not ontology.missed_end(name, r.ranges)],
        how_many=ontology.cardinalities(name),
        instances=view.count(name),
        some_instances=list(view.some_instances(name, _MOST_SHOWN)),
        individuals=list(view.abstracts(name))[:_MOST_SHOWN],
        skills=list(_used(ontology, name, _skill_arguments(catalogue))),
        conditions=list(_used(ontology, name, _condition_arguments(catalogue))),
    )


def _used(ontology: Ontology, name: str, arguments: Iterable[tuple[str, str, str]]) -> Iterator[api.ClassUse]:
    """Yields the arguments that accept elements of a class, omitting very general ones."""
    for whose, argument, taken in sorted(set(arguments)):
        if taken in ontology.classes and taken != ELEMENT and ontology.is_a(name, taken):
            yield api.ClassUse(name=whose, argument=argument, class_=taken)


def _skill_arguments(catalogue: Catalogue) -> Iterator[tuple[str, str, str]]:
    for skill in catalogue.skills.values():
        for param in skill.description.params:
            if param.is_element:
                yield skill.description.name, param.key, param.element_class


def _condition_arguments(catalogue: Catalogue) -> Iterator[tuple[str, str, str]]:
    for name, condition in catalogue.conditions.items():
        yield from ((name, role.name, role.class_) for role in condition.roles)


# ------------------------------------------------------------------ relations and properties


def _relations(ontology: Ontology) -> list[Relation]:
    return [ontology.relations[name] for name in sorted(ontology.relations)]


def property_info(property_: Property) -> api.PropertyInfo:
    """Describes a property."""
    return api.PropertyInfo.view_of(
        property_,
        name=property_.curie,
        datatype=property_.range,
        says=DATATYPES[property_.range].says,
        borne_by=property_.domains,
    )


def relation_info(view: Index, relation: Relation) -> api.RelationInfo:
    """Describes a relation."""
    return api.RelationInfo.view_of(
        relation,
        name=relation.curie,
        family=relation.family.value,
        subjects=relation.domains,
        objects=relation.ranges,
        computed=view.reasoners.computes(relation.curie),
    )

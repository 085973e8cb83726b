"""Gathers what files say of scene individuals, and writes it into a world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import pyoxigraph as ox

from skiros_py.errors import FileError, UnknownName
from skiros_py.world.checks import class_problem
from skiros_py.world.element import Value
from skiros_py.world.ids import is_valid_id
from skiros_py.world.literals import parse_value
from skiros_py.world.names import SCENE
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document
from skiros_py.world.transaction import Transaction
from skiros_py.world.vocabulary import GOAL, LABEL, SCENE_CLASS

__all__ = ["SceneReader"]

_Where = tuple[Document, ox.Triple]


@dataclass(slots=True)
class _Individual:
    """What all files together say of one individual, each statement with where it was found."""

    types: dict[str, _Where] = field(default_factory=dict)
    values: dict[str, Value] = field(default_factory=dict)
    relations: dict[tuple[str, str], _Where] = field(default_factory=dict)
    first: Document | None = None


class SceneReader:
    """Reads scene individuals from any number of files that complete each other."""

    def __init__(self, ontology: Ontology) -> None:
        self._ontology = ontology
        self._names = ontology.names
        self._individuals: dict[str, _Individual] = {}
        self._goals: set[str] = set()

    def take(self, file: Document) -> None:
        """Reads a file's statements about scene individuals.

        Raises:
            FileError: A statement cannot be understood.
        """
        for triple in file.triples:
            if isinstance(triple.subject, ox.NamedNode) and triple.subject.value.startswith(SCENE):
                self._take(file, triple, self._names.name(triple.subject.value))

    def check_subject(self, scene: Document, triple: ox.Triple) -> None:
        """Refuses what a scene file says of anything but scene individuals and the file itself.

        Raises:
            FileError: The statement belongs into an ontology, or has no name to stand under.
        """
        if not isinstance(triple.subject, ox.NamedNode):
            raise scene.fault("a scene has no nameless individuals: give it a name in scene:", triple.predicate.value)
        iri = triple.subject.value
        if iri != scene.iri and not iri.startswith(SCENE):
            name = self._names.name(iri)
            raise scene.fault(f"a scene speaks of scene: individuals only; '{name}' belongs into an ontology file", iri)

    def goals(self) -> tuple[str, ...]:
        """Returns the goals that the files state, sorted."""
        return tuple(sorted(self._goals))

    def write(self, tx: Transaction) -> None:
        """Adds every individual, then its relations.

        Raises:
            FileError: An individual has no class, an unknown one or several, or is referred to but not described.
        """
        for name in sorted(self._individuals):
            individual = self._individuals[name]
            properties = dict(individual.values)
            label = properties.pop(LABEL, None)
            tx.add(self._class(name, individual), None if label is None else str(label), name, properties)
        for name in sorted(self._individuals):
            for (relation, object_), where in sorted(self._individuals[name].relations.items(), key=lambda r: r[0]):
                self._check_reference(object_, where)
                self._check_single(name, relation)
                tx.relate(name, relation, object_)

    def fault(self, scene: Document, problems: Sequence[tuple[str, str]]) -> FileError:
        """Makes one error of everything that a transaction found wrong, at the line of the first."""
        element = problems[0][0]
        individual = self._individuals.get(element)
        file = (individual.first if individual else None) or scene
        sentences = list(dict.fromkeys(sentence for _, sentence in problems))
        reason = sentences[0] if len(sentences) == 1 else "\n  - ".join(["is refused:", *sentences])
        return file.fault(reason, self._names.iri(element))

    # ------------------------------------------------------------ statements

    def _take(self, file: Document, triple: ox.Triple, name: str) -> None:
        if name == "this":
            self._take_goal(file, triple)
            return
        individual = self._individuals.setdefault(name, _Individual())
        individual.first = individual.first or file
        predicate = self._names.name(triple.predicate.value)
        if predicate == "rdf:type":
            self._take_type(file, triple, individual)
        elif isinstance(triple.object, ox.Literal):
            self._take_value(file, triple, individual, predicate, triple.object)
        elif isinstance(triple.object, ox.NamedNode):
            if predicate not in self._ontology.relations:
                raise self._unknown(file, triple, "relation", predicate)
            individual.relations[predicate, self._names.name(triple.object.value)] = (file, triple)
        else:
            raise self._at(file, triple, f"{predicate} of {name} needs a named individual of scene:")

    def _take_goal(self, file: Document, triple: ox.Triple) -> None:
        predicate = self._names.name(triple.predicate.value)
        if predicate == GOAL and isinstance(triple.object, ox.Literal):
            self._goals.add(triple.object.value)
        elif predicate == "rdf:type" and triple.object != ox.NamedNode(self._names.iri(SCENE_CLASS)):
            raise self._at(file, triple, f"scene:this stands for the scene itself and is a {SCENE_CLASS}")
        elif predicate not in ("rdf:type", LABEL, "rdfs:comment"):
            raise self._at(file, triple, f"scene:this has {GOAL}, rdfs:label and rdfs:comment only, not {predicate}")

    def _take_type(self, file: Document, triple: ox.Triple, individual: _Individual) -> None:
        if not isinstance(triple.object, ox.NamedNode):
            raise self._at(file, triple, "the class of an individual must have a name")
        class_ = self._names.name(triple.object.value)
        if class_ != "owl:NamedIndividual":
            individual.types[class_] = (file, triple)

    def _take_value(
        self, file: Document, triple: ox.Triple, individual: _Individual, predicate: str, literal: ox.Literal
    ) -> None:
        if predicate != LABEL and predicate not in self._ontology.properties:
            raise self._unknown(file, triple, "property", predicate)
        range_ = "xsd:string" if predicate == LABEL else self._ontology.properties[predicate].range
        try:
            value = parse_value(literal.value, self._names.name(literal.datatype.value), range_)
        except ValueError as error:
            raise self._at(file, triple, f"{predicate} {error}") from None
        if individual.values.setdefault(predicate, value) != value:
            raise self._at(file, triple, f"{predicate} has two values, and may have one")

    # ------------------------------------------------------------ individuals

    def _class(self, name: str, individual: _Individual) -> str:
        assert individual.first is not None
        if not is_valid_id(name):
            raise individual.first.fault(f"'{name}' is no id: use letters, digits and underscores", SCENE + name)
        if len(individual.types) != 1:
            has = (
                f"{len(individual.types)} classes ({', '.join(sorted(individual.types))})"
                if individual.types
                else "no class"
            )
            raise individual.first.fault(f"{name} has {has}, and must have one: the most specific", SCENE + name)
        ((class_, (file, triple)),) = individual.types.items()
        problem = class_problem(self._ontology, class_)
        if problem:
            raise self._at(file, triple, f"{name}: {problem}", at_object=True)
        return class_

    def _check_reference(self, object_: str, where: _Where) -> None:
        if object_ not in self._individuals:
            raise self._at(*where, str(UnknownName("individual", object_, self._individuals)), at_object=True)

    def _check_single(self, name: str, relation: str) -> None:
        """A placement or a functional relation would silently be replaced by the next."""
        same = self._moves(relation)
        if not same and not self._ontology.relation(relation).functional:
            return
        relations = self._individuals[name].relations
        rivals = [(r, o) for r, o in relations if r == relation or (same and self._moves(r))]
        if len(rivals) > 1:
            said = ", ".join(f"{r} {o}" for r, o in sorted(rivals))
            raise self._at(*relations[rivals[-1]], f"{name} may have one of these, not all: {said}")

    def _moves(self, relation: str) -> bool:
        """Tells whether stating a relation of an individual says where that individual is."""
        return self._ontology.is_placement(relation) and self._ontology.relation(relation).place_end == "object"

    def _unknown(self, file: Document, triple: ox.Triple, kind: str, name: str) -> FileError:
        known = self._ontology.relations if kind == "relation" else self._ontology.properties
        other = self._ontology.properties if kind == "relation" else self._ontology.relations
        if name in other:
            needs = "a literal" if kind == "relation" else "an individual of scene:"
            return self._at(file, triple, f"{name} needs {needs}")
        return self._at(file, triple, str(UnknownName(kind, name, known)))

    def _at(self, file: Document, triple: ox.Triple, reason: str, *, at_object: bool = False) -> FileError:
        assert isinstance(triple.subject, ox.NamedNode)
        term = triple.object.value if at_object and isinstance(triple.object, ox.NamedNode) else triple.predicate.value
        return file.fault(reason, triple.subject.value, term)

"""Reads individuals from files, as the edits that add them to a world.

A scene may state ``scene:robot_2 sk:builtLike scene:robot_1`` and, for the parts, only the differences, such as where
base_2 starts. Instead of another robot it may name the file that describes one, by its IRI.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import NamedTuple

import pyoxigraph as ox

from skiros_py.errors import FileError, UnknownName
from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, RelationEdit
from skiros_py.world.checks import class_problem, id_problem
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.literals import format_value, parse_value, shown
from skiros_py.world.names import SCENE, Names, local_name
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document
from skiros_py.world.ontology.statements import Statements
from skiros_py.world.terms import Family, reached
from skiros_py.world.vocabulary import BUILT_LIKE, GOAL, LABEL, POSE, POSE_FRAME, ROBOT, STRUCTURE
from skiros_py.world.vocabulary import SCENE as SCENE_CLASS


@dataclass(slots=True)
class Individual:
    """The combined statements of all files about one individual.

    Attributes:
        types: Names of its classes.
        values: Its properties, the label among them.
        relations: Names of a relation and of the individual at its other end.
    """

    types: list[str] = field(default_factory=list)
    values: dict[str, Value] = field(default_factory=dict)
    relations: list[tuple[str, str]] = field(default_factory=list)


# ---------------------------------------------------------------- copies


_NUMBERED = re.compile(r"(.*?)_?(\d+)")


def add_copy(
    individuals: MutableMapping[str, Individual],
    copy: str,
    like: str,
    ontology: Ontology,
    described: Mapping[str, Individual] | None = None,
) -> None:
    """Completes a robot from the description of another one, and creates its parts.

    Existing statements about the copy and its parts are kept. Map poses of parts are not copied: two bases do not
    start in one place.

    Args:
        individuals: All individuals by name, among them the robot to complete.
        copy: Name of the robot to complete.
        like: Name of the robot to copy from.
        ontology: Defines which relations are structure.
        described: The individuals among which the robot to copy is described in full; None for these.
    """
    below, source = ontology.sub_relations(STRUCTURE), individuals if described is None else described

    def parts(whole: str) -> list[str]:
        return [to for relation, to in source[whole].relations if relation in below and to in source]

    pieces = reached([like], parts)
    names = {piece: copy if piece == like else _renamed(piece, like, copy) for piece in pieces}
    for piece, name in names.items():
        _complete(individuals.setdefault(name, Individual()), source[piece], names, ontology)


def _is_iri(name: str) -> bool:
    """Returns True for the IRI of a file, False for the id of an individual."""
    return "/" in name or ":" in name


def _renamed(piece: str, like: str, copy: str) -> str:
    """Returns the copy's name for a part: base_1 of robot_1 is base_2 of robot_2, its lamp is its lamp_2."""
    old, new = (_NUMBERED.fullmatch(name) for name in (like, copy))
    number = new.group(2) if new else copy
    if old is not None and piece.endswith(f"_{old.group(2)}"):
        piece = piece[: -len(old.group(2)) - 1]
    return f"{piece}_{number}"


def _complete(copy: Individual, like: Individual, names: Mapping[str, str], ontology: Ontology) -> None:
    copy.types = copy.types or list(like.types)
    in_frame = any(relation == POSE_FRAME and target in names for relation, target in like.relations)
    for name, value in like.values.items():
        if name != POSE or in_frame:
            copy.values.setdefault(name, value)
    said = {_kind(relation, ontology) for relation, _ in copy.relations} - {Family.STRUCTURE}
    for relation, target in like.relations:
        if _kind(relation, ontology) not in said:
            copy.relations.append((relation, names.get(target, target)))


def _kind(relation: str, ontology: Ontology) -> str:
    """Returns the group of relations copied together: all placements, all pieces, or one relation."""
    family = ontology.family(relation)
    return family if family in (Family.PLACEMENT, Family.STRUCTURE) else relation


_MOST_SHOWN = 10
_CURIE = re.compile(r"[\w-]+:[\w-]+")


def fault_of_all(files: Sequence[Document], names: Names, problems: Sequence[tuple[str, str]]) -> FileError:
    """Combines many problems (individual, sentence) in one error, each with its line, located at the first."""
    once, statements = list(dict.fromkeys(problems)), Statements(files, names)
    faults = [_fault(statements, name or "this", sentence) for name, sentence in once[:_MOST_SHOWN]]
    faults.sort(key=lambda fault: (fault.path != files[0].path, str(fault.path), fault.line or 0))
    first = faults[0]
    if len(once) == 1:
        return first
    shown = [f"{fault.path.name}:{fault.line}: {fault.reason}" if fault.line else fault.reason for fault in faults]
    more = [f"and {len(once) - _MOST_SHOWN} more"] if len(once) > _MOST_SHOWN else []
    return FileError(first.path, "\n  - ".join(["is refused:", *shown, *more]), line=first.line)


def _fault(statements: Statements, name: str, sentence: str) -> FileError:
    """The sentence names the predicate that is to blame, if any is."""
    named = set(_CURIE.findall(sentence))
    return statements.fault(name, sentence, *[p for p in statements.about(name) if p in named][:1])


# ---------------------------------------------------------------- reading individuals


class Predicate(NamedTuple):
    """One predicate.

    Attributes:
        name: Its CURIE.
        range: CURIE of the data type of its values; empty if it has none.
    """

    name: str
    range: str


_TERMS = ("owl:Class", "owl:ObjectProperty", "owl:DatatypeProperty", "owl:AnnotationProperty", "rdfs:Datatype")


class Reader:
    """Reads the individuals of one namespace from any number of files that complete each other.

    Attributes:
        files: The files read so far.
        individuals: The individuals read so far, by name, as their files describe them.
    """

    def __init__(self, ontology: Ontology, namespace: str = SCENE) -> None:
        self.files: list[Document] = []
        self._ontology = ontology
        self._names = ontology.names
        self._namespace = namespace
        self._predicates: dict[str, Predicate] = {}
        self._types: dict[str, str] = {}
        self.individuals: dict[str, Individual] = {}
        self._goals: set[str] = set()
        self._copies: dict[str, str] = {}
        self._described_in: dict[str, Mapping[str, Individual]] = {}

    def take(self, file: Document, *, whole: bool = False) -> None:
        """Reads a file's statements about individuals of the namespace.

        Args:
            file: The file.
            whole: Whether the file may speak of nothing else.

        Raises:
            FileError: A statement cannot be understood, or does not belong here.
        """
        self.files.append(file)
        namespace, last, name = self._namespace, "", ""
        for triple in file.triples:
            subject = triple.subject
            if not isinstance(subject, ox.NamedNode) or not (iri := subject.value).startswith(namespace):
                if whole:
                    self._check_foreign(file, triple)
                continue
            if iri != last:
                last, name = iri, self._names.name(iri)
            self._take(file, triple, name)

    def copied_files(self) -> list[str]:
        """Returns the IRIs of files whose robots are copied."""
        return sorted({like for like in self._copies.values() if _is_iri(like)})

    def describe(self, iri: str, individuals: Mapping[str, Individual]) -> None:
        """Tells which individuals a file whose robot is copied describes, with what it imports."""
        self._described_in[iri] = individuals

    def edits(self) -> Iterator[Edit]:
        """Yields the edits that make a world without these individuals one with them; may be called once.

        Raises:
            FileError: An individual has no class, an unknown one or several, is referred to but not described, or is in
                two places.
        """
        self._add_copies()
        names = sorted(self.individuals)
        for name in names:
            yield ElementEdit(name, None, self._element(name, self.individuals[name]))
        yield from self._placements(names)
        for name in names:
            for relation, object_ in sorted(set(self.individuals[name].relations)):
                if not self._ontology.is_placement(relation):
                    self._check_single(name, relation)
                    yield RelationEdit(name, relation, self._described(name, relation, object_), old=False, new=True)
        if self._goals:
            yield GoalsEdit((), tuple(sorted(self._goals)))

    # ------------------------------------------------------------ statements

    def _predicate(self, triple: ox.Triple) -> Predicate:
        """The predicate of a statement; each is looked up once, since files repeat a few of them."""
        iri = triple.predicate.value
        found = self._predicates.get(iri)
        if found is None:
            name, properties = self._names.name(iri), self._ontology.properties
            range_ = "xsd:string" if name == LABEL else properties[name].range if name in properties else ""
            found = self._predicates[iri] = Predicate(name, range_)
        return found

    def _check_foreign(self, file: Document, triple: ox.Triple) -> None:
        own = "scene:" if self._namespace == SCENE else self._names.name(self._namespace + "x")[:-1]
        if not isinstance(triple.subject, ox.NamedNode):
            reason = f"there can be no nameless individuals here: give it a name in {own}"
            raise file.fault(reason, None, triple.predicate.value)
        iri = triple.subject.value
        if iri != file.iri and not self._repeats(triple):
            name = self._names.name(iri)
            raise file.fault(f"may speak of {own} individuals only; '{name}' belongs into an ontology file", iri)

    def _repeats(self, triple: ox.Triple) -> bool:
        """Whether a statement declares a term that is declared anyway: editors write that where they use one."""
        if self._predicate(triple).name != "rdf:type":
            return False
        assert isinstance(triple.subject, ox.NamedNode)
        term, ontology = self._names.name(triple.subject.value), self._ontology
        known = term in ontology.classes or term in ontology.relations or term in ontology.properties
        is_term = isinstance(triple.object, ox.NamedNode) and self._names.name(triple.object.value) in _TERMS
        return is_term and (known or term.partition(":")[0] in ("owl", "rdf", "rdfs", "xsd", "sk"))

    def _take_scene(self, file: Document, triple: ox.Triple) -> None:
        predicate = self._predicate(triple).name
        if predicate == GOAL and isinstance(triple.object, ox.Literal):
            self._goals.add(triple.object.value)
        elif predicate == "rdf:type":
            if not isinstance(triple.object, ox.NamedNode) or self._names.name(triple.object.value) not in _SCENE_TYPES:
                raise _at(file, triple, f"scene:this stands for the scene itself and is a {SCENE_CLASS}")
        elif predicate not in (LABEL, "rdfs:comment"):
            raise _at(file, triple, f"scene:this has {GOAL}, rdfs:label and rdfs:comment only, not {predicate}")

    def _take(self, file: Document, triple: ox.Triple, name: str) -> None:
        if name == "this":
            self._take_scene(file, triple)
            return
        individual = self.individuals.get(name)
        if individual is None:
            individual = self.individuals[name] = Individual()
        predicate, object_ = self._predicate(triple), triple.object
        if predicate.name == "rdf:type":
            self._take_type(file, triple, individual)
        elif isinstance(object_, ox.Literal):
            self._take_value(file, triple, name, predicate, object_)
        elif predicate.name not in self._ontology.relations:
            raise self._misused(file, triple, "relation", predicate)
        elif isinstance(object_, ox.NamedNode) and predicate.name == BUILT_LIKE:
            iri = object_.value
            self._take_copy(name, self._names.name(iri) if iri.startswith(self._namespace) else iri)
        elif isinstance(object_, ox.NamedNode):
            individual.relations.append((predicate.name, self._names.name(object_.value)))
        else:
            raise _at(file, triple, f"{predicate.name} of {name} needs an individual that has a name")

    def _take_copy(self, name: str, like: str) -> None:
        if self._copies.setdefault(name, like) != like:
            said = f"{BUILT_LIKE} {self._copies[name]} and {like}"
            raise self._fault(f"{name} may be like one other robot, not {said}", name, BUILT_LIKE)

    def _take_type(self, file: Document, triple: ox.Triple, individual: Individual) -> None:
        if not isinstance(triple.object, ox.NamedNode):
            raise _at(file, triple, "the class of an individual must have a name")
        class_ = self._names.name(triple.object.value)
        if class_ != "owl:NamedIndividual" and class_ not in individual.types:
            individual.types.append(class_)

    def _take_value(
        self, file: Document, triple: ox.Triple, name: str, predicate: Predicate, literal: ox.Literal
    ) -> None:
        if not predicate.range:
            raise self._misused(file, triple, "property", predicate)
        try:
            iri = literal.datatype.value
            type_ = self._types.get(iri) or self._types.setdefault(iri, self._names.name(iri))
            value = parse_value(literal.value, type_, predicate.range)
        except ValueError as error:
            raise _at(file, triple, f"{name}: {predicate.name} {error}") from None
        other = self.individuals[name].values.setdefault(predicate.name, value)
        if other != value:
            said = f"{shown(format_value(other))} and {shown(format_value(value))}"
            raise _at(file, triple, f"{name}: {predicate.name} has two values, and may have one: {said}")

    def _misused(self, file: Document, triple: ox.Triple, wanted: str, predicate: Predicate) -> FileError:
        if not predicate.range and predicate.name not in self._ontology.relations:
            known = self._ontology.relations if wanted == "relation" else self._ontology.properties
            return _at(file, triple, str(UnknownName(wanted, predicate.name, known)))
        needs = "a literal" if wanted == "relation" else "an individual of scene:"
        return _at(file, triple, f"{predicate.name} needs {needs}")

    # ------------------------------------------------------------ individuals

    def _add_copies(self) -> None:
        for name, like in sorted(self._copies.items()):
            if like in self._described_in:
                described = self._described_in[like]
                add_copy(self.individuals, name, self._robot_of(name, like, described), self._ontology, described)
                continue
            self._described(name, BUILT_LIKE, like)
            if like in self._copies:
                reason = f"{like} is {BUILT_LIKE} {self._copies[like]} itself: name one that is described in full"
                raise self._fault(f"{name}: {reason}", name, BUILT_LIKE, like)
            add_copy(self.individuals, name, like, self._ontology)
        self._copies.clear()

    def _robot_of(self, name: str, iri: str, described: Mapping[str, Individual]) -> str:
        """Returns the robot that a file describes."""
        classes = {ROBOT, *self._ontology.subclasses(ROBOT)}
        robots = [one for one, individual in described.items() if classes.intersection(individual.types)]
        if len(robots) != 1:
            found = ", ".join(sorted(robots)) or "none"
            reason = f"{name}: <{iri}> must describe one robot, and describes {found}"
            raise self._fault(reason, name, BUILT_LIKE)
        return robots[0]

    def _element(self, name: str, individual: Individual) -> Element:
        class_ = self._class(name, individual)
        values, individual.values = individual.values, {}
        label = values.pop(LABEL, None)
        return Element(name, class_, local_name(class_) if label is None else str(label), MappingProxyType(values))

    def _class(self, name: str, individual: Individual) -> str:
        problem = id_problem(name)
        if problem:
            raise self._fault(problem, name)
        if len(individual.types) != 1:
            classes = ", ".join(sorted(individual.types))
            has = f"{len(individual.types)} classes ({classes})" if classes else "no class"
            raise self._fault(f"{name} has {has}, and must have one: the most specific", name)
        (class_,) = individual.types
        problem = class_problem(self._ontology, class_)
        if problem:
            raise self._fault(f"{name}: {problem}", name, class_)
        return class_

    def _placements(self, names: list[str]) -> Iterator[Edit]:
        placements: dict[str, Placement] = {}
        for name in names:
            for relation, object_ in sorted(set(self.individuals[name].relations)):
                if self._ontology.is_placement(relation):
                    self._described(name, relation, object_)
                    element, placement = self._ontology.placed(name, relation, object_)
                    if placements.setdefault(element, placement) != placement:
                        said = ", ".join(f"{p.relation} {p.place}" for p in (placements[element], placement))
                        raise self._fault(f"{element} may have one of these, not all: {said}", name, relation)
        for element, placement in placements.items():
            yield PlacementEdit(element, None, placement)

    def _described(self, name: str, relation: str, object_: str) -> str:
        if object_ not in self.individuals:
            raise self._fault(str(UnknownName("individual", object_, self.individuals)), name, relation, object_)
        return object_

    def _check_single(self, name: str, relation: str) -> None:
        """The next object of a functional relation would silently replace the one before."""
        if self._ontology.relation(relation).functional:
            objects = {o for r, o in self.individuals[name].relations if r == relation}
            if len(objects) > 1:
                said = ", ".join(f"{relation} {o}" for o in sorted(objects))
                raise self._fault(f"{name} may have one of these, not all: {said}", name, relation)

    def _fault(self, reason: str, name: str, *terms: str) -> FileError:
        return Statements(self.files, self._names).fault(name, reason, *terms)


_SCENE_TYPES = (SCENE_CLASS, "owl:NamedIndividual")


def _at(file: Document, triple: ox.Triple, reason: str) -> FileError:
    assert isinstance(triple.subject, ox.NamedNode)
    return file.fault(reason, triple.subject.value, triple.predicate.value)

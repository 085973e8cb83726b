"""The available robots, each a file of individuals that scenes import."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from skiros_py.errors import UnknownName, UsageError
from skiros_py.plugins import PluginFault, installation
from skiros_py.ports.models import GROUP
from skiros_py.world.names import SCENE, STANDARD_PREFIXES
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document
from skiros_py.world.scene.robots import documents_of
from skiros_py.world.vocabulary import HAS_A, ROBOT

_TYPE = STANDARD_PREFIXES["rdf"] + "type"


@dataclass(frozen=True, slots=True)
class RobotFile:
    """One robot as scenes import it.

    Attributes:
        name: Last part of its IRI ("mobile_panda").
        iri: What a scene imports.
        individuals: Class (CURIE) of each individual by id, in file order.
        pieces: The part relations: (whole, piece).
    """

    name: str
    iri: str
    individuals: Mapping[str, str]
    pieces: frozenset[tuple[str, str]]

    def first(self, class_: str, ontology: Ontology) -> str:
        """Returns its first individual of a class.

        Raises:
            UsageError: It has none.
        """
        for id_, own in self.individuals.items():
            if ontology.is_a(own, class_):
                return id_
        raise UsageError(f"robot '{self.name}' has no {class_}")


def find_robot(name: str, ontology: Ontology) -> RobotFile:
    """Finds a robot by the last part of its IRI, among those shipped and those of plug-ins.

    Raises:
        UnknownName: There is none of that name.
    """
    robots = {robot.name: robot for robot in _robots(ontology)}
    if name not in robots:
        raise UnknownName("robot", name, robots)
    return robots[name]


def _robots(ontology: Ontology) -> Iterator[RobotFile]:
    for document in (*ontology.sources, *_of_plugins()):
        robot = _read(document, ontology)
        if ROBOT in robot.individuals.values():
            yield robot


def _of_plugins() -> Iterator[Document]:
    for entry in installation().of(GROUP):
        yield from (found for found in documents_of(entry) if not isinstance(found, PluginFault))


def _read(document: Document, ontology: Ontology) -> RobotFile:
    individuals: dict[str, str] = {}
    pieces: set[tuple[str, str]] = set()
    has_a = ontology.names.iri(HAS_A)
    for triple in document.triples:
        subject, object_ = (getattr(term, "value", "") for term in (triple.subject, triple.object))
        if subject.startswith(SCENE) and triple.predicate.value == _TYPE:
            individuals[subject.removeprefix(SCENE)] = ontology.names.name(object_)
        elif triple.predicate.value == has_a:
            pieces.add((subject.removeprefix(SCENE), object_.removeprefix(SCENE)))
    return RobotFile(document.iri.rpartition("/")[2], document.iri, individuals, frozenset(pieces))

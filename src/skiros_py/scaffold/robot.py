"""The available robots, and a new one: individuals of a mobile manipulator, with names and limits of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from skiros_py.errors import UnknownName, UsageError
from skiros_py.plugins.installation import installation
from skiros_py.plugins.plugin import PluginFault
from skiros_py.ports.kinematics import GROUP
from skiros_py.scaffold.declared import module_name, sentence, words_of
from skiros_py.scaffold.draft import Draft, render
from skiros_py.scaffold.project import Knowledge
from skiros_py.world.names import SCENE, STANDARD_PREFIXES
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document
from skiros_py.world.scene.files import documents_of
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


_LIMITS = {
    "max-linear": 0.8,
    "max-angular": 1.2,
    "max-linear-acceleration": 0.5,
    "max-angular-acceleration": 1.5,
    "max-gap": 0.08,
    "max-force": 60.0,
}
"""Limits [m/s, rad/s, m/s², rad/s², m, N] of the robot that is taken as a pattern."""


@dataclass(frozen=True, slots=True)
class NewRobot:
    """The author's options for a robot.

    Attributes:
        name: Its name ("loader"); its individuals are called after it ("loader_arm").
        help: One sentence; derived from the name if omitted.
        start: Id of its location at the start of a run.
        limits: ``NAME=VALUE`` ("max-linear=0.5").
        model: Name of a robot model that drivers can build.
    """

    name: str
    help: str = ""
    start: str = "unknown_location"
    limits: tuple[str, ...] = ()
    model: str = "mobile_panda"


def draft_robot(known: Knowledge, said: NewRobot) -> Draft:
    """Writes a robot's individuals and a test that a scene with it comes up; and the entry point for all robots.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = module_name(said.name, "robot")
    _check_free(known, name)
    start = module_name(said.start, "--start")
    package = known.project.package
    values = {"name": name, "label": words_of(name), "iri": f"https://example.org/{package}/robots/{name}"}
    new = {
        f"src/{package}/robots/{name}.ttl": render(
            "robot.ttl",
            **values,
            help=sentence(said.help or f"The mobile manipulator {words_of(name)}", "--help-text"),
            start=start,
            model=module_name(said.model, "--model"),
            limits=_limits(said.limits),
        ),
        f"tests/robots/test_{name}.py": render("robot_test.py", **values, start=start),
    }
    project = known.project
    if not project.entry_points.get("skiros.robots"):
        project = project.with_entries("skiros.robots", {package: package})
    return Draft(project.root, new, project.changes(known.project))


def _check_free(known: Knowledge, name: str) -> None:
    try:
        find_robot(name, known.ontology)
    except UnknownName:
        return
    raise UsageError(f"there is a robot '{name}' already; choose another name")


def _limits(said: tuple[str, ...]) -> dict[str, float]:
    limits = dict(_LIMITS)
    for text in said:
        key, _, value = text.partition("=")
        if key not in limits:
            raise UnknownName("limit", key, _LIMITS)
        try:
            limits[key] = float(value)
        except ValueError:
            limits[key] = math.nan
        if not 0.0 < limits[key] < 1000.0:
            raise UsageError(f"--limit {text}: a number above 0 and below 1000")
    return {key.replace("-", "_"): value for key, value in limits.items()}

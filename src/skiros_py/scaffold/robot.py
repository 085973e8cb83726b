"""The available robots, and a new one: individuals of a mobile manipulator, with names and limits of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator

from skiros_py.errors import UnknownName, UsageError
from skiros_py.plugins.installation import installation
from skiros_py.plugins.plugin import PluginFault
from skiros_py.ports.kinematics import GROUP
from skiros_py.scaffold.declared import module_name, sentence, words_of
from skiros_py.scaffold.draft import Draft, render
from skiros_py.scaffold.orders import NewRobot
from skiros_py.scaffold.project import Knowledge
from skiros_py.world.names import STANDARD_PREFIXES
from skiros_py.world.ontology import Ontology
from skiros_py.world.ontology.documents import Document
from skiros_py.world.scene.files import documents_of
from skiros_py.world.vocabulary import ROBOT

_TYPE = STANDARD_PREFIXES["rdf"] + "type"


def robot_iris(ontology: Ontology) -> dict[str, str]:
    """Returns the IRIs that scenes import for the shipped robots and those of plug-ins, by their last part."""
    robot = ontology.names.iri(ROBOT)
    return {
        document.iri.rpartition("/")[2]: document.iri
        for document in (*ontology.sources, *_of_plugins())
        if any(t.predicate.value == _TYPE and getattr(t.object, "value", "") == robot for t in document.triples)
    }


def _of_plugins() -> Iterator[Document]:
    for entry in installation().of(GROUP):
        yield from (found for found in documents_of(entry) if not isinstance(found, PluginFault))


_LIMITS = {
    "max-linear": 0.8,
    "max-angular": 1.2,
    "max-linear-acceleration": 0.5,
    "max-angular-acceleration": 1.5,
    "max-gap": 0.08,
    "max-force": 60.0,
}
"""Limits [m/s, rad/s, m/s², rad/s², m, N] of the robot that is taken as a pattern."""


def draft_robot(known: Knowledge, said: NewRobot) -> Draft:
    """Writes a robot's individuals and a test that a scene with it comes up; and the entry point for all robots.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = module_name(said.name, "robot")
    if name in robot_iris(known.ontology):
        raise UsageError(f"there is a robot '{name}' already; choose another name")
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
    return known.project.with_folder("robots").draft(new, known.project)


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

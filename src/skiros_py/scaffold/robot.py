"""Writes a robot: the individuals of a mobile manipulator, with names and limits of its own."""

from __future__ import annotations

import math
from dataclasses import dataclass

from skiros_py.errors import UnknownName, UsageError
from skiros_py.scaffold.draft import Draft
from skiros_py.scaffold.knowledge import Knowledge
from skiros_py.scaffold.rendering import render
from skiros_py.scaffold.robots import find_robot
from skiros_py.scaffold.spelling import module_name, sentence, words_of

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

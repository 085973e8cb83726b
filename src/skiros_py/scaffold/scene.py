"""Writes a scene: a robot, things, and a goal."""

from __future__ import annotations

from dataclasses import dataclass, replace

from skiros_py.config import scene_names
from skiros_py.errors import DescriptionError, UsageError
from skiros_py.scaffold.declared import Declared, Wanted, module_name, read_parameter, read_wanted, sentence, words_of
from skiros_py.scaffold.draft import Draft, render
from skiros_py.scaffold.project import Knowledge
from skiros_py.scaffold.robot import find_robot
from skiros_py.scaffold.stage import Stage, tried


@dataclass(frozen=True, slots=True)
class NewScene:
    """The author's options for a scene.

    Attributes:
        name: Its name ("scan_cell").
        help: One sentence; derived from the name if omitted.
        robot: Name of its robot.
        things: Further elements (``part:sk:Manipulatable``): each becomes one individual, "part_1".
        goals: Conditions over the things and the robot's individuals (``Scanned(part)``, ``Scanned(part_1)``).
    """

    name: str
    help: str = ""
    robot: str = "mobile_panda"
    things: tuple[str, ...] = ()
    goals: tuple[str, ...] = ()


def draft_scene(known: Knowledge, said: NewScene) -> Draft:
    """Writes a scene and a test that it is valid; and the entry point for all scenes of the package.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = module_name(said.name, "scene")
    if name in scene_names():
        raise UsageError(f"there is a scene '{name}' already; choose another name")
    things = [read_parameter(text, known.ontology) for text in said.things or ("station:sk:Station",)]
    stage = Stage(known.ontology, name, find_robot(said.robot, known.ontology))
    cast = {thing.key: _added(stage, thing) for thing in things}
    stage.goals += [str(_meant(known, read_wanted(text), cast)) for text in said.goals]
    text = stage.turtle(sentence(said.help or words_of(name), "--help-text"))
    tried(known, text, f"scene '{name}'")
    package = known.project.package
    new = {
        f"src/{package}/scenes/{name}.ttl": text,
        f"tests/scenes/test_{name}.py": render("scene_test.py", name=name, package=package, goals=len(stage.goals)),
    }
    project = known.project
    if not project.entry_points.get("skiros.scenes"):
        project = project.with_entries("skiros.scenes", {package: package})
    return Draft(project.root, new, project.changes(known.project))


def _added(stage: Stage, thing: Declared) -> str:
    if not thing.is_element:
        raise UsageError(f"--thing {thing.key}: it must be of a class, not a {thing.type}")
    return stage.add(thing.type, thing.key)


def _meant(known: Knowledge, wanted: Wanted, cast: dict[str, str]) -> Wanted:
    """Checks a goal, and replaces the things in it by their individuals."""
    try:
        known.condition(wanted.word)(*wanted.arguments)
    except DescriptionError as error:
        raise UsageError(f"--goal {wanted}: {error}") from error
    return replace(wanted, arguments=tuple(cast.get(argument, argument) for argument in wanted.arguments))

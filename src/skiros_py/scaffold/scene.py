"""Writes a scene: a robot, things, and a goal."""

from __future__ import annotations

from skiros_py.config import scene_names
from skiros_py.errors import UsageError
from skiros_py.scaffold.declared import module_name, read_parameter, sentence, words_of
from skiros_py.scaffold.draft import Draft, render
from skiros_py.scaffold.orders import NewScene
from skiros_py.scaffold.project import Knowledge
from skiros_py.scaffold.stage import Stage
from skiros_py.tasks.goals import parse_goal


def draft_scene(known: Knowledge, said: NewScene) -> Draft:
    """Writes a scene and a test that it is valid; and the entry point for all scenes of the package.

    Raises:
        UsageError: An option is not valid; the text explains what would be.
    """
    name = module_name(said.name, "scene")
    if name in scene_names():
        raise UsageError(f"there is a scene '{name}' already; choose another name")
    stage = Stage(known, name, said.robot)
    cast = {}
    for text in said.things or ("station:sk:Station",):
        thing = read_parameter(text, known.ontology)
        if not thing.is_element:
            raise UsageError(f"--thing {thing.key}: it must be of a class, not a {thing.type}")
        cast[thing.key] = stage.add(thing.element_class, thing.key)
    stage.goals += [str(known.read_condition(text, "--goal").bind(cast)) for text in said.goals]
    parse_goal(stage.goals, stage.world, known.catalogue.conditions)
    package = known.project.package
    new = {
        f"src/{package}/scenes/{name}.ttl": stage.turtle(sentence(said.help or words_of(name), "--help-text")),
        f"tests/scenes/test_{name}.py": render("scene_test.py", name=name, package=package, goals=len(stage.goals)),
    }
    return known.project.with_folder("scenes").draft(new, known.project)

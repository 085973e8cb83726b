"""Tests a scene before it is written: loads it, and parses its goal."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from skiros_py.config import ontology_paths
from skiros_py.errors import FileError, UsageError
from skiros_py.scaffold.knowledge import Knowledge
from skiros_py.scaffold.stage import Stage
from skiros_py.skills.conditions import Condition
from skiros_py.tasks.goals import parse_goal
from skiros_py.world.reasoners.plugins import load_reasoners
from skiros_py.world.scene import load_scene
from skiros_py.world.world import World


def tried(known: Knowledge, text: str, what: str) -> World:
    """Loads a scene from its text.

    Raises:
        UsageError: It cannot be loaded, or its goal refers to missing elements.
    """
    reasoners, _ = load_reasoners(known.ontology)
    with tempfile.TemporaryDirectory(prefix="skiros-new-") as folder:
        file = Path(folder) / "scene.ttl"
        file.write_text(text, encoding="utf-8")
        try:
            world = load_scene(known.ontology, file, ontology_paths(), reasoners=reasoners)
            parse_goal(world.goals, world, known.catalogue.conditions)
        except FileError as error:
            raise UsageError(f"{what}: {error.reason}") from error
    return world


def open_questions(
    world: World, stage: Stage, conditions: Mapping[str, Condition], cast: Mapping[str, str]
) -> Iterator[str]:
    """Yields the required facts that do not hold in a scene, with reasons, except where its robot drives itself."""
    for said, condition in conditions.items():
        about = {cast[argument] for argument in condition.arguments}
        by_itself = any({robot, place} <= about for robot, _, place in stage.left_to_robot)
        verdict = condition.evaluate(world, cast)
        if not verdict.holds and not by_itself:
            yield f"{said} ({verdict.lines()[-1].strip()})"

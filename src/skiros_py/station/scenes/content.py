"""What of a world is its scene: all but what skill managers write about themselves each time they come."""

from __future__ import annotations

from collections.abc import Iterator

from skiros_py.world.change import Edit, ElementEdit
from skiros_py.world.index import Index
from skiros_py.world.scene import diff
from skiros_py.world.vocabulary import HAS_PRIMITIVE, HAS_SKILL, PRIMITIVE, SKILL
from skiros_py.world.workspace import Workspace

_KINDS = ((SKILL, HAS_SKILL), (PRIMITIVE, HAS_PRIMITIVE))


def scene_only(world: Index) -> Index:
    """Returns a state without the modules that skill managers offer."""
    work = Workspace(world)
    for module, _ in _modules(world):
        work.erase(module)
    return work.view


def changes_to(scene: Index, world: Index) -> tuple[Edit, ...]:
    """Returns the edits that make a scene of a world's present one.

    What skill managers have written stays where their subsystems do, so that they find it when they come again.
    """
    gone = [module for module, agent in _modules(world) if agent is None or not scene.has(agent)]
    leaving = tuple(ElementEdit(module, world.element(module), None) for module in gone)
    return *leaving, *diff(scene_only(world), scene_only(scene))


def _modules(world: Index) -> Iterator[tuple[str, str | None]]:
    """Yields the modules, each with the subsystem that offers it."""
    for class_, relation in _KINDS:
        for module in world.instances(class_):
            yield module, next(iter(world.subjects(relation, module)), None)

"""The scene within a world: everything except the modules that skill managers write each time they start."""

from __future__ import annotations

from collections.abc import Iterator

from skiros_py.world.change import Edit, ElementEdit
from skiros_py.world.index import Index
from skiros_py.world.scene import diff
from skiros_py.world.vocabulary import HAS_PRIMITIVE, HAS_SKILL, PRIMITIVE, SKILL
from skiros_py.world.workspace import Workspace

_KINDS = ((SKILL, HAS_SKILL), (PRIMITIVE, HAS_PRIMITIVE))


def scene_only(world: Index) -> Index:
    """Returns a state without the modules of skill managers."""
    work = Workspace(world)
    for module, _ in _modules(world):
        work.erase(module)
    return work.view


def changes_to(scene: Index, world: Index) -> tuple[Edit, ...]:
    """Returns the edits that turn a world's present scene into another one.

    The modules of skill managers are kept together with their subsystems, so that the managers find them when they
    start again.
    """
    gone = [module for module, agent in _modules(world) if agent is None or not scene.has(agent)]
    leaving = tuple(ElementEdit(module, world.element(module), None) for module in gone)
    return *leaving, *diff(scene_only(world), scene_only(scene))


def _modules(world: Index) -> Iterator[tuple[str, str | None]]:
    """Yields the modules, each with the subsystem that offers it."""
    for class_, relation in _KINDS:
        for module in world.instances(class_):
            yield module, next(iter(world.subjects(relation, module)), None)

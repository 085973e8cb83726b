"""The parts a job has moved, from the world changes to elements its steps name."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from skiros_py.tasks.jobs.job import Intent, Job, MaterialActual
from skiros_py.world.change import PlacementEdit
from skiros_py.world.element import Placement
from skiros_py.world.index import Index
from skiros_py.world.vocabulary import MANIPULATABLE
from skiros_py.world.world import World


def moved(world: World, job: Job, intents: Iterable[Intent]) -> tuple[MaterialActual, ...]:
    """Returns the parts a job has moved so far: those already recorded, and the changes since :attr:`Job.seen`.

    Only parts that one of its own steps names count, since other jobs may run concurrently. Parts back at their
    original place are left out.

    Args:
        world: The live world model.
        job: The job.
        intents: The steps that were started for it.
    """
    if job.seen is None:
        return job.materials
    now = world.snapshot()
    named = {name for intent in intents for name in intent.arguments.values() if _may_be_part(now, name)}
    said = {material.element: material for material in job.materials}
    moves = {part: (material.origin, material.place) for part, material in said.items()}
    for edit in _placements(world, named, job.seen):
        origin = moves[edit.element][0] if edit.element in moves else _place(edit.old)
        moves[edit.element] = origin, _place(edit.new)
    away = {part: ends for part, ends in sorted(moves.items()) if ends[0] != ends[1]}
    return tuple(_actual(now, part, ends, said.get(part)) for part, ends in away.items())


def _placements(world: World, named: Collection[str], after: int) -> Iterator[PlacementEdit]:
    for change in world.log.about(named, after):
        for edit in change.edits:
            if isinstance(edit, PlacementEdit) and edit.element in named:
                yield edit


def _may_be_part(now: Index, name: str) -> bool:
    """Returns True for parts and for removed elements, which may have been parts."""
    return not now.has(name) or now.ontology.is_a(now.element(name).type, MANIPULATABLE)


def _place(placement: Placement | None) -> str:
    return "" if placement is None else placement.place


def _actual(now: Index, part: str, ends: tuple[str, str], said: MaterialActual | None) -> MaterialActual:
    origin, place = ends
    if now.has(part):
        element = now.element(part)
        return MaterialActual(element=part, class_=element.type, label=element.label, origin=origin, place=place)
    class_, label = (said.class_, said.label) if said else ("", part)
    return MaterialActual(element=part, class_=class_, label=label, origin=origin, place=place)

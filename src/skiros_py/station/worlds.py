"""Worlds: opened from a scene or a data directory, with the ontologies and reasoners of plug-ins."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from skiros_py.config import find_scene, ontology_paths
from skiros_py.plugins.plugin import PluginFault, by_cause
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.registry import Reasoners, load_reasoners
from skiros_py.world.scene.files import load_scene, scene_source
from skiros_py.world.world import World

if TYPE_CHECKING:
    from skiros_py.world.journal.data_directory import DataDirectory

_log = logging.getLogger(__name__)


def why_not_loaded(data: Path, world: World, scene: str) -> str:
    """Returns why a scene was not loaded when a data directory that has a world was opened; empty if it is that world.

    Args:
        data: The data directory.
        world: Its world.
        scene: Name or path of the scene.
    """
    source, present = scene_source(find_scene(scene)), world.snapshot().source
    if present.name != source.name:
        return f"in {data} lives {present.name or 'another one, of no name'}: {scene} was not loaded"
    if present != source:
        return f"in {data} lives an earlier version of {scene}, whose file was changed since: it was not loaded again"
    return ""


def warn(faults: Sequence[PluginFault]) -> None:
    """Logs the faults of plug-ins, once per cause."""
    for fault in by_cause(faults):
        _log.warning("%s", fault)


Report = Callable[[Sequence[PluginFault]], object]
"""Receives the faults of plug-ins that do not load."""


def open_world(scene: str, report: Report = warn) -> World:
    """Loads the ontology and a scene, with the ontologies and reasoners of plug-ins; no robots, no physics.

    Args:
        scene: Name or path of the scene.
        report: Receives the faults of plug-ins that do not load; those are skipped.

    Raises:
        UnknownName: No such scene.
        FileError: A file cannot be read or parsed.
    """
    path = find_scene(scene)
    ontology, reasoners = _installed(report)
    return load_scene(ontology, path, ontology_paths(), reasoners=reasoners)


def open_data(
    path: str | Path, scene: str | None = None, *, create: bool = True, report: Report = warn
) -> DataDirectory:
    """Opens a data directory, in which a world outlives its process. Close it, or use it in a ``with``.

    Args:
        path: The folder; created if it is missing.
        scene: Name or path of the initial scene of a new directory.
        create: False to refuse a folder without a world.
        report: Receives the faults of plug-ins that do not load; those are skipped.

    Raises:
        UnknownName: No such scene.
        FileError: Another process uses the folder, it cannot be read or written, or a file is broken.
    """
    from skiros_py.world.journal.data_directory import DataDirectory  # most runs store nothing

    file = find_scene(scene) if scene else None
    ontology, reasoners = _installed(report)
    return DataDirectory.open(Path(path), ontology, reasoners, file, imports=ontology_paths(), create=create)


def _installed(report: Report) -> tuple[Ontology, Reasoners]:
    """Loads the ontologies and reasoners of plug-ins."""
    ontology, misfits = load_installed(ontology_paths())
    reasoners, unusable = load_reasoners(ontology)
    report((*unusable, *misfits))
    return ontology, reasoners

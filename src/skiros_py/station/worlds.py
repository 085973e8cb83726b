"""Worlds: opened from a scene or a data directory, with the ontologies and reasoners of plug-ins."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from skiros_py.config import find_scene, ontology_paths
from skiros_py.plugins.plugin import PluginFault, by_cause
from skiros_py.world.ontology import Ontology, load_installed
from skiros_py.world.reasoners.registry import Reasoners, load_reasoners
from skiros_py.world.scene import load_scene, scene_source
from skiros_py.world.world import World

if TYPE_CHECKING:
    from skiros_py.world.journal import DataDirectory

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


def open_world(scene: str) -> World:
    """Loads the ontology and a scene, with the ontologies and reasoners of plug-ins; no robots, no physics.

    A plug-in that does not load is skipped, and logged as a warning.

    Raises:
        UnknownName: No such scene.
        FileError: A file cannot be read or parsed.
    """
    world, faults = load_world(scene)
    warn(faults)
    return world


def load_world(scene: str) -> tuple[World, tuple[PluginFault, ...]]:
    """Loads a scene, and the faults of plug-ins that do not load; see :func:`open_world`."""
    path = find_scene(scene)
    ontology, reasoners, faults = _installed()
    return load_scene(ontology, path, ontology_paths(), reasoners=reasoners), faults


def open_data(path: str | Path, scene: str | None = None, *, create: bool = True) -> DataDirectory:
    """Opens a data directory, in which a world outlives its process. Close it, or use it in a ``with``.

    A plug-in that does not load is skipped, and logged as a warning.

    Args:
        path: The folder; created if it is missing.
        scene: Name or path of the initial scene of a new directory.
        create: False to refuse a folder without a world.

    Raises:
        UnknownName: No such scene.
        FileError: Another process uses the folder, it cannot be read or written, or a file is broken.
    """
    directory, faults = open_directory(Path(path), scene, create=create)
    warn(faults)
    return directory


def open_directory(
    path: Path, scene: str | None, *, create: bool = True
) -> tuple[DataDirectory, tuple[PluginFault, ...]]:
    """Opens a data directory, and returns the faults of plug-ins that do not load; see :func:`open_data`."""
    from skiros_py.world.journal import DataDirectory  # most runs store nothing

    file = find_scene(scene) if scene else None
    ontology, reasoners, faults = _installed()
    return DataDirectory.open(path, ontology, reasoners, file, imports=ontology_paths(), create=create), faults


def warn(faults: Sequence[PluginFault]) -> None:
    """Logs the faults of plug-ins, once per cause."""
    for fault in by_cause(faults):
        _log.warning("%s", fault)


def _installed() -> tuple[Ontology, Reasoners, tuple[PluginFault, ...]]:
    """Loads the ontologies and reasoners of plug-ins, and returns the faults of those that do not load."""
    ontology, misfits = load_installed(ontology_paths())
    reasoners, unusable = load_reasoners(ontology)
    return ontology, reasoners, (*unusable, *misfits)

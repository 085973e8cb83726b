"""The worlds that contract tests start from: the scenes at hand."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import partial
from pathlib import Path

from skiros_py.checking.cases import Ground
from skiros_py.config import find_scene, ontology_paths, scene_names
from skiros_py.errors import SkirosError
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.scene import load_scene
from skiros_py.world.world import World


def scene_grounds(ontology: Ontology, reasoners: Reasoners, first: Collection[str] = ()) -> tuple[Ground, ...]:
    """Returns all scenes, those of the given names first."""
    names = sorted(scene_names(), key=lambda name: (name not in first, name))
    return tuple(_grounds(names, ontology, reasoners))


def _grounds(names: Collection[str], ontology: Ontology, reasoners: Reasoners) -> Iterator[Ground]:
    for name in names:
        try:
            yield Ground(name, partial(_open, ontology, find_scene(name), reasoners))
        except SkirosError:
            continue  # a broken scene of a plug-in is reported as such


def _open(ontology: Ontology, file: Path, reasoners: Reasoners) -> World:
    return load_scene(ontology, file, ontology_paths(), reasoners=reasoners)

"""Where ontologies and scenes are found."""

from __future__ import annotations

import os
from pathlib import Path

from skiros_py.errors import FileError, UnknownName

__all__ = ["find_scene", "ontology_paths", "scene_names"]

_PACKAGE = Path(__file__).parent


def ontology_paths() -> tuple[Path, ...]:
    """Returns the folders whose Turtle files make the ontology; ``SKIROS_ONTOLOGIES`` adds more, separated by ':'."""
    return (_folder("ontologies"), *_from_environment("SKIROS_ONTOLOGIES"))


def scene_paths() -> tuple[Path, ...]:
    """Returns the folders with scenes; ``SKIROS_SCENES`` adds more, separated by ':'."""
    return (*_from_environment("SKIROS_SCENES"), _folder("scenes"))


def scene_names() -> tuple[str, ...]:
    """Returns the names of all scenes."""
    return tuple(sorted({file.stem for folder in scene_paths() for file in folder.glob("*.ttl")}))


def find_scene(name: str) -> Path:
    """Returns the file of a scene, given by name or by path.

    Raises:
        UnknownName: There is no scene of that name.
        FileError: There is no such file.
    """
    if name.endswith(".ttl"):
        if Path(name).is_file():
            return Path(name)
        what = "is a folder" if Path(name).is_dir() else "does not exist"
        raise FileError(Path(name), f"the scene file {what}; scenes known by name: {', '.join(scene_names())}")
    for folder in scene_paths():
        if (folder / f"{name}.ttl").is_file():
            return folder / f"{name}.ttl"
    raise UnknownName("scene", name, scene_names())


def _folder(name: str) -> Path:
    """Returns a data folder: inside the installed package, or beside ``src`` in a checkout."""
    installed = _PACKAGE / "data" / name
    return installed if installed.is_dir() else _PACKAGE.parents[1] / name


def _from_environment(variable: str) -> tuple[Path, ...]:
    return tuple(Path(part) for part in os.environ.get(variable, "").split(":") if part)

"""The available scenes: those installed with packages, and those saved in the data directory."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from skiros_py.api.scenes import SCENE_NAME
from skiros_py.config import named_scene, scene_names
from skiros_py.errors import FileError, Refused, StaleVersion, UnknownName, UsageError
from skiros_py.messages import Message
from skiros_py.station.requests import Seen, require_seen
from skiros_py.world.change import Edit, ElementEdit, SourceEdit
from skiros_py.world.index import Index
from skiros_py.world.journal.data_directory import make_folder
from skiros_py.world.scene.files import diff, scene_source, write_atomically
from skiros_py.world.scene.writer import scene_turtle
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
    """Returns the edits that turn a world's current scene into another one.

    The modules of skill managers are kept together with their subsystems, so that the managers find them when they
    start again.
    """
    gone = [module for module, agent in _modules(world) if agent is None or not scene.has(agent)]
    leaving = tuple(ElementEdit(module, world.element(module), None) for module in gone)
    return SourceEdit(world.source, scene.source), *leaving, *diff(scene_only(world), scene_only(scene))


def _modules(world: Index) -> Iterator[tuple[str, str | None]]:
    """Yields the modules, each with the subsystem that offers it."""
    for class_, relation in _KINDS:
        for module in world.instances(class_):
            yield module, next(iter(world.subjects(relation, module)), None)


_NAME = re.compile(SCENE_NAME)
_SUFFIX = ".ttl"


@dataclass(frozen=True, slots=True)
class SceneFile:
    """The file of a scene.

    Attributes:
        name: Name of the scene.
        path: Its path.
        saved: True if it is in the data directory, False if it was installed with a package.
    """

    name: str
    path: Path
    saved: bool

    @property
    def version(self) -> int:
        """A number that changes with the content of the file.

        Raises:
            FileError: It cannot be read.
        """
        return scene_source(self.path).checksum

    @property
    def written(self) -> datetime | None:
        """When it was saved; None for an installed scene, or one deleted meanwhile."""
        try:
            return datetime.fromtimestamp(self.path.stat().st_mtime, UTC) if self.saved else None
        except OSError:
            return None


class SceneStore:
    """The scenes of a server; thread-safe.

    Args:
        folder: Folder of saved scenes; created with the first one.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._writing = threading.Lock()

    def names(self) -> list[str]:
        """Returns the names of all scenes, sorted."""
        return sorted({*self._saved(), *scene_names()})

    def find(self, name: str) -> SceneFile:
        """Returns the file of a scene; a saved scene takes precedence over one installed later under the same name.

        Raises:
            UnknownName: There is no scene of that name.
            UsageError: The name is not valid, or the plug-in that provides it is broken.
            FileError: It is a symbolic link to a file elsewhere.
        """
        path = self._path(name) if _NAME.fullmatch(name) else None
        if path is not None and _is_plain(path):
            return SceneFile(name, path, saved=True)
        try:
            return SceneFile(name, named_scene(name), saved=False)
        except UnknownName:
            raise UnknownName("scene", name, self.names()) from None

    def save(self, name: str, scene: Index, seen: Seen | None = None) -> SceneFile:
        """Saves a state as a scene, atomically.

        Args:
            name: Name of the scene.
            scene: The state.
            seen: The version of the saved scene that it replaces; None for a new scene.

        Raises:
            UsageError: The name is not valid.
            Refused: It is an installed scene, or there is a scene of this name, and its version is not given.
            StaleVersion: The version of the saved scene is another one, or it was removed.
            FileError: It cannot be written.
        """
        if not _NAME.fullmatch(name):
            raise UsageError(Message("a scene is saved under small letters, digits, '_' and '-', 64 at most"))
        text = scene_turtle(scene_only(scene))
        with self._writing:
            try:
                file = self.find(name)
            except UnknownName:
                if seen is not None and seen.version is not None:
                    raise StaleVersion(
                        Message("there is no scene '{name}' any more: it was removed since", name=name)
                    ) from None
            except FileError as error:
                raise Refused(
                    "SceneBroken",
                    Message("{name} is broken, nothing was changed: {reason}", name=name, reason=error.reason),
                ) from None
            else:
                if not file.saved:
                    text = Message("'{name}' is a scene that came with a package: choose another name", name=name)
                    raise Refused("SceneInstalled", text)
                require_seen(seen, file.version)
            make_folder(self._folder)
            path = self._path(name)
            write_atomically(path, text, private=True)
        return SceneFile(name, path, saved=True)

    def remove(self, name: str, seen: Seen | None = None) -> None:
        """Removes a saved scene.

        Raises:
            UnknownName: There is none with this name.
            Refused: It is an installed scene.
            StaleVersion: The current version is not the one seen.
        """
        with self._writing:
            file = self.find(name)
            if not file.saved:
                raise Refused("SceneInstalled", Message("scene '{name}' came with a package, and stays", name=name))
            if seen is not None:
                require_seen(seen, file.version)
            file.path.unlink(missing_ok=True)

    def _saved(self) -> Iterator[str]:
        files = sorted(self._folder.glob(f"*{_SUFFIX}")) if self._folder.is_dir() else []
        yield from (file.stem for file in files if _NAME.fullmatch(file.stem) and _is_plain(file))

    def _path(self, name: str) -> Path:
        """Returns the path at which a scene is saved, which is always inside the folder."""
        path = self._folder / f"{name}{_SUFFIX}"
        if path.is_symlink() or not path.resolve().is_relative_to(self._folder.parent.resolve()):
            raise FileError(path, "is a symbolic link: scenes are saved as files of their own")
        return path


def _is_plain(path: Path) -> bool:
    return path.is_file() and not path.is_symlink()

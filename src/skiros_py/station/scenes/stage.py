"""Reads scenes beside the live world, so that a broken or unusable scene changes nothing."""

from __future__ import annotations

import tempfile
import threading
from collections import OrderedDict
from pathlib import Path

from skiros_py.config import ontology_paths
from skiros_py.errors import DescriptionError, FileError, UsageError
from skiros_py.station.scenes.content import scene_only
from skiros_py.station.scenes.loading import check_scene
from skiros_py.station.scenes.scenes import SceneFile
from skiros_py.station.session import Session
from skiros_py.tasks.goals import parse_goal
from skiros_py.world.change import Edit
from skiros_py.world.index import Index
from skiros_py.world.names import SCENE, STANDARD_PREFIXES
from skiros_py.world.ontology.documents import read_document
from skiros_py.world.scene import diff, load_scene
from skiros_py.world.world import World

_KEPT = 8
"""Number of scenes cached after reading, for frequent requests."""
_THIS, _LABEL = SCENE + "this", STANDARD_PREFIXES["rdfs"] + "label"


class SceneStage:
    """Reads scenes, one at a time, because reading takes interpreter time from the control cycle."""

    def __init__(self) -> None:
        self._reading = threading.Lock()
        self._known: OrderedDict[tuple[int, Path, int], tuple[Session, Index]] = OrderedDict()
        self._compared: tuple[tuple[object, ...], tuple[Edit, ...]] | None = None

    def read(self, session: Session, file: SceneFile) -> Index:
        """Returns the content of a scene file.

        Args:
            session: Provides the ontology and the reasoners.
            file: The file.

        Raises:
            FileError: It is broken; the error contains the line if known.
        """
        key = (id(session), file.path, file.version)
        with self._reading:
            if key not in self._known:
                self._known[key] = session, _read(session, file.path)
                while len(self._known) > _KEPT:
                    self._known.popitem(last=False)
            self._known.move_to_end(key)
            return self._known[key][1]

    def read_text(self, session: Session, text: bytes) -> Index:
        """Returns the content of a scene sent as Turtle; no imports are fetched from the network.

        Raises:
            FileError: It is broken; the error contains the line if known.
        """
        with self._reading, tempfile.TemporaryDirectory(prefix="skiros-scene-") as folder:
            path = Path(folder) / "scene.ttl"
            path.write_bytes(text)
            return _read(session, path)

    def check(self, session: Session, scene: Index) -> None:
        """Checks whether a session could be opened in a scene.

        Raises:
            UsageError: It has no usable robot, invalid goals, or incomplete descriptions of robots or bodies.
        """
        try:
            parse_goal(scene.goals, scene, session.catalogue.conditions)
            check_scene(session, scene)
        except DescriptionError as error:
            raise UsageError(f"the station cannot be brought up in that scene: {error}") from error

    def compare(self, session: Session, file: SceneFile) -> tuple[int, tuple[Edit, ...]]:
        """Returns the version of the world, and the edits that turn the scene into it.

        Raises:
            FileError: The scene is broken.
        """
        version, now = session.world.state()
        key = (id(session), version, file.path, file.version)
        known = self._compared
        if known is None or known[0] != key:
            known = self._compared = key, diff(scene_only(self.read(session, file)), scene_only(now))
        return version, known[1]

    def forget(self, session: Session) -> None:
        """Clears the cache of a session."""
        with self._reading:
            for key in [key for key, (owner, _) in self._known.items() if owner is session]:
                del self._known[key]
            self._compared = None

    @staticmethod
    def title(file: SceneFile) -> str:
        """Returns the title of a scene; its name if it has none, or cannot be read.

        Raises:
            FileError: It is broken.
        """
        said = [t for t in read_document(file.path).triples if t.predicate.value == _LABEL]
        titles = (getattr(t.object, "value", "") for t in said if getattr(t.subject, "value", "") == _THIS)
        return str(next(titles, file.name))


def _read(session: Session, path: Path) -> Index:
    world: World = load_scene(session.world.ontology, path, ontology_paths(), reasoners=session.world.reasoners)
    return world.snapshot()


def shown(error: FileError) -> str:
    """Returns the fault of a scene without the path of its file, which is private."""
    where = f"line {error.line}: " if error.line else ""
    return where + error.reason.replace(str(error.path.parent), "…")

"""Use cases: the available scenes, and the current one."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skiros_py.api.scenes import CurrentScene, Scene, SceneDifference, SceneEntry, SceneRobot, Scenes
from skiros_py.config import ontology_paths
from skiros_py.errors import DescriptionError, FileError, Refused, UsageError
from skiros_py.messages import Message
from skiros_py.station.requests import ANY_VERSION, LIBRARY, Author, Seen, Sent, Service, addressed, require_seen
from skiros_py.station.scenes.loading import check_scene, load, require_rest, shown
from skiros_py.station.scenes.scenes import SceneFile, scene_only
from skiros_py.station.session import Session
from skiros_py.tasks.goals import parse_goal
from skiros_py.world.change import Edit, SceneSource, Writer
from skiros_py.world.element import is_learned
from skiros_py.world.index import Index
from skiros_py.world.names import SCENE, STANDARD_PREFIXES
from skiros_py.world.ontology.documents import read_document
from skiros_py.world.scene.files import describe, diff, load_scene, scene_source
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.vocabulary import ELEMENT, ROBOT

if TYPE_CHECKING:
    from skiros_py.station.station import Station

_UNKNOWN = "UnknownScene"
_KEPT = 8
"""Number of scenes cached after reading, for frequent requests."""
_THIS, _LABEL = SCENE + "this", STANDARD_PREFIXES["rdfs"] + "label"


class SceneService(Service):
    """Saves, loads and compares scenes. It reads one at a time: reading takes interpreter time from the control cycle.

    Args:
        station: The station.
    """

    def __init__(self, station: Station) -> None:
        super().__init__(station)
        self._reading = threading.Lock()
        self._cached = lru_cache(_KEPT)(lambda session, path, _version: _read(session, path))
        self._compared: tuple[tuple[object, ...], tuple[Edit, ...]] | None = None

    def open(self, session: Session) -> None:
        """Keeps what is read for a session until that is closed."""
        session.on_close(self._forget)

    def _forget(self) -> None:
        with self._reading:
            self._cached.cache_clear()
            self._compared = None

    # ------------------------------------------------------------------ available scenes

    def all(self, limit: int = 100, after: str = "") -> Scenes:
        """Lists installed and saved scenes, by name."""
        names = [name for name in self._station.scene_store.names() if name > after]
        page = names[:limit]
        return Scenes(items=list(self._entries(page)), next=page[-1] if len(names) > limit else None)

    def get(self, name: str) -> Scene:
        """Describes a scene without loading it.

        Raises:
            NotFound: There is none of that name.
            Refused: Its file is broken.
        """
        file = self._file(name)
        with _broken("SceneBroken", name):
            scene, title = self._read(file), _title(file)
        return Scene(
            name=name,
            source=_source(file),
            version=file.version,
            title=title,
            elements=len(scene_only(scene).instances(ELEMENT)),
            robots=_robots(scene),
            goals=list(scene.goals),
        )

    def save(self, name: str, seen: Seen | None = None) -> tuple[SceneEntry, int]:
        """Saves the current beliefs as a scene; returns its entry and its version.

        Args:
            name: Its name; a saved scene with that name is replaced if the author has seen its version.
            seen: That version.

        Raises:
            Refused: It is an installed scene, its version was not given, or the disk is full.
            StaleVersion: It was changed since it was seen.
        """
        world = self._world
        try:
            file = self._station.scene_store.save(name, world.snapshot(), seen)
        except FileError as error:
            raise Refused("NotSaved", Message("the scene is not saved: {error}", error=shown(error))) from None
        with world.transaction("server", Message("saved as scene {name}", name=name), writer=Writer.SYSTEM) as tx:
            tx.set_source(scene_source(file.path))
        return _entry(file), file.version

    def delete(self, name: str, seen: Seen | None = ANY_VERSION) -> None:
        """Deletes a saved scene.

        Raises:
            NotFound: There is none of that name.
            Refused: It is an installed scene.
            StaleVersion: It was changed since it was seen.
        """
        with addressed(_UNKNOWN), _broken("SceneBroken", name):
            self._station.scene_store.remove(name, seen)

    # ------------------------------------------------------------------ the current scene

    def current(self) -> CurrentScene:
        """Describes the current scene: which scene was loaded last, and whether it was changed since."""
        now = self._station.session.world.snapshot()
        name = now.source.name
        return CurrentScene(
            name=name,
            version=now.version,
            changed=self._is_changed(name),
            elements=len(scene_only(now).instances(ELEMENT)),
            learned=sum(map(is_learned, now.ids())),
            robots=_robots(now),
            goals=list(now.goals),
        )

    def load(
        self,
        name: str = "",
        sent: Sent | None = None,
        seen: Seen | None = ANY_VERSION,
        author: Author = LIBRARY,
    ) -> CurrentScene:
        """Loads a scene, by its name or as it was sent, keeping the concepts taught to robots.

        It is read and checked beside the current scene, which is kept if there is any fault.

        Raises:
            NotFound: There is none of that name.
            Refused: It is broken.
            StaleVersion: The world was changed since it was seen.
            WrongState: The station is not idle.
        """
        station = self._station
        session = station.session
        require_seen(seen, session.world.version)
        station.control.call(require_rest)
        if sent is None:
            with _broken("SceneBroken", name):
                scene = self._read(self._file(name))
        else:
            with _broken("SceneUnreadable", "the scene that was sent"):
                scene = self._read_sent(sent)
        try:
            parse_goal(scene.goals, scene, session.catalogue.conditions)
            check_scene(session, scene)
        except DescriptionError as error:
            raise UsageError("the station cannot be brought up in that scene: {error}", error=error) from error
        version = None if seen is None else seen.version
        load(station.control, station.data, scene, author=author.name, holder=author.holder, seen=version)
        return self.current()

    def turtle(self) -> tuple[str, int]:
        """Returns the current scene as Turtle, and the version of the world."""
        now = self._station.session.world.snapshot()
        return scene_turtle(scene_only(now)), now.version

    def difference(self, name: str, begin: int = 0, limit: int = 100) -> SceneDifference:
        """Returns the edits that turn another scene into the current one.

        Args:
            name: The other scene.
            begin: Number of edits to skip.
            limit: Maximum number of edits.

        Raises:
            NotFound: There is none of that name.
            Refused: Its file is broken.
        """
        with _broken("SceneBroken", name):
            version, edits = self._compare(self._file(name))
        page = edits[begin : begin + limit]
        return SceneDifference(
            name=name,
            version=version,
            total=len(edits),
            items=[edit.as_json() for edit in page],
            lines=list(describe(page)),
            next=str(begin + limit) if len(edits) > begin + limit else None,
        )

    # ------------------------------------------------------------------ parts

    def _is_changed(self, name: str) -> bool | None:
        try:
            return bool(self._compare(self._station.scene_store.find(name))[1])
        except (UsageError, FileError):  # uploaded, or removed since
            return None

    def _entries(self, names: list[str]) -> Iterator[SceneEntry]:
        for name in names:
            try:
                yield _entry(self._station.scene_store.find(name))
            except (UsageError, FileError):  # removed meanwhile, or its plug-in is broken, which GET /plugins reports
                continue

    def _compare(self, file: SceneFile) -> tuple[int, tuple[Edit, ...]]:
        """Returns the version of the world, and the edits that turn the scene into it.

        Raises:
            FileError: The scene is broken.
        """
        session = self._session
        now = session.world.snapshot()
        key = (id(session), now.version, file.path, file.version)
        known = self._compared
        if known is None or known[0] != key:
            known = self._compared = key, diff(scene_only(self._read(file)), scene_only(now))
        return now.version, known[1]

    def _read(self, file: SceneFile) -> Index:
        """Returns the content of a scene file.

        Raises:
            FileError: It is broken; the error contains the line if known.
        """
        with self._reading:
            return self._cached(self._session, file.path, file.version)

    def _read_sent(self, sent: Sent) -> Index:
        """Returns the content of a scene that was sent; no imports are fetched from the network.

        Raises:
            FileError: It is broken; the error contains the line if known.
        """
        with self._reading, sent.as_file("scene") as path:
            scene = _read(self._session, path).copy()
        scene.source = SceneSource()
        return scene

    def _file(self, name: str) -> SceneFile:
        with addressed(_UNKNOWN), _broken("SceneBroken", name):
            return self._station.scene_store.find(name)


def _read(session: Session, path: Path) -> Index:
    ontology, reasoners = session.world.ontology, session.world.reasoners
    return load_scene(ontology, path, ontology_paths(), reasoners=reasoners).snapshot()


def _title(file: SceneFile) -> str:
    """Returns the title of a scene; its name if it has none.

    Raises:
        FileError: It is broken.
    """
    said = [t for t in read_document(file.path).triples if t.predicate.value == _LABEL]
    titles = (getattr(t.object, "value", "") for t in said if getattr(t.subject, "value", "") == _THIS)
    return str(next(titles, file.name))


def _robots(scene: Index) -> list[SceneRobot]:
    return [SceneRobot.view_of(scene.element(id_)) for id_ in scene.instances(ROBOT)]


def _entry(file: SceneFile) -> SceneEntry:
    return SceneEntry(name=file.name, source=_source(file), saved=file.written)


def _source(file: SceneFile) -> Any:
    return "saved" if file.saved else "installed"


@contextmanager
def _broken(code: str, name: str) -> Iterator[None]:
    """Converts errors while reading a scene into refusals that name fault and location."""
    try:
        yield
    except FileError as error:
        raise Refused(
            code,
            Message("{name} is broken, nothing was changed: {error}", name=name, error=shown(error)),
            line=error.line,
        ) from None

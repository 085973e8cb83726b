"""Use cases: the available scenes, and the present one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from skiros_py.api.scenes import PresentScene, Scene, SceneDifference, SceneEntry, SceneRobot, Scenes
from skiros_py.errors import FileError, Refused, UsageError
from skiros_py.station.requests import ANY_VERSION, LIBRARY, Author, Seen, Service, addressed, require_seen
from skiros_py.station.scenes.loading import load, require_rest, shown
from skiros_py.station.scenes.scenes import SceneFile, scene_only
from skiros_py.world.change import Writer
from skiros_py.world.element import is_learned
from skiros_py.world.index import Index
from skiros_py.world.scene import describe, scene_source
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.vocabulary import ELEMENT, ROBOT

_UNKNOWN = "UnknownScene"


class SceneService(Service):
    """Saves, loads and compares scenes."""

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
        station, file = self._station, self._file(name)
        with _broken("SceneBroken", name):
            scene, title = station.stage.read(station.session, file), station.stage.title(file)
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
        """Saves the present beliefs as a scene; returns its entry and its version.

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
            raise Refused("NotSaved", f"the scene is not saved: {shown(error)}") from None
        with world.transaction("server", f"saved as scene {name}", writer=Writer.SYSTEM) as tx:
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

    # ------------------------------------------------------------------ the present scene

    def present(self) -> PresentScene:
        """Describes the present scene: which scene was loaded last, and whether it was changed since."""
        version, now = self._station.session.world.state()
        name = now.source.name
        return PresentScene(
            name=name,
            version=version,
            changed=self._is_changed(name),
            elements=len(scene_only(now).instances(ELEMENT)),
            learned=sum(map(is_learned, now.ids())),
            robots=_robots(now),
            goals=list(now.goals),
        )

    def load(
        self, name: str = "", turtle: bytes = b"", seen: Seen | None = ANY_VERSION, author: Author = LIBRARY
    ) -> PresentScene:
        """Loads a scene, by its name or as Turtle, keeping the concepts taught to robots.

        It is read and checked beside the present scene, which is kept if there is any fault.

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
        file = self._file(name) if name else None
        if file is not None:
            with _broken("SceneBroken", name):
                scene = station.stage.read(session, file)
        else:
            with _broken("SceneUnreadable", "the scene that was sent"):
                scene = station.stage.read_text(session, turtle)
        station.stage.check(session, scene)
        version = None if seen is None else seen.version
        load(station.control, station.data, scene, author=author.name, holder=author.holder, seen=version)
        return self.present()

    def turtle(self) -> tuple[str, int]:
        """Returns the present scene as Turtle, and the version of the world."""
        version, now = self._station.session.world.state()
        return scene_turtle(scene_only(now)), version

    def difference(self, name: str, begin: int = 0, limit: int = 100) -> SceneDifference:
        """Returns the edits that turn another scene into the present one.

        Args:
            name: The other scene.
            begin: Number of edits to skip.
            limit: Maximum number of edits.

        Raises:
            NotFound: There is none of that name.
            Refused: Its file is broken.
        """
        station, file = self._station, self._file(name)
        session = station.session
        with _broken("SceneBroken", name):
            version, edits = station.stage.compare(session, file)
        page = edits[begin : begin + limit]
        return SceneDifference(
            name=name,
            version=version,
            total=len(edits),
            edits=[edit.as_json() for edit in page],
            lines=list(describe(page)),
            next=str(begin + limit) if len(edits) > begin + limit else None,
        )

    # ------------------------------------------------------------------ parts

    def _is_changed(self, name: str) -> bool | None:
        station = self._station
        try:
            return bool(station.stage.compare(station.session, station.scene_store.find(name))[1])
        except (UsageError, FileError):  # uploaded, or removed since
            return None

    def _entries(self, names: list[str]) -> Iterator[SceneEntry]:
        for name in names:
            try:
                yield _entry(self._station.scene_store.find(name))
            except (UsageError, FileError):  # removed meanwhile, or its plug-in is broken, which GET /plugins reports
                continue

    def _file(self, name: str) -> SceneFile:
        with addressed(_UNKNOWN), _broken("SceneBroken", name):
            return self._station.scene_store.find(name)


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
        raise Refused(code, f"{name} is broken, nothing was changed: {shown(error)}", line=error.line) from None

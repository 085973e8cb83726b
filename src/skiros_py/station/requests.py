"""Common parts of use cases: the author of a request, the version that it is based on, and its target."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeVar

from skiros_py.errors import Busy, NotFound, Refused, StaleVersion, UnknownName
from skiros_py.files import RDF_TYPES
from skiros_py.messages import Message

if TYPE_CHECKING:
    from skiros_py.station.session import Session
    from skiros_py.station.station import Station
    from skiros_py.world.world import World

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Author:
    """The author of a request, and of the changes that it makes.

    Attributes:
        name: Name of the author.
        holder: Owner of the author's locks; distinguishes authors of the same name.
    """

    name: str
    holder: str


class Service:
    """The use cases of one topic, shared by command line, library and server.

    Args:
        station: The station.
    """

    def __init__(self, station: Station) -> None:
        self._station = station

    @property
    def _session(self) -> Session:
        return self._station.session

    @property
    def _world(self) -> World:
        return self._station.session.world

    def _call(self, work: Callable[[Session], T]) -> T:
        """Executes short work in the control thread; see :meth:`skiros_py.station.control.ControlThread.call`."""
        return self._station.control.call(work)


LIBRARY: Final = Author("python", "python")
"""The author if a Python program calls the station without naming one."""


@dataclass(frozen=True, slots=True)
class Seen:
    """The version of a resource that the author has seen.

    Attributes:
        version: The version; None for any.
    """

    version: int | None = None


ANY_VERSION: Final = Seen()
"""For requests that overwrite any version."""


def require_seen(seen: Seen | None, now: int) -> None:
    """Requires that the author has seen the current version.

    Args:
        seen: The version that the author has seen; None if not given.
        now: The current version.

    Raises:
        Refused: No version is given.
        StaleVersion: The author has seen a different version.
    """
    if seen is None:
        raise Refused(
            "VersionMissing", Message('say which version you have seen: If-Match: "{now}" is the current one', now=now)
        )
    if seen.version not in (None, now):
        raise StaleVersion(
            Message("version {version} is not the current one: it was changed since; look again", version=seen.version),
            present=now,
        )


@dataclass(frozen=True, slots=True)
class Sent:
    """A file with triples that was sent.

    Attributes:
        content: Its content.
        media_type: One of :data:`~skiros_py.files.RDF_TYPES`.
    """

    content: bytes
    media_type: str = "text/turtle"

    @contextmanager
    def as_file(self, name: str) -> Iterator[Path]:
        """Lends it as a file in a folder of its own."""
        ending = next(ending for ending, media_type in RDF_TYPES.items() if media_type == self.media_type)
        with tempfile.TemporaryDirectory(prefix="skiros-sent-") as folder:
            path = Path(folder) / f"{name}{ending}"
            path.write_bytes(self.content)
            yield path


def find(kind: str, name: str, known: Mapping[str, T], code: str = "NotFound") -> T:
    """Returns the target of a request.

    Args:
        kind: What it is, for the message.
        name: Its name.
        known: The targets by name.
        code: The kind of target, for programs.

    Raises:
        NotFound: There is none with this name.
    """
    with addressed(code):
        if name not in known:
            raise UnknownName(kind, name, known)
    return known[name]


@contextmanager
def addressed(code: str = "NotFound") -> Iterator[None]:
    """Converts unknown names into NotFound, for the target of a request; use it only around the lookup of that target.

    Args:
        code: The kind of target, for programs.

    Raises:
        NotFound: The target does not exist.
    """
    try:
        yield
    except UnknownName as error:
        raise NotFound.of(error, code) from None


@contextmanager
def admitted(places: threading.Semaphore | threading.Lock, full: str) -> Iterator[None]:
    """Takes a place in a ``with``.

    Args:
        places: The places.
        full: Why none is left.

    Raises:
        Busy: None is left.
    """
    if not places.acquire(blocking=False):
        raise Busy(full)
    try:
        yield
    finally:
        places.release()

"""Models of robots for the web pages: only visible parts, with meshes that any machine draws quickly.

They are made once for each model, which takes some seconds, and stored in the user's cache directory.
"""

from __future__ import annotations

import hashlib
import logging
import shutil
import threading
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from skiros_py.errors import Busy, DeviceError
from skiros_py.messages import Message
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.system import require_extra
from skiros_py.workers import Worker

if TYPE_CHECKING:
    from skiros_py.perception.light_meshes import MeshPiece

MESHES = "model/meshes/"
"""Location of the meshes, relative to the URL of the model."""

_FORM = b"1"
"""Version of the cache format; a change invalidates older caches."""
_MOST_TRIANGLES = 14_000
"""Triangles of a whole robot: detailed enough, and few enough for software rendering at 30 Hz."""
_PATIENCE = 3.0
"""Maximum wait for a model [s]; making one takes a few seconds on an idle machine."""
_INVISIBLE = ("collision", "inertial")
_WHITE = (1.0, 1.0, 1.0, 1.0)
_log = logging.getLogger(__name__)

_Colour = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class DrawnModel:
    """A model for drawing.

    Attributes:
        urdf: The description; mesh files are named relative to the URL of the model.
        meshes: The mesh files that it uses, by name.
    """

    urdf: bytes
    meshes: Mapping[str, bytes]


class RobotModels:
    """The requested models; thread-safe.

    Args:
        folder: Folder in which they are stored.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._making: dict[str, Future[DrawnModel]] = {}
        self._maker = ThreadPoolExecutor(1, "skiros-robot-models")
        self._changing = threading.Lock()
        self._worker: Worker | None = None
        self._closed = False

    def get(self, name: str) -> DrawnModel:
        """Returns a model; the first call may take some seconds, during which other callers wait as well.

        Raises:
            UnknownName: There is no such model.
            Busy: It is not ready in time.
            SkirosError: A part of it is not installed, or the server is shutting down.
        """
        model = self._begin(name)
        try:
            return model.result(_PATIENCE)
        except TimeoutError:
            raise Busy(Message("the picture of {name} is still being made", name=name), retry_after=2.0) from None
        except CancelledError:
            raise DeviceError("the server ends") from None

    def prepare(self, names: Iterable[str]) -> None:
        """Makes models in the background before they are requested; errors are reported upon request."""
        for name in names:
            self._begin(name)

    def close(self) -> None:
        """Cancels the models being made."""
        self._closed = True
        self._end_worker()
        self._maker.shutdown(cancel_futures=True)

    def _begin(self, name: str) -> Future[DrawnModel]:
        known = self._making.get(name)
        if known is None or (known.done() and (known.cancelled() or known.exception() is not None)):
            try:
                known = self._making[name] = self._maker.submit(self._kept, name)
            except RuntimeError as error:
                raise DeviceError("the server ends") from error
        return known

    def _kept(self, name: str) -> DrawnModel:
        with TemporaryDirectory(prefix="skiros-model-") as place:
            robot = ET.parse(write_robot_urdf(name, Path(place))).getroot()  # noqa: S314 - written just now
        for link in robot.iter("link"):
            for child in [child for child in link if child.tag in _INVISIBLE]:
                link.remove(child)
        folder = self._folder / f"{name}-{_fingerprint(robot)}"
        return _read(folder) or self._make(robot, folder)

    def _make(self, robot: ET.Element, folder: Path) -> DrawnModel:
        with TemporaryDirectory(prefix="skiros-model-") as place:
            made = Path(place)
            pieces = self._lighten(tuple(_sources(robot)), made)
            _log.info("robot model %s: %d triangles", folder.name, _triangles(robot, pieces))
            _draw(robot, pieces)
            urdf = ET.tostring(robot, encoding="utf-8", xml_declaration=True)
            model = DrawnModel(urdf, {file.name: file.read_bytes() for file in sorted(made.glob("*.stl"))})
        _keep(model, folder)
        return model

    def _lighten(self, sources: tuple[Path, ...], folder: Path) -> Mapping[Path, tuple[MeshPiece, ...]]:
        """Returns the simplified pieces of meshes; a process of its own makes them, which ends with the server at last.

        Raises:
            MissingExtra: The library that reads meshes is not installed.
            DeviceError: The process died, or the server is shutting down.
        """
        if not sources:
            return {}
        require_extra("perception", "drawing a robot with meshes")
        with self._changing:
            if self._closed:
                raise DeviceError("the server ends")
            worker = self._worker = Worker("robot model", _lightener)
        try:
            pieces: Mapping[Path, tuple[MeshPiece, ...]] = worker.call(
                "light", sources, folder, _MOST_TRIANGLES
            ).result()
        finally:
            self._end_worker()
        return pieces

    def _end_worker(self) -> None:
        with self._changing:
            worker, self._worker = self._worker, None
            if worker is not None:
                worker.close()


def _lightener() -> object:
    from skiros_py.perception.light_meshes import MeshLightener

    return MeshLightener()


def _sources(robot: ET.Element) -> Iterator[Path]:
    """Yields the file of each mesh, once for each time that it is drawn."""
    yield from (Path(mesh.get("filename", "")) for mesh in robot.iter("mesh"))


def _fingerprint(robot: ET.Element) -> str:
    """Returns a fingerprint that changes with the model, its meshes, and the cache format."""
    digest = hashlib.sha256(_FORM + ET.tostring(robot))
    for source in dict.fromkeys(_sources(robot)):
        digest.update(source.read_bytes() if source.is_file() else b"none")
    return digest.hexdigest()[:16]


def _read(folder: Path) -> DrawnModel | None:
    """Reads a stored model; None if it is missing or incomplete."""
    try:
        urdf = (folder / "robot.urdf").read_bytes()
        names = {mesh.get("filename", "").removeprefix(MESHES) for mesh in ET.fromstring(urdf).iter("mesh")}  # noqa: S314 - our own
        return DrawnModel(urdf, {name: (folder / name).read_bytes() for name in sorted(names)})
    except (OSError, ET.ParseError):
        return None


def _triangles(robot: ET.Element, pieces: Mapping[Path, tuple[MeshPiece, ...]]) -> int:
    return sum(piece.triangles for source in _sources(robot) for piece in pieces[source])


def _keep(model: DrawnModel, folder: Path) -> None:
    """Writes a model atomically; if its folder cannot be written, the model is made again next time."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=folder.parent, prefix=".new-") as place:
            new = Path(place) / folder.name
            new.mkdir()
            (new / "robot.urdf").write_bytes(model.urdf)
            for name, content in model.meshes.items():
                (new / name).write_bytes(content)
            shutil.rmtree(folder, ignore_errors=True)  # an incomplete one
            new.rename(folder)
    except OSError as error:
        _log.warning("the robot model is not kept: %s", error)


# ---------------------------------------------------------------- drawing


def _draw(robot: ET.Element, pieces: Mapping[Path, tuple[MeshPiece, ...]]) -> None:
    """Replaces the meshes of the model by simplified ones: one shape for each colour."""
    colours = _colours(robot)
    for link in robot.iter("link"):
        for visual in link.findall("visual"):
            mesh = visual.find("geometry/mesh")
            own = colours.get(_material(visual), _WHITE)
            if mesh is None:
                _paint(visual, own)
                continue
            link.remove(visual)
            found = pieces[Path(mesh.get("filename", ""))]
            link.extend(_shape(visual, piece, piece.colour if len(found) > 1 else own) for piece in found)


def _colours(robot: ET.Element) -> Mapping[str, _Colour]:
    """Returns the colours of all materials: each is defined once, and valid in the whole model."""
    found: dict[str, _Colour] = {}
    for material in robot.iter("material"):
        colour = material.find("color")
        if colour is not None:
            red, green, blue, opacity = map(float, colour.get("rgba", "1 1 1 1").split())
            found[material.get("name", "")] = red, green, blue, opacity
    return found


def _material(visual: ET.Element) -> str:
    material = visual.find("material")
    return "" if material is None else material.get("name", "")


def _shape(visual: ET.Element, piece: MeshPiece, colour: _Colour) -> ET.Element:
    shape = deepcopy(visual)
    mesh = shape.find("geometry/mesh")
    assert mesh is not None
    mesh.set("filename", f"{MESHES}{piece.file}")
    _paint(shape, colour)
    return shape


def _paint(visual: ET.Element, colour: _Colour) -> None:
    for old in visual.findall("material"):
        visual.remove(old)
    rgba = " ".join(f"{part:.4g}" for part in colour)
    material = ET.SubElement(visual, "material", name=f"rgba {rgba}")
    ET.SubElement(material, "color", rgba=rgba)

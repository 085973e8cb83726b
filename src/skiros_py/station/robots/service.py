"""Use cases: robots with their models, looks and planned motions; devices, with jogging and teaching."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from skiros_py.api.modules import ModuleRunInfo
from skiros_py.api.robots import (
    DeviceInfo,
    DeviceReading,
    Look,
    RobotInfo,
    RobotMotion,
    RobotReading,
)
from skiros_py.errors import Busy, Refused, SkirosError, UnknownName
from skiros_py.ports.cell import RobotSpec
from skiros_py.station.modules.runs import ModuleRun
from skiros_py.station.modules.views import run_info
from skiros_py.station.requests import LIBRARY, Author, addressed
from skiros_py.station.robots import devices, robots
from skiros_py.station.robots.devices import close_device, open_device
from skiros_py.station.robots.manual import Verb, start_by_hand
from skiros_py.station.robots.models import DrawnModel
from skiros_py.station.session import Session

if TYPE_CHECKING:
    from skiros_py.station.station import Station


class RobotService:
    """Describes robots.

    Args:
        station: The station.
    """

    def __init__(self, station: Station) -> None:
        self._station = station

    def all(self) -> list[RobotInfo]:
        """Describes every robot with its devices."""
        session = self._station.session
        return [robots.info(session, robot) for robot in session.spec.robots]

    def get(self, id_: str) -> RobotInfo:
        """Describes one robot.

        Raises:
            NotFound: There is none with this id.
        """
        return robots.info(self._station.session, self._find(id_))

    def reading(self, id_: str) -> RobotReading:
        """Returns the present state of the devices of a robot; poses are those of localisation."""
        return robots.reading(self._station.session, self._find(id_))

    def motion(self, id_: str) -> RobotMotion:
        """Returns the planned motions of a robot's base and arms."""
        return self._station.motions.motion(self._find(id_))

    def look(self, id_: str, camera: str) -> Look:
        """Returns the last picture of a camera used for perception, as points in the map.

        Raises:
            NotFound: There is no such robot or camera.
        """
        with addressed():
            return self._station.looks.look(self._find(id_), camera)

    def model(self, id_: str) -> DrawnModel:
        """Returns the visual model of a robot, or of a device without a robot.

        Raises:
            NotFound: There is none with this id.
            Busy: It is being made.
            Refused: The model cannot be read.
        """
        models = {group.id: group.model for group in self._station.session.spec.groups}
        with addressed():
            if id_ not in models:
                raise UnknownName("robot", id_, models)
        try:
            return self._station.robot_models.get(models[id_])
        except Busy:
            raise
        except SkirosError as error:  # the robots of a plug-in may have none
            raise Refused("NoModel", f"{id_} has no model that can be drawn: {error}") from None

    def mesh(self, id_: str, name: str) -> bytes:
        """Returns a mesh of a robot's model as binary STL [m].

        Raises:
            NotFound: There is no such robot, or its model has no such mesh.
        """
        meshes = self.model(id_).meshes
        with addressed("UnknownMesh"):
            if name not in meshes:
                raise UnknownName("mesh", name, meshes)
        return meshes[name]

    def _find(self, id_: str) -> RobotSpec:
        with addressed():
            return robots.robot_of(self._station.session, id_)


class DeviceService:
    """Describes and reads devices of any kind, opens and closes them, and moves them by hand.

    Args:
        station: The station.
    """

    def __init__(self, station: Station) -> None:
        self._station = station

    def all(self) -> list[DeviceInfo]:
        """Describes all devices of the cell, with the values that each provides."""
        return devices.device_infos(self._station.session)

    def get(self, id_: str) -> DeviceInfo:
        """Describes one device.

        Raises:
            NotFound: There is none with this id.
        """
        with addressed():
            return devices.device_info(self._station.session, id_)

    def open(self, id_: str) -> DeviceInfo:
        """Opens a device: connects its driver, and lets modules use it.

        Raises:
            NotFound: There is none with this id.
            Refused: Its driver cannot be connected.
        """
        with addressed():
            open_device(self._station.control, id_)
        return self.get(id_)

    def close(self, id_: str) -> DeviceInfo:
        """Closes a device: no module may use it; with its last device, the driver is disconnected.

        Raises:
            NotFound: There is none with this id.
            WrongState: It is in use, or it moves.
        """
        with addressed():
            close_device(self._station.control, id_)
        return self.get(id_)

    def reading(self, id_: str) -> DeviceReading:
        """Returns the state of a device, and the values that it provides.

        Raises:
            NotFound: There is none with this id.
        """
        with addressed():
            return devices.device_reading(self._station.session, id_)

    def jog(
        self, id_: str, arguments: Mapping[str, Any], *, module: str | None = None, author: Author = LIBRARY
    ) -> ModuleRunInfo:
        """Moves a device by a small step, or home, with a module that its kind names for that.

        Args:
            id_: Id of the device.
            arguments: Parameters of the module, without the device.
            module: The module; None for the first that the kind names.
            author: The author of the request.

        Raises:
            NotFound: There is no such device.
            UsageError: Its kind names no such module, no subsystem can run it, or the arguments are not valid.
            WrongState: It is in use, or everything is halted.
        """
        return self._by_hand(id_, "jog", arguments, module, author)

    def teach(
        self, id_: str, arguments: Mapping[str, Any], *, module: str | None = None, author: Author = LIBRARY
    ) -> ModuleRunInfo:
        """Learns something from the present state of a device, with a module that its kind names for that.

        Arguments and errors are those of :meth:`jog`.
        """
        return self._by_hand(id_, "teach", arguments, module, author)

    def _by_hand(
        self, id_: str, verb: Verb, arguments: Mapping[str, Any], module: str | None, author: Author
    ) -> ModuleRunInfo:
        def start(session: Session) -> ModuleRun:
            with addressed():
                session.spec.group_of(id_)
            runs = self._station.module_runs
            return start_by_hand(session, runs, id_, verb, module, arguments, author.name)

        return run_info(self._station.control.call(start))

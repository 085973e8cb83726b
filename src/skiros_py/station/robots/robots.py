"""Use cases: robots, and their visual models."""

from __future__ import annotations

from skiros_py.api.robots import RobotInfo, RobotReading
from skiros_py.errors import Busy, Refused, SkirosError
from skiros_py.messages import Message
from skiros_py.ports.cell import RobotSpec
from skiros_py.skills.surroundings import owner
from skiros_py.station.requests import Service, find
from skiros_py.station.robots.devices import device_info, device_state
from skiros_py.station.robots.models import DrawnModel


class RobotService(Service):
    """Describes robots."""

    def all(self) -> list[RobotInfo]:
        """Describes every robot with its devices."""
        return [self._info(robot) for robot in self._session.spec.robots]

    def get(self, id_: str) -> RobotInfo:
        """Describes one robot.

        Raises:
            NotFound: There is none with this id.
        """
        return self._info(self._find(id_))

    def reading(self, id_: str) -> RobotReading:
        """Returns the current state of the devices of a robot; poses are those of localisation."""
        robot, session = self._find(id_), self._session
        snapshot, view = session.cycle.board.snapshot, session.world.snapshot()
        placement = view.placement(id_) if view.has(id_) else None
        frames = session.runtime.context.frames.at(snapshot).devices()
        ids = [device.id for device in robot.devices]
        return RobotReading.view_of(
            snapshot,
            id=id_,
            halted=session.cycle.halted,
            at=placement.place if placement else "",
            pose=robot.pose(snapshot, session.cycle.board.guard),
            devices={id_: device_state(session, snapshot, id_) for id_ in ids},
            frames={id_: frames[id_] for id_ in ids if id_ in frames},
        )

    def model(self, id_: str) -> DrawnModel:
        """Returns the visual model of a robot, or of a device without a robot.

        Raises:
            NotFound: There is none with this id.
            Busy: It is being made.
            Refused: The model cannot be read.
        """
        model = find("robot", id_, {group.id: group.model for group in self._session.spec.groups})
        try:
            return self._station.robot_models.get(model)
        except Busy:
            raise
        except SkirosError as error:  # the robots of a plug-in may have none
            raise Refused(
                "NoModel", Message("{robot} has no model that can be drawn: {error}", robot=id_, error=error)
            ) from None

    def mesh(self, id_: str, name: str) -> bytes:
        """Returns a mesh of a robot's model as binary STL [m].

        Raises:
            NotFound: There is no such robot, or its model has no such mesh.
        """
        return find("mesh", name, self.model(id_).meshes, "UnknownMesh")

    def _find(self, id_: str) -> RobotSpec:
        return find("robot", id_, {robot.id: robot for robot in self._session.spec.robots})

    def _info(self, robot: RobotSpec) -> RobotInfo:
        session, view = self._session, self._world.snapshot()
        return RobotInfo.view_of(
            robot,
            label=view.element(robot.id).label if view.has(robot.id) else "",
            carrier=None if robot.carrier is None else robot.carrier.id,
            place=robot.place if robot.carrier is None else None,
            footprint=robot.outline,
            devices=tuple(device_info(session, device.id) for device in robot.devices),
            agents=tuple(a for a in sorted(session.managers) if view.has(a) and owner(view, a) == robot.id),
        )

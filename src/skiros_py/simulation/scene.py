"""What stands in a simulated cell: bodies, compartments and robots."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skiros_py.errors import DescriptionError, UnknownName, UsageError
from skiros_py.geometry import Pose
from skiros_py.ports.calibration import face_of
from skiros_py.ports.cell import BodySpec, CellSpec, RobotSpec
from skiros_py.ports.device import DeviceModel
from skiros_py.ports.device_faults import model_of
from skiros_py.ports.simulation import Colour, Engine, Print, SimulatedRobot, Surface
from skiros_py.simulation.imperfections import measured_off
from skiros_py.simulation.spawn import free_pose, start_poses
from skiros_py.system import require_extra

_FURNITURE: Colour = (0.80, 0.67, 0.49, 1.0)
_KIT: Colour = (0.25, 0.45, 0.60, 1.0)
_PARTS: tuple[Colour, ...] = (
    (0.86, 0.32, 0.22, 1.0),
    (0.24, 0.60, 0.34, 1.0),
    (0.95, 0.72, 0.18, 1.0),
    (0.45, 0.33, 0.66, 1.0),
    (0.16, 0.62, 0.66, 1.0),
    (0.85, 0.45, 0.65, 1.0),
)


_CARRIED_MASS = 2.0  # [kg] of a body without mass that rides on a robot and so cannot be part of the ground
_TOUCHING = 0.003  # depth of a contact up to which bodies only touch [m]
_DEVICE_STREAM = 1
# With fingers of 1.0 a part of 0.9 kg is held at 30 N per finger; at 0.3 parts begin to slip. The two small ones stop
# parts from spinning between the finger pads and from rolling away for ever.
_BODIES = Surface(lateral=0.8, spinning=0.01, rolling=1e-4)


@dataclass(frozen=True, slots=True)
class CellRobot:
    """A robot with the controllers of its devices.

    Attributes:
        spec: The robot.
        model: It in the engine.
        devices: The controllers of its devices, by id.
    """

    spec: RobotSpec
    model: SimulatedRobot
    devices: Mapping[str, DeviceModel]

    @classmethod
    def bring_up(cls, spec: RobotSpec, model: SimulatedRobot, seed: Sequence[int]) -> CellRobot:
        """Makes the controllers of a robot that is in the engine.

        The device that localises it draws from the seed itself, each other device from a stream of its own.
        """
        controllers = {}
        for device in spec.devices:
            stream = seed if device is spec.localiser else [*seed, *device.id.encode()]
            try:
                for frame in device.frame_names:
                    model.link(frame)
                controller = model_of(device, "simulate", model, np.random.default_rng(stream))
            except UnknownName as error:
                raise DescriptionError(f"{device.id}, in the model '{spec.model}': {error}") from error
            if controller is not None:
                controllers[device.id] = controller
        return cls(spec, model, controllers)

    def platforms(self) -> Iterator[tuple[str, Pose]]:
        """Yields each device that carries bodies, except what moves the robot, with its platform's pose in the map."""
        for device in self.spec.devices:
            if device.carries and device.platform_link and device is not self.spec.carrier:
                try:
                    yield device.id, self.model.link(device.platform_link).pose()
                except UnknownName as error:
                    raise DescriptionError(f"{device.id}, in the model '{self.spec.model}': {error}") from error


class Scene:
    """The simulated world behind a cell.

    Args:
        engine: The engine, still empty.
        spec: What stands in it.
        urdfs: Model of each robot, by the robot's id.
        seed: The run's seed.
        imperfections: Factor of the errors of poses that somebody has measured.

    Attributes:
        engine: The engine.
        bodies: Bodies by id.
        compartments: Compartments by id, each with its pose in the frame of the body it belongs to.
        robots: The robots.
    """

    def __init__(
        self, engine: Engine, spec: CellSpec, urdfs: Mapping[str, Path], *, seed: int, imperfections: float = 0.0
    ) -> None:
        self.engine = engine
        self._types: dict[str, Colour] = {}
        self.bodies: dict[str, BodySpec] = {}
        self.robots = [
            CellRobot.bring_up(robot, _added(engine, robot, urdfs[robot.id]), (seed, _DEVICE_STREAM, number))
            for number, robot in enumerate(spec.groups)
            if robot.model
        ]
        poses = start_poses(spec, seed, {id_: pose for robot in self.robots for id_, pose in robot.platforms()})
        poses = measured_off(spec, poses, seed, imperfections)
        self.compartments = {
            body.id: (body, poses[body.place].inverse() @ poses[body.id])
            for body in spec.bodies
            if body.compartment and body.place is not None
        }
        for body in spec.bodies:
            if not body.compartment:
                self.add(body, poses[body.id])

    def add(self, spec: BodySpec, pose: Pose) -> None:
        """Builds a body at a pose in the map.

        Raises:
            UsageError: There is a body of that id, or it is a compartment.
            MissingExtra: It is a marker board, and OpenCV is not installed.
            DescriptionError: The device that carries it has no model.
        """
        if spec.id in self.bodies or spec.compartment:
            raise UsageError(f"'{spec.id}' is a compartment or is in the cell already")
        mass = spec.mass if spec.carrier is None else spec.mass or _CARRIED_MASS
        colour = self._colour(spec)
        self.engine.add_body(spec.id, spec.solid, pose, mass=mass, colour=colour, surface=_BODIES)
        self.bodies[spec.id] = spec
        if spec.board is not None:
            require_extra("calibration", f"simulating the marker board {spec.id}")
            from skiros_py.charuco import dark_cells  # OpenCV, which most scenes never need

            self.engine.printed[spec.id] = Print(*dark_cells(spec.board), face_of(spec.board, spec.solid))
        if spec.carrier is not None:
            robot = next((robot for robot in self.robots if robot.spec.has(spec.carrier)), None)
            if robot is None:
                raise DescriptionError(f"{spec.carrier} carries {spec.id}, but has no model: give it an sk:model")
            link = robot.spec.device(spec.carrier).platform_link
            self.engine.attach(spec.id, robot.model.name, link)

    def _colour(self, body: BodySpec) -> Colour:
        """Returns wood for furniture, a kit's blue for what stands on something, a colour for each type of part."""
        if body.mass > 0.0 and body.carrier is None:
            return self._types.setdefault(body.type, _PARTS[len(self._types) % len(_PARTS)])
        return _KIT if body.place is not None or body.carrier is not None else _FURNITURE

    def remove(self, body_id: str) -> None:
        """Removes a body.

        Raises:
            UnknownName: There is no such body.
        """
        self.body(body_id)
        self.engine.remove_body(body_id)
        self.engine.printed.pop(body_id, None)
        del self.bodies[body_id]

    def move(self, body_id: str, pose: Pose) -> None:
        """Puts a body somewhere else in the map, at rest.

        Raises:
            UnknownName: There is no such body.
            UsageError: The body is bolted to a robot.
        """
        body = self.body(body_id)
        if body.carrier is not None:
            raise UsageError(f"'{body_id}' is bolted to '{body.carrier}' and moves with it only")
        self.engine.move_body(body_id, pose)

    def hits(self, body_id: str, pose: Pose) -> dict[str, float]:
        """Returns what a body would be in at a pose in the map, with the depths [m]; nothing is changed.

        Fixed bodies do not collide with each other, as in the engine.

        Raises:
            UnknownName: There is no such body.
        """
        self.body(body_id)
        state = self.engine.save()
        try:
            self.engine.move_body(body_id, pose)
            self.engine.step()
            contacts = self.engine.contacts(body_id)
        finally:
            self.engine.restore(state)
        depths: dict[str, float] = {}
        for contact in contacts:
            if contact.depth > _TOUCHING:
                depths[contact.other] = max(contact.depth, depths.get(contact.other, 0.0))
        return depths

    def follow_belief(
        self, name: str, body: BodySpec | None, *, moved: bool, seed: int, passing: AbstractSet[str] = frozenset()
    ) -> None:
        """Adds, removes or moves a body, or rebuilds it with another shape or mass, to be as it is believed to be.

        Args:
            name: Id of the body.
            body: How it is believed to be; None where it is gone.
            moved: True to put it where it is believed to be; otherwise it stays where it is, or away.
            seed: For a pose that is not stated.
            passing: Bodies that are moved as well, through which it may pass.

        Raises:
            UsageError: It is bolted to a robot, or shall be: that takes a new session; or it would be inside another.
            DescriptionError: There is no room for it where it shall lie.
        """
        there = self.bodies.get(name)
        if there is not None and there.carrier is not None and (body is None or moved):
            raise UsageError(f"it is bolted to {there.carrier}: reset the simulation, and it is brought up like that")
        if body is None:
            self.compartments.pop(name, None)
            if there is not None:
                self.remove(name)
        elif body.compartment:
            self._fit(body)
        elif body.carrier is not None:
            raise UsageError(f"it rides on {body.carrier}: reset the simulation, and it is brought up like that")
        elif there is None:
            if moved:
                self._bring(body, seed)
        elif (there.solid, there.mass, there.type) != (body.solid, body.mass, body.type):
            pose = None if moved else self.pose(name)
            self.remove(name)
            self._bring(body if pose is None else replace(body, pose=pose), seed)
        elif moved:
            others = [(spec, pose) for spec, pose in self._standing() if spec.id != name]
            pose = free_pose(body, others, seed)
            hit = sorted(self.hits(name, pose).keys() - passing)
            if hit:
                raise UsageError(f"there it would be inside {', '.join(hit)}")
            self.move(name, pose)
            self.bodies[name] = body

    def _bring(self, body: BodySpec, seed: int) -> None:
        pose = free_pose(body, self._standing(), seed)
        self.add(replace(body, pose=pose), pose)

    def body(self, body_id: str) -> BodySpec:
        """Returns a body.

        Raises:
            UnknownName: There is no such body.
        """
        if body_id not in self.bodies:
            raise UnknownName("body", body_id, self.bodies)
        return self.bodies[body_id]

    def pose(self, body_id: str) -> Pose:
        """Returns the real pose of a body or compartment in the map.

        Raises:
            UnknownName: There is no such body.
        """
        if body_id in self.compartments:
            compartment, relative = self.compartments[body_id]
            return self.pose(str(compartment.place)) @ relative
        self.body(body_id)
        return self.engine.pose(body_id)

    def _standing(self) -> list[tuple[BodySpec, Pose]]:
        """Returns all bodies and compartments, with their real poses in the map."""
        compartments = [spec for spec, _ in self.compartments.values() if spec.place in self.bodies]
        return [(spec, self.pose(spec.id)) for spec in (*self.bodies.values(), *compartments)]

    def _fit(self, compartment: BodySpec) -> None:
        """A compartment is a region of the body that has it: it moves with that one."""
        whole = self.bodies.get(compartment.place or "")
        if whole is not None and compartment.pose is not None and whole.pose is not None:
            self.compartments[compartment.id] = (compartment, whole.pose.inverse() @ compartment.pose)


def _added(engine: Engine, robot: RobotSpec, urdf: Path) -> SimulatedRobot:
    """Adds a robot to the engine: where it stands, or at the map's origin, from where its joints move it."""
    return engine.add_robot(robot.id, urdf, robot.place if robot.carrier is None else Pose())

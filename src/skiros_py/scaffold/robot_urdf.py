"""The robot that a platform can use, from the model of a manufacturer: shapes, masses, limits and frames it lacks."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.errors import UsageError
from skiros_py.geometry import Array, Pose
from skiros_py.ports.kinematics import BASE_LINK
from skiros_py.scaffold.draft import render
from skiros_py.scaffold.robot_hand import CAMERA, TOOL, Hand, add_hand
from skiros_py.scaffold.robot_model import Gripper, Joint, RobotDescription
from skiros_py.scaffold.robot_shapes import Shapes, hull_volume
from skiros_py.scaffold.urdf_elements import (
    add_frame,
    add_shape,
    box_inertia,
    inertia_of,
    is_absurd,
    join,
    numbers,
    set_inertia,
)

_RESERVED = ("map", "world", BASE_LINK, TOOL, CAMERA, "bumper", "scanner")
"""Names of links that mean something else here, or to an engine: MuJoCo takes "world" for its own."""
_DENSITY = 800.0
"""Assumed of links that state no mass [kg/m³]."""
_SPEED, _MOST_SPEED = 1.0, 100.0
"""Assumed of joints that state no speed, and beyond which what is stated is no limit [rad/s]."""
_MOST_EFFORT = 1e5
"""Beyond it, what is stated is no limit [N m]."""
_EFFORT_MARGIN, _EFFORT_LEAST, _PAYLOAD = 3.0, 5.0, 2.0
"""Assumed of joints that state no effort: so many times what holds the arm and a load [kg], and that on top [N m]."""
_ALIKE, _FEW = 0.8, 3
"""Inertias that more than a share of the links have in common were never measured, where more than a few state one."""
_FREE = 6
_TABLE, _SHOULDER = 0.5, 0.28
"""Height of tables, and of the shoulder above them [m]."""
_ABOVE, _HOME_ABOVE = 0.06, 0.3
"""Heights above a table at which the reach counts, and at which the tool point is at home [m]."""
_HOME_SHARE, _PLACES_SHARE = 0.6, 0.72
"""Shares of the reach at which the tool point is at home, and at which parts and kit are."""
_PLACES = 0.4, 0.8
"""Least and greatest distance of parts and kit from the middle of the robot [m]."""
_WHEELS = {
    "differential": {"wheel_left": "0 0.25", "wheel_right": "0 -0.25"},
    "omnidirectional": {
        "wheel_front_left": "0.2 0.25",
        "wheel_front_right": "0.2 -0.25",
        "wheel_rear_left": "-0.38 0.25",
        "wheel_rear_right": "-0.38 -0.25",
    },
}
"""Bases, and where their wheels are [m]."""
_PLATFORM, MOUNT, _BASE_MASS = 0.29, 0.22, 120.0
"""Height of the platform of a base, where on it the arm stands ahead of its middle [m], and its mass [kg]."""
_NEAREST = 0.45
"""Least distance of parts and kit from an arm on a base: what they stand on must not touch the base [m]."""


@dataclass(frozen=True, slots=True)
class Composed:
    """A robot that is ready to be written.

    Attributes:
        urdf: The root element of its URDF; meshes are named relative to the folder of the file, or as installed.
        arm: Joints of the arm.
        home: Joint angles [rad].
        reach: How far from its shoulder it reaches with the hand down on a table, seen from above, and as far as its
            joints slide [m].
        places: How far from the robot's middle parts and kit are put [m].
        fingers: The gripper.
        flange: The link behind the last joint.
        camera: The link of the camera.
        mass: Mass of all of it [kg].
        load: Mass behind the last joint [kg] and its centre in the flange's frame [m].
        notes: What was missing, and what was assumed.
        texts: Meshes that are written, by file name.
        copied: Meshes that are copied, by file name.
    """

    urdf: ET.Element
    arm: tuple[str, ...]
    home: tuple[float, ...]
    reach: float
    places: float
    fingers: Hand
    flange: str
    camera: str
    mass: float
    load: tuple[float, Sequence[float]]
    notes: tuple[str, ...]
    texts: dict[str, str]
    copied: dict[str, Path]


class Composer:
    """Composes one robot.

    Args:
        model: What the manufacturer's files say.
        arm: Joints of its arm.
        gripper: Its gripper.
        name: The name of the robot.
        base: The base that carries it, "differential" or "omnidirectional"; empty for a pedestal.

    Raises:
        UsageError: There is no such base.
    """

    def __init__(
        self, model: RobotDescription, arm: Sequence[Joint], gripper: Gripper, name: str, base: str = ""
    ) -> None:
        if base and base not in _WHEELS:
            raise UsageError(f"--base {base}: there is {' and '.join(_WHEELS)}")
        self._model, self._arm, self._gripper, self._name, self._base = model, arm, gripper, name, base
        self._urdf = ET.Element("robot", name=name)
        self._notes: list[str] = []
        self._effortless: dict[str, ET.Element] = {}

    def compose(self) -> Composed:
        """Returns the robot.

        Raises:
            UsageError: None of its meshes are there, or the fingers cannot be understood.
            FileError: A mesh cannot be read.
            MissingExtra: The extra "physics", which reads meshes, is not installed.
        """
        shapes = Shapes(self._model)
        self._notes += shapes.notes
        self._add_links(shapes)
        self._add_joints()
        hand = add_hand(self._urdf, self._model, self._gripper, self._arm[-1], shapes.points, self._called)
        self._notes += [*hand.notes, f"a force-torque sensor is proposed in {self._arm[-1].name}"]
        self._add_pedestal(shapes)
        return self._measured(shapes, hand)

    def _called(self, link: str) -> str:
        return f"{self._name}_{link}" if link in _RESERVED else link

    # ------------------------------------------------------------------ links

    def _add_links(self, shapes: Shapes) -> None:
        self._urdf.extend(copy.deepcopy(one) for one in self._model.xml.findall("material"))
        stated = {name: inertia_of(element) for name, element in self._model.links.items()}
        tensors = [value[1].tobytes() for value in stated.values() if value is not None]
        common = max(map(tensors.count, tensors), default=0)
        alike = len(tensors) > _FEW and common > _ALIKE * len(tensors)
        missing: list[str] = []
        absurd: list[str] = []
        for name, element in self._model.links.items():
            points, inertia = shapes.points[name], stated[name]
            if inertia is None and not len(points):
                add_frame(self._urdf, self._called(name))
                continue
            link = ET.SubElement(self._urdf, "link", name=self._called(name))
            link.extend(shapes.of(name))
            if inertia is not None and not alike and not is_absurd(*inertia, points):
                link.extend(copy.deepcopy(one) for one in element.findall("inertial"))
            elif not len(points):  # a frame, not a body
                self._urdf.remove(link)
                add_frame(self._urdf, self._called(name))
            else:
                (missing if inertia is None else absurd).append(name)
                _set_inertia_of_box(link, 0.0 if inertia is None else inertia[0], points)
        if missing:
            self._notes.append(f"no inertia, computed from shapes at {_DENSITY:.0f} kg/m³: {', '.join(missing)}")
        if absurd:
            why = "inertia that cannot be true (zero, too large, or the same for all), computed"
            self._notes.append(f"{why}: {', '.join(absurd)}")

    # ------------------------------------------------------------------ joints

    def _add_joints(self) -> None:
        arm = {joint.name for joint in self._arm}
        frozen = []
        for joint in self._model.joints.values():
            if joint.child in self._gripper.fingers:
                continue
            at = joint.transform(self._model.position(joint, self._gripper.positions))
            if joint.name in arm:
                at = joint.origin
            kind = "fixed" if joint.name not in arm else "prismatic" if joint.type == "prismatic" else "revolute"
            made = join(self._urdf, joint.name, kind, self._called(joint.parent), self._called(joint.child), at)
            if joint.name in arm:
                ET.SubElement(made, "axis", xyz=numbers(joint.axis))
            elif joint.type not in ("fixed", "floating") and joint.name not in self._gripper.joints:
                frozen.append(joint.name)
        self._add_limits()
        if frozen:
            self._notes.append(
                f"joints that are neither of the arm nor of the gripper stand still: {', '.join(frozen)}"
            )

    def _add_limits(self) -> None:
        assumed: dict[str, list[str]] = {
            "joints that turn without end get a turn to each side": [],
            "no limits, assumed half a turn to each side": [],
            f"no greatest speed, assumed {_SPEED} rad/s": [],
        }
        endless, unlimited, speedless = assumed.values()
        made = {one.get("name"): one for one in self._urdf.findall("joint")}
        for joint in self._arm:
            stated = joint.element.find("limit")
            values = {
                key: float((stated.get(key) if stated is not None else "") or 0) for key in ("velocity", "effort")
            }
            lower, upper = joint.lower, joint.upper
            if joint.type == "continuous":
                endless.append(joint.name)
                lower, upper = -math.tau, math.tau
            elif stated is None or lower >= upper:
                unlimited.append(joint.name)
                lower, upper = -math.pi, math.pi
            if not 0.0 < values["velocity"] < _MOST_SPEED:
                speedless.append(joint.name)
                values["velocity"] = _SPEED
            values |= {"lower": lower, "upper": upper}
            limit = ET.SubElement(made[joint.name], "limit", {key: f"{value:.6g}" for key, value in values.items()})
            if not 0.0 < values["effort"] < _MOST_EFFORT:
                self._effortless[joint.name] = limit
        self._notes += [f"{what}: {', '.join(names)}" for what, names in assumed.items() if names]

    # ------------------------------------------------------------------ what stands below

    def _add_pedestal(self, shapes: Shapes) -> None:
        turning = [joint for joint in self._arm if joint.type != "prismatic"]
        shoulder = turning[min(1, len(turning) - 1)]
        height = _TABLE + _SHOULDER - float(self._model.pose(shoulder.child, {})[2, 3])
        low = min(self._lowest(link, points) for link, points in shapes.points.items())
        floor, ahead = (_PLATFORM, MOUNT) if self._base else (0.0, 0.0)
        height = round(max(height, floor - low if low < -0.02 else floor), 3)
        root = ET.Element("link", name=BASE_LINK)
        if self._base:
            below = ET.fromstring(render("urdf_base.urdf", wheels=_WHEELS[self._base]))  # noqa: S314 - our own
            self._urdf[:0] = list(below)
            root = next(one for one in below.findall("link") if one.get("name") == BASE_LINK)
            self._notes.append(f"it stands on a {self._base} base of its own, of 0.87 x 0.61 m and {_BASE_MASS:.0f} kg")
        else:
            self._urdf.insert(0, root)
            set_inertia(root, 60.0, np.diag([3.0, 3.0, 1.5]), np.array([0.0, 0.0, max(height, 0.1) / 2.0]))
        if height - floor > 0.05:
            for tag in ("collision", "visual"):
                size = 0.2, 0.2, height - floor - 0.005
                middle = Pose.of(ahead, 0, floor + size[2] / 2.0).matrix()
                add_shape(root, tag, middle, "box", {"size": numbers(size)})
            why = f"so that its shoulder is above tables of {_TABLE} m"
            self._notes.append(f"it stands on a pedestal of {height - floor:.3f} m, {why}")
        at = Pose.of(ahead, 0, height).matrix()
        join(self._urdf, "pedestal_joint", "fixed", BASE_LINK, self._called(self._model.root), at)

    def _lowest(self, link: str, points: Array) -> float:
        pose = self._model.pose(link, self._gripper.positions)
        return float((points @ pose[2, :3]).min(initial=math.inf) + pose[2, 3])

    # ------------------------------------------------------------------ what follows from all of it

    def _measured(self, shapes: Shapes, hand: Hand) -> Composed:
        """Returns the robot with load, efforts, reach and home, as they follow from the arm that is written."""
        from skiros_py.motion.pinocchio import measures
        from skiros_py.motion.pinocchio.arm_model import ArmModel

        joints = tuple(joint.name for joint in self._arm)
        gripper = GripperSpec("gripper", hand.joints, "arm", hand.max_gap, hand.max_force)
        with TemporaryDirectory(prefix="skiros-robot-") as folder:
            file = self._write_without_visuals(Path(folder), shapes.texts)
            arm = ArmModel(file, ArmSpec("arm", joints, TOOL, (0.0,) * len(joints)), [gripper])
        if self._effortless:
            efforts = _EFFORT_MARGIN * measures.holding_efforts(arm, _PAYLOAD) + _EFFORT_LEAST
            for name, limit in self._effortless.items():
                limit.set("effort", f"{efforts[joints.index(name)]:.4g}")
            names = ", ".join(self._effortless)
            self._notes.append(f"no greatest effort, assumed what holds the arm and {_PAYLOAD:.0f} kg, amply: {names}")
        if (free := measures.degrees_of_freedom(arm)) < _FREE:
            self._notes.append(f"the hand moves and turns in {free} directions of {_FREE}: it reaches few grasps")
        reach = measures.reach_above(arm, _TABLE + _ABOVE)
        home = measures.find_home(arm, _HOME_SHARE * reach, _TABLE + _HOME_ABOVE)
        if not reach or home is None:
            raise UsageError("no posture with the hand down in front of the robot was found: choose the arm by --arm")
        mass, centre = measures.load_of(arm)
        travel = sum(max(-joint.lower, joint.upper) for joint in self._arm if joint.type == "prismatic")
        least, most = _PLACES
        ET.indent(self._urdf)
        return Composed(
            self._urdf,
            joints,
            tuple(round(float(angle), 4) + 0.0 for angle in home),
            round(reach + travel, 3),
            round(float(np.clip(_PLACES_SHARE * reach, _NEAREST if self._base else least, most)), 2),
            hand,
            self._called(self._arm[-1].child),
            CAMERA,
            _mass_of(self._urdf),
            (mass, centre.tolist()),
            tuple(self._notes),
            shapes.texts,
            shapes.copied,
        )

    def _write_without_visuals(self, folder: Path, texts: dict[str, str]) -> Path:
        urdf = copy.deepcopy(self._urdf)
        for link in urdf.findall("link"):
            for visual in link.findall("visual"):
                link.remove(visual)
        for mesh in urdf.iter("mesh"):
            name = mesh.get("filename", "")
            (folder / name).write_text(texts[name], encoding="utf-8")
            mesh.set("filename", str(folder / name))
        file = folder / "robot.urdf"
        file.write_bytes(ET.tostring(urdf))
        return file


def _mass_of(urdf: ET.Element) -> float:
    """Returns the mass of a robot [kg], without the map that a base drives on."""
    return sum(float(one.get("value", "0")) for one in urdf.iterfind("link/inertial/mass"))


def _set_inertia_of_box(link: ET.Element, mass: float, points: Array) -> None:
    """States the inertia of the box around points [m]; without a mass [kg] also that of their hull."""
    low, high = points.min(axis=0), points.max(axis=0)
    mass = mass if mass > 0.0 else max(0.01, _DENSITY * hull_volume(points))
    set_inertia(link, mass, box_inertia(mass, np.maximum(high - low, 0.002)), (low + high) / 2.0)

"""The robot that a platform can use, from the model of a manufacturer: shapes, masses, limits and frames it lacks."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.errors import MissingExtra, UsageError
from skiros_py.geometry import Array
from skiros_py.ports.robot_files import installed_name
from skiros_py.scaffold.robot_model import Gripper, Joint, RobotDescription, find_mesh, origin_of

_ROOT = "base_link"
_TIGHT = 1.2
"""A box or cylinder replaces a mesh if its volume is at most so many times that of the hull."""
_CORNERS = 60
"""Greatest number of corners of a hull."""
_DENSITY = 800.0
"""Assumed of links that state no mass [kg/m³]."""
_SPEED, _ACCELERATION = 1.0, 3.0
"""Assumed of joints that state no speed [rad/s], and of all [rad/s²]."""
_EFFORT_MARGIN, _EFFORT_LEAST, _PAYLOAD = 3.0, 5.0, 2.0
"""Assumed of joints that state no effort: so many times what holds the arm and a load [kg], and that on top [N m]."""
_MOST_EFFORT = 1e5
"""Beyond it, what is stated is no limit [N m]."""
_TABLE = 0.5
_SHOULDER = 0.28
"""Height of the shoulder above the tables [m]."""
_BEYOND = 0.01
"""How far the fingers reach beyond the tip [m]."""
_PAD = 0.04
"""Length of the fingers from their ends that counts as pads [m]."""
_FORCE = 40.0
"""Assumed finger force [N]."""


class Fingers(NamedTuple):
    """The gripper as its platform describes it.

    Attributes:
        joints: Its joints.
        max_gap: [m].
        max_force: [N].
        size: Width, thickness and reach beyond the tip [m].
    """

    joints: tuple[str, ...]
    max_gap: float
    max_force: float
    size: tuple[float, float, float]


@dataclass
class Composed:
    """A robot that is ready to be written.

    Attributes:
        urdf: The root element of its URDF; meshes are named relative to the folder of the file, or as installed.
        arm: Joints of the arm.
        home: Joint angles [rad].
        reach: How far from its first joint it reaches with the hand down on a table, seen from above [m].
        places: How far from the robot's middle parts and kit are put [m].
        fingers: The gripper.
        flange: The link behind the last joint.
        camera: The link of the camera.
        load: Mass behind the last joint [kg] and its centre in the flange's frame [m].
        notes: What was missing, and what was assumed.
        texts: Meshes that are written, by file name.
        copied: Meshes that are copied, by file name.
    """

    urdf: ET.Element
    arm: tuple[str, ...]
    home: tuple[float, ...] = ()
    reach: float = 0.0
    places: float = 0.5
    fingers: Fingers | None = None
    flange: str = ""
    camera: str = "camera_optical"
    load: tuple[float, Sequence[float]] = (0.0, (0.0, 0.0, 0.0))
    notes: list[str] = field(default_factory=list)
    texts: dict[str, str] = field(default_factory=dict)
    copied: dict[str, Path] = field(default_factory=dict)


class Composer:
    """Composes one robot.

    Args:
        model: What the manufacturer's files say.
        arm: Joints of its arm.
        gripper: Its gripper.
        name: The name of the robot.
    """

    def __init__(self, model: RobotDescription, arm: Sequence[Joint], gripper: Gripper, name: str) -> None:
        self._model, self._arm, self._gripper, self._name = model, arm, gripper, name
        self._positions = dict(gripper.positions)
        self._points: dict[str, Array] = {}
        self._meshes: dict[Path, tuple[Array, Array]] = {}
        self._hulls: dict[tuple[Path, tuple[float, ...]], str] = {}
        self._gone: set[str] = set()
        self._effortless: dict[str, ET.Element] = {}
        self.found = Composed(ET.Element("robot", name=name), tuple(joint.name for joint in arm))
        self.found.flange = self._called(arm[-1].child)

    def compose(self) -> Composed:
        """Returns the robot.

        Raises:
            UsageError: None of its meshes are there, or the fingers cannot be understood.
            MissingExtra: The extra "physics", which reads meshes, is not installed.
        """
        self._links()
        self._check_meshes()
        self._masses()
        self._joints()
        self._hand()
        self._pedestal()
        self._measure()
        ET.indent(self.found.urdf)
        return self.found

    def _note(self, text: str) -> None:
        self.found.notes.append(text)

    def _called(self, link: str) -> str:
        taken = {"map", _ROOT, "tcp", "camera_optical"}
        return f"{self._name}_{link}" if link in taken else link

    def _link(self, name: str) -> ET.Element:
        return next(one for one in self.found.urdf.findall("link") if one.get("name") == name)

    # ------------------------------------------------------------------ links and their shapes

    def _links(self) -> None:
        urdf = self.found.urdf
        urdf.extend(copy.deepcopy(one) for one in self._model.xml.findall("material"))
        bare = []
        for name, element in self._model.links.items():
            link = ET.SubElement(urdf, "link", name=self._called(name))
            inertial = element.find("inertial")
            if inertial is not None:
                link.append(copy.deepcopy(inertial))
            collisions = [shape for one in element.findall("collision") for shape in self._collision(one)]
            if not collisions and element.findall("visual"):
                collisions = [shape for one in element.findall("visual") for shape in self._collision(one)]
                bare += [name] if collisions else []
            link.extend(collisions)
            link.extend(shape for one in element.findall("visual") for shape in self._visual(one, collisions))
            given = self._model.shapes(name)
            self._points[name] = np.concatenate(
                [np.zeros((0, 3)), *(_corners(one, self._mesh_points) for one in given)]
            )
        if bare:
            self._note(f"links without shapes for collisions: those for the eye serve for {', '.join(bare)}")

    def _check_meshes(self) -> None:
        if not self._gone:
            return
        there = any(len(points) for points in self._points.values())
        names = ", ".join(sorted(self._gone)[:6]) + (f" and {len(self._gone) - 6} more" if len(self._gone) > 6 else "")
        if not there:
            raise UsageError(f"{self._model.file}: none of its meshes are there, beside it or above: {names}")
        self._note(f"missing meshes, left out: {names}")

    def _file(self, mesh: ET.Element) -> Path | None:
        name = mesh.get("filename", "")
        file = find_mesh(self._model.file, name)
        if file is None:
            self._gone.add(name)
        return file

    def _read(self, file: Path) -> tuple[Array, Array]:
        if file not in self._meshes:
            try:
                from skiros_py.motion.pinocchio.meshes import read_mesh
            except ImportError:
                raise MissingExtra("physics", "a robot from a URDF") from None
            self._meshes[file] = read_mesh(file)
        return self._meshes[file]

    def _mesh_points(self, mesh: ET.Element) -> Array:
        file = find_mesh(self._model.file, mesh.get("filename", ""))
        return np.zeros((0, 3)) if file is None else self._read(file)[0] * _scale(mesh)

    def _collision(self, element: ET.Element) -> list[ET.Element]:
        mesh = element.find("geometry/mesh")
        if mesh is None:
            plain = ET.Element("collision")
            plain.extend(copy.deepcopy(one) for one in element if one.tag in ("origin", "geometry"))
            return [plain]
        file = self._file(mesh)
        if file is None:
            return []
        key = (file, tuple(_scale(mesh)))
        points = self._read(file)[0] * _scale(mesh)
        shape = _simple(points)
        origin = origin_of(element)
        if shape is None:
            text = self._hull(file, key[1], points)
            collision = ET.Element("collision")
            _set_origin(collision, origin)
            ET.SubElement(ET.SubElement(collision, "geometry"), "mesh", filename=text)
            return [collision]
        pose, kind, size = shape
        collision = ET.Element("collision")
        _set_origin(collision, origin @ pose)
        ET.SubElement(ET.SubElement(collision, "geometry"), kind, size)
        return [collision]

    def _hull(self, file: Path, scale: tuple[float, ...], points: Array) -> str:
        if (file, scale) not in self._hulls:
            taken = sum(name.startswith(f"{file.stem}_hull") for name in self.found.texts)
            self._hulls[file, scale] = f"{file.stem}_hull{taken or ''}.obj"
            self.found.texts[self._hulls[file, scale]] = _obj(*_few(points))
        return self._hulls[file, scale]

    def _visual(self, element: ET.Element, collisions: Sequence[ET.Element]) -> list[ET.Element]:
        visual = copy.deepcopy(element)
        mesh = visual.find("geometry/mesh")
        if mesh is None:
            return [visual]
        file = self._file(mesh)
        if file is None:
            return [_eye(one) for one in collisions]
        if file.suffix.lower() not in (".stl", ".obj"):  # not read by all engines
            scale = _scale(mesh)
            points, triangles = self._read(file)
            name = f"{file.stem}.obj"
            self.found.texts.setdefault(name, _obj(points * scale, triangles))
            mesh.attrib.clear()
            mesh.set("filename", name)
            return [visual]
        installed = installed_name(file)
        if installed is None:
            installed = file.name
            if self.found.copied.get(installed, file) != file:
                installed = f"{file.parent.name}_{file.name}"
            self.found.copied[installed] = file
        mesh.set("filename", installed)
        return [visual]

    # ------------------------------------------------------------------ masses

    def _masses(self) -> None:
        stated = {name: _inertia(element) for name, element in self._model.links.items()}
        tensors = [tuple(value[1].ravel()) for value in stated.values() if value is not None]
        common = max(tensors, key=tensors.count, default=())
        same = len(tensors) > 3 and tensors.count(common) > 0.8 * len(tensors)
        missing: list[str] = []
        absurd: list[str] = []
        for name in self._model.links:
            value, points = stated[name], self._points[name]
            link = self._link(self._called(name))
            if value is None and not len(points):
                _set_inertia(link, 0.001, np.eye(3) * 1e-6, np.zeros(3))
                continue
            wrong = value is not None and (same or _absurd(*value, points))
            if value is not None and not wrong:
                continue
            if not len(points):  # a frame, not a body
                _set_inertia(link, 0.001, np.eye(3) * 1e-6, np.zeros(3))
                continue
            (absurd if wrong else missing).append(name)
            mass = value[0] if value is not None and value[0] > 0.0 else 0.0
            self._from_shape(link, mass, points)
        if missing:
            self._note(f"no inertia, computed from shapes at {_DENSITY:.0f} kg/m³: {', '.join(missing)}")
        if absurd:
            self._note(
                f"inertia that cannot be true (zero, too large, or the same for all), computed: {', '.join(absurd)}"
            )

    def _from_shape(self, link: ET.Element, mass: float, points: Array) -> None:
        low, high = points.min(axis=0), points.max(axis=0)
        size = np.maximum(high - low, 0.002)
        mass = mass or max(0.01, _DENSITY * _volume(points))
        squares = size**2
        moments = mass / 12.0 * (squares.sum() - squares)
        _set_inertia(link, mass, np.diag(moments), (low + high) / 2.0)

    # ------------------------------------------------------------------ joints

    def _joints(self) -> None:
        frozen, speeds, endless, unlimited = [], [], [], []
        arm = {joint.name for joint in self._arm}
        for joint in self._model.joints.values():
            if joint.child in self._gripper.fingers:
                continue
            made = ET.SubElement(self.found.urdf, "joint", name=joint.name, type="fixed")
            ET.SubElement(made, "parent", link=self._called(joint.parent))
            ET.SubElement(made, "child", link=self._called(joint.child))
            if joint.name not in arm:
                if joint.type not in ("fixed", "floating"):
                    frozen += [] if joint.name in self._gripper.joints else [joint.name]
                _set_origin(made, joint.transform(self._model.position(joint, self._positions)))
                continue
            _set_origin(made, joint.origin)
            made.set("type", "prismatic" if joint.type == "prismatic" else "revolute")
            ET.SubElement(made, "axis", xyz=_text(joint.axis))
            stated = joint.element.find("limit")
            lower, upper = joint.lower, joint.upper
            if joint.type == "continuous":
                endless.append(joint.name)
                lower, upper = -2.0 * math.pi, 2.0 * math.pi
            elif stated is None or lower >= upper:
                unlimited.append(joint.name)
                lower, upper = -math.pi, math.pi
            speed = float(stated.get("velocity", "0")) if stated is not None else 0.0
            if not 0.0 < speed < 100.0:
                speeds.append(joint.name)
                speed = _SPEED
            effort = float(stated.get("effort", "0")) if stated is not None else 0.0
            values = {"lower": lower, "upper": upper, "velocity": speed, "effort": effort}
            limit = ET.SubElement(made, "limit", {key: f"{value:.6g}" for key, value in values.items()})
            if not 0.0 < effort < _MOST_EFFORT:
                self._effortless[joint.name] = limit
        if endless:
            self._note(f"joints that turn without end get a turn to each side: {', '.join(endless)}")
        if unlimited:
            self._note(f"no limits, assumed half a turn to each side: {', '.join(unlimited)}")
        if speeds:
            self._note(f"no greatest speed, assumed {_SPEED} rad/s: {', '.join(speeds)}")
        if frozen:
            self._note(f"joints that are neither of the arm nor of the gripper stand still: {', '.join(frozen)}")

    # ------------------------------------------------------------------ hand: fingers, tool point, camera

    def _hand(self) -> None:
        if not self._gripper.fingers:
            self._plain_gripper()
            return
        model, palm, names = self._model, self._gripper.palm, self._gripper.fingers
        poses = [model.pose(link, self._positions, palm) for link in names]
        groups = [self._rigid(link, pose) for link, pose in zip(names, poses, strict=True)]
        if not all(len(points) for points in groups):
            lacking = [link for link, points in zip(names, groups, strict=True) if not len(points)]
            raise UsageError(f"the fingers {', '.join(lacking)} have no shape: choose others by --gripper")
        ahead, across = _hand_axes(*groups)
        end = max(float((points @ ahead).max()) for points in groups)
        pads = [points[points @ ahead > end - _PAD] for points in groups]
        if not all(len(points) for points in pads):
            raise UsageError("of the fingers one is much shorter than the other: choose others by --gripper")
        inner = [float((pads[0] @ across).min()), float((pads[1] @ across).max())]
        gap = inner[0] - inner[1]
        if gap < 0.01:
            raise UsageError(f"{' and '.join(names)} open only {gap * 1000.0:.0f} mm: choose others by --gripper")
        middle = sum(inner) / 2.0
        side = np.cross(across, ahead)
        along = np.concatenate(pads) @ side
        centre = across * middle + ahead * (end - _BEYOND) + side * (float(along.min()) + float(along.max())) / 2.0
        tool = np.eye(4)
        tool[:3, :3], tool[:3, 3] = np.column_stack([side, across, ahead]), centre
        thick = max(abs(float((one @ across).max() - (one @ across).min())) for one in pads)
        width = max(float((one @ side).max() - (one @ side).min()) for one in pads)
        joints = []
        for number, (link, pose) in enumerate(zip(names, poses, strict=True)):
            sign = 1.0 if number == 0 else -1.0
            joints.append(self._finger(link, pose, sign * across, sign * gap / 2.0 * across, gap / 2.0))
            self._pads(link, groups[number], pose, tool, sign * gap / 2.0, sign)
        self.found.fingers = Fingers(tuple(joints), gap, self._force(), (width, min(thick, 0.05), _BEYOND))
        if not self._gripper.sliding:
            self._note(
                "the fingers turn or stand still in the model: they slide here, as they stand when open, and the links"
                f" that move them stand still (gap {gap * 1000.0:.0f} mm)"
            )
        self._frames(palm, tool, np.concatenate([*groups, self._near(palm)]))

    def _rigid(self, link: str, pose: Array) -> Array:
        """Returns points of a link and of what is fixed to it [m], at a pose of the link."""
        found = [self._points[link] @ pose[:3, :3].T + pose[:3, 3]]
        found += [
            self._rigid(joint.child, pose @ joint.transform(self._model.position(joint, self._positions)))
            for joint in self._model.below[link]
        ]
        return np.concatenate(found)

    def _near(self, palm: str) -> Array:
        """Returns points of the palm in its own frame."""
        return self._points[palm] if len(self._points[palm]) else np.zeros((1, 3))

    def _finger(self, link: str, pose: Array, direction: Array, opened: Array, travel: float) -> str:
        name = self._model.above[link].name
        joint = ET.SubElement(self.found.urdf, "joint", name=name, type="prismatic")
        ET.SubElement(joint, "parent", link=self._called(self._gripper.palm))
        ET.SubElement(joint, "child", link=self._called(link))
        closed = pose.copy()
        closed[:3, 3] -= opened
        _set_origin(joint, closed)
        ET.SubElement(joint, "axis", xyz=_text(pose[:3, :3].T @ direction))
        ET.SubElement(joint, "limit", lower="0", upper=f"{travel:.6g}", effort="120", velocity="0.2")
        return name

    def _pads(self, link: str, points: Array, pose: Array, tool: Array, inner: float, sign: float) -> None:
        """Replaces a finger's shapes for collisions by boxes that end at its pad."""
        here = (points - tool[:3, 3]) @ tool[:3, :3]
        for name in self._model.subtree(link):
            other = self._link(self._called(name))
            for one in other.findall("collision"):
                other.remove(one)
        above = _BEYOND - _PAD
        tip = here[:, 2] > above
        for part, top in ((here[tip], math.inf), (here[~tip], above)):
            if not len(part):
                continue
            low, high = part.min(axis=0), part.max(axis=0)
            (low if sign > 0.0 else high)[1] = (
                inner if top > above else sign * max(sign * (low if sign > 0.0 else high)[1], abs(inner))
            )
            high[2], low[2] = min(high[2], top), low[2] if top == above else max(low[2], above)
            size = high - low
            if size.min() < 0.001:
                continue
            box = np.eye(4)
            box[:3, 3] = low + size / 2.0
            collision = ET.Element("collision")
            _set_origin(collision, np.linalg.inv(pose) @ tool @ box)
            ET.SubElement(ET.SubElement(collision, "geometry"), "box", size=_text(size))
            self._link(self._called(link)).append(collision)

    def _force(self) -> float:
        for name in self._gripper.joints:
            joint = self._model.joints[name]
            limit = joint.element.find("limit")
            if joint.type == "prismatic" and limit is not None and 5.0 < float(limit.get("effort", "0")) < 500.0:
                return float(limit.get("effort", "0"))
        self._note(f"no finger force is stated, assumed {_FORCE:.0f} N")
        return _FORCE

    def _plain_gripper(self) -> None:
        """Mounts two sliding boxes on a palm at the end of the arm."""
        flange = self._gripper.palm
        points = np.concatenate([self._rigid(flange, np.eye(4)), np.zeros((1, 3))])
        ahead = self._outward(points)
        side = np.eye(3)[int(np.argmin(np.abs(ahead)))]
        frame = np.eye(4)
        frame[:3, :3] = np.column_stack([side, np.cross(ahead, side), ahead])
        frame[:3, 3] = ahead * float((points @ ahead).max())
        urdf = self.found.urdf
        palm = self._box_link("gripper_palm", 0.6, (0.06, 0.14, 0.06), (0.0, 0.0, 0.03))
        _join(urdf, "gripper_mount", "fixed", self._called(flange), palm, frame)
        names = []
        for side_name, sign in (("left", 1.0), ("right", -1.0)):
            finger = self._box_link(
                f"gripper_{side_name}_finger", 0.08, (0.022, 0.014, 0.08), (0.0, sign * 0.007, 0.04)
            )
            at = np.eye(4)
            at[2, 3] = 0.06
            name = f"gripper_{side_name}_finger_joint"
            joint = _join(urdf, name, "prismatic", palm, finger, at)
            ET.SubElement(joint, "axis", xyz=f"0 {sign:g} 0")
            ET.SubElement(joint, "limit", lower="0", upper="0.05", effort="120", velocity="0.2")
            names.append(name)
        tool = np.eye(4)
        tool[2, 3] = 0.14 - _BEYOND
        self.found.fingers = Fingers((names[0], names[1]), 0.1, 60.0, (0.022, 0.014, _BEYOND))
        self._note("a plain parallel gripper of its own, opening 100 mm, is mounted at the end of the arm")
        self._frames(palm, tool, np.array([[-0.03, -0.07, 0.0], [0.03, 0.07, 0.06]]), called=True)

    def _outward(self, points: Array) -> Array:
        """Returns the axis of the flange along which tools are mounted: that of the last joint, away from the arm."""
        axis = self._arm[-1].axis
        low, high = float((points @ axis).min()), float((points @ axis).max())
        behind = float(-(self._arm[-1].origin[:3, :3] @ axis) @ self._arm[-1].origin[:3, 3])
        if abs(high + low) > 0.2 * (high - low):
            return axis if high > -low else -axis
        return -axis if behind > 0.0 else axis

    def _box_link(
        self, name: str, mass: float, size: tuple[float, float, float], at: tuple[float, float, float]
    ) -> str:
        link = ET.SubElement(self.found.urdf, "link", name=name)
        squares = np.square(size)
        _set_inertia(link, mass, np.diag(mass / 12.0 * (squares.sum() - squares)), np.array(at))
        for tag in ("collision", "visual"):
            shape = ET.SubElement(link, tag)
            ET.SubElement(shape, "origin", xyz=_text(at))
            ET.SubElement(ET.SubElement(shape, "geometry"), "box", size=_text(size))
        return name

    def _frames(self, palm: str, tool: Array, points: Array, *, called: bool = False) -> None:
        """Adds the tool point, and a camera beside the fingers that looks past them."""
        palm = palm if called else self._called(palm)
        for name in ("tcp", "camera_optical"):
            link = ET.SubElement(self.found.urdf, "link", name=name)
            _set_inertia(link, 0.001, np.eye(3) * 1e-6, np.zeros(3))
        _join(self.found.urdf, "tcp_joint", "fixed", palm, "tcp", tool)
        here = (points - tool[:3, 3]) @ tool[:3, :3]
        behind = here[here[:, 2] > -0.12]
        out = float((behind if len(behind) else here)[:, 0].max()) + 0.035
        camera = np.eye(4)
        camera[:3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
        camera[:3, 3] = [out, 0.0, -0.09]
        _join(self.found.urdf, "camera_joint", "fixed", palm, "camera_optical", tool @ camera)
        self._note(f"a camera is proposed {out * 1000.0:.0f} mm beside the tool point, 90 mm behind it, looking ahead")
        self._note(f"a force-torque sensor is proposed in {self._arm[-1].name}")

    # ------------------------------------------------------------------ what stands below, what hangs behind

    def _pedestal(self) -> None:
        model = self._model
        shoulder = self._arm[min(1, len(self._arm) - 1)]
        height = _TABLE + _SHOULDER - float(model.pose(shoulder.child, {})[2, 3])
        low = min(
            (float(self._at_zero(link)[:, 2].min()) for link in model.links if len(self._points[link])), default=0.0
        )
        height = round(max(height, -low if low < -0.02 else 0.0), 3)
        root = ET.Element("link", name=_ROOT)
        self.found.urdf.insert(0, root)
        _set_inertia(root, 60.0, np.diag([3.0, 3.0, 1.5]), np.array([0.0, 0.0, max(height, 0.1) / 2.0]))
        if height > 0.05:
            for tag in ("collision", "visual"):
                shape = ET.SubElement(root, tag)
                ET.SubElement(shape, "origin", xyz=f"0 0 {(height - 0.005) / 2.0:.4f}")
                ET.SubElement(ET.SubElement(shape, "geometry"), "box", size=f"0.2 0.2 {height - 0.005:.4f}")
            self._note(f"it stands on a pedestal of {height:.3f} m, so that its shoulder is above tables of {_TABLE} m")
        at = np.eye(4)
        at[2, 3] = height
        _join(self.found.urdf, "pedestal_joint", "fixed", _ROOT, self._called(model.root), at)

    def _at_zero(self, link: str) -> Array:
        pose = self._model.pose(link, self._positions)
        return self._points[link] @ pose[:3, :3].T + pose[:3, 3]

    # ------------------------------------------------------------------ what follows from all of it

    def _measure(self) -> None:
        """Works out load, efforts, reach and home of the arm as it is written."""
        from skiros_py.motion.pinocchio.arm_model import ArmModel
        from skiros_py.motion.pinocchio.measures import find_home, holding_efforts, load_of, reach_above

        found, hand = self.found, self.found.fingers
        gripper = GripperSpec("gripper", hand.joints, "arm", hand.max_gap, hand.max_force)
        with TemporaryDirectory(prefix="skiros-robot-") as folder:
            file = Path(folder) / "robot.urdf"
            file.write_bytes(ET.tostring(self._without_visuals(Path(folder))))
            arm = ArmModel(file, ArmSpec("arm", found.arm, "tcp", (0.0,) * len(found.arm)), [gripper])
        mass, centre = load_of(arm)
        found.load = mass, centre.tolist()
        if self._effortless:
            efforts = _EFFORT_MARGIN * holding_efforts(arm, _PAYLOAD) + _EFFORT_LEAST
            for name, effort in zip(found.arm, efforts, strict=True):
                if name in self._effortless:
                    self._effortless[name].set("effort", f"{effort:.4g}")
            names = ", ".join(self._effortless)
            self._note(f"no greatest effort, assumed what holds the arm and {_PAYLOAD:.0f} kg, amply: {names}")
        found.reach = round(reach_above(arm, _TABLE + 0.06), 3)
        found.places = round(float(np.clip(0.72 * found.reach, 0.4, 0.8)), 2)
        home = find_home(arm, 0.6 * found.reach, _TABLE + 0.3)
        if home is None:
            raise UsageError("no posture with the hand down in front of the robot was found: choose the arm by --arm")
        found.home = tuple(round(float(angle), 4) + 0.0 for angle in home)

    def _without_visuals(self, folder: Path) -> ET.Element:
        urdf = copy.deepcopy(self.found.urdf)
        for link in urdf.findall("link"):
            for visual in link.findall("visual"):
                link.remove(visual)
        for mesh in urdf.iter("mesh"):
            name = mesh.get("filename", "")
            (folder / name).write_text(self.found.texts[name], encoding="utf-8")
            mesh.set("filename", str(folder / name))
        return urdf


def _hand_axes(first: Array, second: Array) -> tuple[Array, Array]:
    """Returns where fingers point and in which direction they open, the nearest axes of their palm."""
    middle = (np.concatenate([first, second]).max(axis=0) + np.concatenate([first, second]).min(axis=0)) / 2.0
    apart = first.mean(axis=0) - second.mean(axis=0)
    axis = int(np.argmax(np.abs(apart)))
    across = np.eye(3)[axis] * np.sign(apart[axis])
    middle[axis] = 0.0
    axis = int(np.argmax(np.abs(middle)))
    return np.eye(3)[axis] * np.sign(middle[axis]), across


def _scale(mesh: ET.Element) -> Array:
    return np.array((mesh.get("scale") or "1 1 1").split(), dtype=float)


def _corners(element: ET.Element, mesh_points) -> Array:  # type: ignore[no-untyped-def]
    """Returns points around a shape in the frame of its link."""
    shape = element.find("geometry")
    assert shape is not None
    shape = shape[0]
    if shape.tag == "mesh":
        points = mesh_points(shape)
    else:
        if shape.tag == "box":
            half = np.array(shape.get("size", "").split(), dtype=float) / 2.0
        elif shape.tag == "sphere":
            half = np.full(3, float(shape.get("radius", "0")))
        else:
            radius = float(shape.get("radius", "0"))
            half = np.array([radius, radius, float(shape.get("length", "0")) / 2.0])
        points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    pose = origin_of(element)
    return points @ pose[:3, :3].T + pose[:3, 3]  # type: ignore[no-any-return]


def _simple(points: Array) -> tuple[Array, str, dict[str, str]] | None:
    """Returns a box or cylinder around points that is hardly larger than their hull: pose, tag, size; else None."""
    low, high = points.min(axis=0), points.max(axis=0)
    size, volume = high - low, _volume(points)
    pose = np.eye(4)
    pose[:3, 3] = (low + high) / 2.0
    if volume <= 0.0:
        return pose, "box", {"size": _text(np.maximum(size, 0.002))}
    best: tuple[float, Array, str, dict[str, str]] = (float(size.prod()), pose, "box", {"size": _text(size)})
    for axis in range(3):
        others = [one for one in range(3) if one != axis]
        radius = float(np.linalg.norm((points - pose[:3, 3])[:, others], axis=1).max())
        filled = math.pi * radius**2 * float(size[axis])
        if filled < best[0]:
            turned = pose.copy()
            if axis != 2:
                turned[:3, :3] = Rotation.from_euler("xy"[1 - axis], math.pi / 2.0).as_matrix()
            best = (filled, turned, "cylinder", {"radius": f"{radius:.5g}", "length": f"{float(size[axis]):.5g}"})
    return best[1:] if best[0] <= _TIGHT * volume else None


def _volume(points: Array) -> float:
    try:
        return float(ConvexHull(points).volume)
    except (QhullError, ValueError):
        return 0.0


def _few(points: Array) -> tuple[Array, Array]:
    """Returns the hull of points with few corners: those that lie farthest out in evenly spread directions."""
    number = np.arange(_CORNERS) + 0.5
    height, turn = 1.0 - 2.0 * number / _CORNERS, math.pi * (1.0 + math.sqrt(5.0)) * number
    ring = np.sqrt(1.0 - height**2)
    directions = np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
    chosen = points[np.unique(np.argmax(points @ directions.T, axis=0))]
    hull = ConvexHull(chosen)
    index = {int(old): new for new, old in enumerate(hull.vertices)}
    corners = chosen[hull.vertices]
    middle = corners.mean(axis=0)
    faces = []
    for face in hull.simplices:
        a, b, c = (index[int(one)] for one in face)
        out = np.cross(corners[b] - corners[a], corners[c] - corners[a]) @ (corners[a] - middle) > 0.0
        faces.append((a, b, c) if out else (a, c, b))
    return corners, np.array(faces)


def _obj(points: Array, triangles: Array) -> str:
    lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in points.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()]
    return "\n".join(lines) + "\n"


def _eye(collision: ET.Element) -> ET.Element:
    visual = copy.deepcopy(collision)
    visual.tag = "visual"
    return visual


def _inertia(link: ET.Element) -> tuple[float, Array, Array] | None:
    """Returns mass [kg], tensor [kg m²] and centre [m] as a link states them."""
    inertial = link.find("inertial")
    if inertial is None:
        return None
    mass, tensor = inertial.find("mass"), inertial.find("inertia")
    value = {
        key: float((tensor.get(key) if tensor is not None else None) or "0")
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    }
    matrix = np.array(
        [
            [value["ixx"], value["ixy"], value["ixz"]],
            [value["ixy"], value["iyy"], value["iyz"]],
            [value["ixz"], value["iyz"], value["izz"]],
        ]
    )
    return float(mass.get("value", "0")) if mass is not None else 0.0, matrix, origin_of(inertial)[:3, 3]


def _absurd(mass: float, tensor: Array, centre: Array, points: Array) -> bool:
    """Returns whether no body of about that shape has such an inertia."""
    moments = np.linalg.eigvalsh(tensor)
    if mass <= 0.0 or moments[0] <= 0.0 or moments[2] > moments[0] + moments[1]:
        return True
    if not len(points):
        return False
    radius = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))
    outside = (centre < points.min(axis=0) - radius) | (centre > points.max(axis=0) + radius)
    return bool(moments[2] > 2.0 * mass * radius**2 or outside.any())


def _set_inertia(link: ET.Element, mass: float, tensor: Array, centre: Array) -> None:
    for old in link.findall("inertial"):
        link.remove(old)
    inertial = ET.Element("inertial")
    ET.SubElement(inertial, "origin", xyz=_text(centre))
    ET.SubElement(inertial, "mass", value=f"{mass:.5g}")
    keys = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    ET.SubElement(inertial, "inertia", {key: f"{float(tensor[at]):.5g}" for key, at in keys.items()})
    link.insert(0, inertial)


def _join(urdf: ET.Element, name: str, kind: str, parent: str, child: str, pose: Array) -> ET.Element:
    joint = ET.SubElement(urdf, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    _set_origin(joint, pose)
    return joint


def _set_origin(element: ET.Element, pose: Array) -> None:
    turn = pose[:3, :3]
    level = math.hypot(turn[0, 0], turn[1, 0])
    roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    if level < 1e-7:  # roll and yaw turn about one axis
        roll, yaw = math.atan2(-turn[1, 2], turn[1, 1]), 0.0
    angles = (roll, math.atan2(-turn[2, 0], level), yaw)
    ET.SubElement(element, "origin", xyz=_text(pose[:3, 3]), rpy=_text(angles))


def _text(values: Mapping[int, float] | Sequence[float] | Array) -> str:
    return " ".join(f"{float(value) + 0.0:.9g}" for value in values)

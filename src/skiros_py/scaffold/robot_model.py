"""A robot model as somebody else wrote it: what its URDF and SRDF say, what follows, and what has to be asked for."""

from __future__ import annotations

import importlib.util
import math
import re
import xml.etree.ElementTree as ET
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import metadata
from pathlib import Path

import numpy as np

from skiros_py.errors import FileError, UsageError
from skiros_py.geometry import Array, Pose

PARALLEL = "parallel"
"""Instead of the fingers of a model: a plain parallel gripper."""
_TURNS = ("revolute", "continuous")
_MOVES = (*_TURNS, "prismatic")
_FEWEST = 4
"""Number of joints from which a chain counts as an arm."""
_LEVEL = 0.006
"""Difference in reach between two fingers of one gripper [m]."""
_PAIR = 2
_TRIPLES = {"xyz", "rpy", "size", "scale"}
_SINGLES = {"radius", "length", "value", "lower", "upper", "velocity", "effort", "multiplier", "offset"}
_NUMBERS = _TRIPLES | _SINGLES | {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}
_OPTIONAL = re.compile(r"\$\(optenv \w+ ?([^()]*)\)")


class Undecided(UsageError):
    """The model does not tell something, and its author has to.

    Attributes:
        option: The field of the order that tells.
        question: What to ask.
    """

    def __init__(self, option: str, question: str, candidates: Iterable[str]) -> None:
        self.option = option
        shown = "; ".join(candidates)
        self.question = f"{question}: {shown}" if shown else question
        super().__init__(f"{self.question}. Say it by --{option}")


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint of a model.

    Attributes:
        element: The XML element.
        origin: Pose of its frame in the parent link, shape (4, 4).
        mimic: Name of the joint that it follows, factor and offset; None for a joint of its own.
    """

    element: ET.Element
    name: str
    type: str
    parent: str
    child: str
    origin: Array
    axis: Array
    lower: float
    upper: float
    mimic: tuple[str, float, float] | None

    def transform(self, position: float) -> Array:
        """Returns the pose of the child link in the parent link at a position [rad or m]."""
        if self.type in _TURNS:
            return self.origin @ Pose.turn(*(position * self.axis)).matrix()
        if self.type == "prismatic":
            x, y, z = (position * self.axis).tolist()
            return self.origin @ Pose((x, y, z)).matrix()
        return self.origin


@dataclass(frozen=True, slots=True)
class Gripper:
    """Two fingers that come together, as they stand on their palm when open.

    Attributes:
        palm: The link that carries them; the last one of the arm for a plain gripper.
        fingers: Their links; none for a plain gripper.
        joints: The joints that move them.
        positions: Where these and the joints that follow them are when it is open [rad or m].
        sliding: Whether the model has two fingers that slide, and nothing else.
    """

    palm: str
    fingers: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    positions: Mapping[str, float] = field(default_factory=dict)
    sliding: bool = False


class RobotDescription:
    """What a URDF file says, checked.

    Args:
        file: The file.

    Attributes:
        xml: The root element.
        links: Elements of the links by name.
        joints: The joints by name, in the order of the file.
        root: The link that carries all others.

    Raises:
        FileError: It is no URDF, two links or joints have one name, or the links are no tree.
    """

    def __init__(self, file: Path) -> None:
        self.file = file
        try:
            text = _OPTIONAL.sub(r"\1", file.read_text(encoding="utf-8"))
            self.xml = ET.fromstring(text)  # noqa: S314 - expat bounds entities
        except (OSError, UnicodeDecodeError) as error:
            raise FileError(file, f"cannot be read: {error}") from error
        except ET.ParseError as error:
            raise FileError(file, f"no XML: {error}") from error
        if self.xml.tag != "robot":
            raise FileError(file, f"no URDF: its first element is <{self.xml.tag}>, not <robot>")
        self.links = self._named("link")
        for tag, elements in (("link", self.links), ("joint", self._named("joint"))):
            for name, element in elements.items():
                if (wrong := _no_numbers(element)) is not None:
                    hint = "; a xacro file is to be expanded first" if "${" in text or "$(" in text else ""
                    raise FileError(file, f"{tag} {name} has what is no number: {wrong}{hint}")
        self.joints = {name: _joint(file, name, element) for name, element in self._named("joint").items()}
        same = sorted(set(self.links) & set(self.joints))
        if same:  # libraries look both up by name
            for name in same:
                self.joints[f"{name}_joint"] = replace(self.joints.pop(name), name=f"{name}_joint")
            renamed = {name: f"{name}_joint" for name in same}
            for name, joint in self.joints.items():
                if joint.mimic is not None and joint.mimic[0] in renamed:
                    self.joints[name] = replace(joint, mimic=(renamed[joint.mimic[0]], *joint.mimic[1:]))
        self.root = self._root()
        self.below: dict[str, list[Joint]] = defaultdict(list)
        self.above: dict[str, Joint] = {}
        for joint in self.joints.values():
            self.below[joint.parent].append(joint)
            self.above[joint.child] = joint

    def _named(self, tag: str) -> dict[str, ET.Element]:
        elements = self.xml.findall(tag)
        names = Counter(element.get("name", "") for element in elements)
        twice = sorted(name for name, count in names.items() if count > 1)
        if twice:
            raise FileError(self.file, f"two {tag}s with one name: {', '.join(twice)}")
        return {element.get("name", ""): element for element in elements}

    def _root(self) -> str:
        parents: dict[str, str] = {}
        for joint in self.joints.values():
            for link in (joint.parent, joint.child):
                if link not in self.links:
                    raise FileError(self.file, f"joint {joint.name} is at a link that is not there: {link or '(none)'}")
            if joint.child in parents:
                raise FileError(self.file, f"no tree: two joints carry the link {joint.child}")
            parents[joint.child] = joint.parent
        roots = [link for link in self.links if link not in parents]
        if len(roots) > 1:
            raise FileError(self.file, f"no tree: no joint connects the links {', '.join(roots[:5])}")
        reached = set(roots)
        while new := {child for child, parent in parents.items() if parent in reached} - reached:
            reached |= new
        if not roots or len(reached) < len(self.links):
            ring = sorted(set(self.links) - reached)
            raise FileError(self.file, f"no tree: the links {', '.join(ring[:5])} go round in a ring")
        return roots[0]

    # ------------------------------------------------------------------ kinematics

    def path(self, link: str, above: str = "") -> list[Joint]:
        """Returns the joints from a link above (the root) down to a link."""
        found: list[Joint] = []
        while link != (above or self.root):
            if link not in self.above:
                raise FileError(self.file, f"link {above} does not carry the other")
            found.insert(0, self.above[link])
            link = found[0].parent
        return found

    def subtree(self, link: str) -> Iterator[str]:
        """Yields a link and all that it carries."""
        yield link
        for joint in self.below[link]:
            yield from self.subtree(joint.child)

    def pose(self, link: str, positions: Mapping[str, float], above: str = "") -> Array:
        """Returns the pose of a link in one that carries it, shape (4, 4); joints left out are as near 0 as they go."""
        pose = np.eye(4)
        for joint in self.path(link, above):
            pose = pose @ joint.transform(self.position(joint, positions))
        return pose

    def position(self, joint: Joint, positions: Mapping[str, float]) -> float:
        """Returns where a joint is [rad or m], also one that follows another."""
        if joint.name in positions:
            return positions[joint.name]
        if joint.mimic is not None and joint.mimic[0] in self.joints:
            other, factor, offset = joint.mimic
            return factor * self.position(self.joints[other], positions) + offset
        return min(max(0.0, joint.lower), joint.upper)

    def moving(self, link: str) -> bool:
        """Returns whether a link carries a joint that moves."""
        return any(joint.type in _MOVES or self.moving(joint.child) for joint in self.below[link])

    # ------------------------------------------------------------------ the arm

    def arm(self, said: str, groups: Mapping[str, tuple[str, str]]) -> list[Joint]:
        """Returns the joints of the arm.

        Args:
            said: The first and the last link; empty to find them.
            groups: Chains of the SRDF, by name.

        Raises:
            Undecided: There are several.
            UsageError: There is none, or what was said is none.
        """
        if said:
            return self._said_arm(said)
        chains = list(self._chains())
        arms = [chain for chain in chains if len(chain) >= _FEWEST]
        chains = [one for one in chains if not any(self._carries(arm, one) for arm in arms)]
        best = max((len(chain) for chain in chains), default=0)
        if best < _FEWEST:
            longest = max(chains, key=len, default=[])
            raise UsageError(
                f"{self.file.name} has no arm: its longest chain of turning joints has {best}"
                f" ({', '.join(joint.name for joint in longest) or 'none'}), an arm at least {_FEWEST}"
            )
        found = [chain for chain in chains if len(chain) == best]
        if len(found) > 1:
            named = {ends: name for name, ends in groups.items()}
            ends = [(chain[0].parent, chain[-1].child) for chain in found]
            texts = [" ".join(two) + (f" (group {named[two]})" if two in named else "") for two in ends]
            raise Undecided("arm", f"{self.file.name} has {len(found)} arms; first and last link of one", texts)
        return found[0]

    def _carries(self, arm: list[Joint], other: list[Joint]) -> bool:
        return arm is not other and any(joint is arm[-1] for joint in self.path(other[-1].child)[: -len(other)])

    def _said_arm(self, said: str) -> list[Joint]:
        words = said.split()
        unknown = [word for word in words if word not in self.links]
        if len(words) != _PAIR or unknown:
            wrong = f"there is no link {', '.join(unknown)}" if unknown else "it takes two links"
            raise UsageError(f"--arm {said}: {wrong}; the links are {', '.join(self.links)}")
        if words[0] not in [self.root, *(joint.child for joint in self.path(words[1]))]:
            raise UsageError(f"--arm {said}: {words[0]} does not carry {words[1]}")
        chain = [joint for joint in self.path(words[1], words[0]) if joint.type in _MOVES]
        if not chain:
            raise UsageError(f"--arm {said}: no joint moves between them")
        return chain

    def _chains(self) -> Iterator[list[Joint]]:
        """Yields chains of turning joints: they end where a joint slides, is followed, or two ways go on."""
        led = {joint.mimic[0] for joint in self.joints.values() if joint.mimic}

        def walk(link: str, chain: list[Joint]) -> Iterator[list[Joint]]:
            ways = [joint for joint in self.below[link] if joint.type in _MOVES or self.moving(joint.child)]
            if len(ways) != 1:
                yield chain
                chain = []
            for joint in ways:
                own = joint.type in _TURNS and joint.mimic is None and joint.name not in led
                if joint.type in _MOVES and not own:
                    yield chain
                    yield from walk(joint.child, [])
                else:
                    yield from walk(joint.child, [*chain, joint] if own else chain)

        yield from (chain for chain in walk(self.root, []) if chain)

    # ------------------------------------------------------------------ the gripper

    def gripper(self, flange: str, said: str) -> Gripper:
        """Returns the gripper at the end of an arm.

        Args:
            flange: The last link of the arm.
            said: Links of its two fingers, or :data:`PARALLEL`; empty to find them.

        Raises:
            Undecided: There is none that can be told.
            UsageError: What was said is none.
        """
        if said == PARALLEL:
            return Gripper(flange)
        here = list(self.subtree(flange))
        if said:
            fingers = said.split()
            unknown = [one for one in fingers if one not in here[1:]]
            if len(fingers) != _PAIR or unknown:
                wrong = (
                    f"{', '.join(unknown)} is not behind the arm" if unknown else "it takes the links of two fingers"
                )
                raise UsageError(f"--gripper {said}: {wrong}; there are {', '.join(here[1:]) or 'none'}")
        else:
            fingers = self._fingers(flange)
        movers = {one: [joint for joint in self.path(one, flange) if joint.type in _MOVES] for one in fingers}
        paths = [[flange, *(joint.child for joint in self.path(one, flange))] for one in fingers]
        palm = [first for first, second in zip(*paths, strict=False) if first == second][-1]
        names = tuple(joint.name for own in movers.values() for joint in own)
        sliding = all([joint.type for joint in own] == ["prismatic"] for own in movers.values())
        return Gripper(palm, tuple(fingers), names, self._open(palm, fingers, movers), sliding)

    def _fingers(self, flange: str) -> list[str]:
        movers = [joint for link in self.subtree(flange) for joint in self.below[link] if joint.type in _MOVES]
        carried = [link for link in self.subtree(flange) if link != flange]
        if not movers:
            question = f"{self.file.name} has no gripper: no joint moves behind {flange}"
            asked = f"{question}; the links of two fingers, or '{PARALLEL}' for a plain gripper of its own"
            raise Undecided("gripper", asked, [link for link in carried if self.shapes(link)])
        last = [joint.child for joint in movers if not self.moving(joint.child)]
        reach = {link: float(np.linalg.norm(self.pose(link, {}, flange)[:3, 3])) for link in last}
        farthest = [link for link in last if reach[link] > max(reach.values()) - _LEVEL]
        if len(farthest) != _PAIR:
            question = f"{self.file.name} has {len(last)} moving ends behind {flange}, of which no two are a pair"
            asked = f"{question}; the links of two fingers, or '{PARALLEL}' for a plain gripper instead"
            raise Undecided("gripper", asked, last)
        return farthest

    def _open(self, palm: str, fingers: Sequence[str], movers: Mapping[str, list[Joint]]) -> dict[str, float]:
        """Returns the positions in which the fingers are farthest apart."""
        own = [joint for joints in movers.values() for joint in joints if joint.mimic is None]

        def apart(positions: Mapping[str, float]) -> float:
            first, second = (self._centre(link, positions, palm) for link in fingers)
            return float(np.linalg.norm(first - second))

        best: dict[str, float] = {}
        for joint in own:
            best[joint.name] = max((joint.lower, joint.upper), key=lambda end: apart({**best, joint.name: end}))
        return best

    def _centre(self, link: str, positions: Mapping[str, float], palm: str) -> Array:
        pose = self.pose(link, positions, palm)
        middle = self.links[link].find("inertial/origin")
        return (pose @ [*_numbers(None if middle is None else middle.get("xyz")), 1.0])[:3]

    def shapes(self, link: str) -> list[ET.Element]:
        """Returns the shapes of a link for collisions; those for the eye where there are none."""
        element = self.links[link]
        return element.findall("collision") or element.findall("visual")


def find_urdf(text: str) -> Path:
    """Returns a URDF file, given by its path or as one of an installed package ("pybullet_data:xarm/xarm6_robot.urdf").

    Raises:
        UsageError: There is no such file or package.
    """
    package, colon, name = text.partition(":")
    if not colon or Path(text).exists():
        if not Path(text).is_file():
            raise UsageError(f"there is no file {text}; one of an installed package is PACKAGE:PATH")
        return Path(text).absolute()
    spec = importlib.util.find_spec(package) if package.isidentifier() else None
    folders = list(spec.submodule_search_locations or ()) if spec else []
    places = [Path(folder) / name for folder in folders]
    try:
        places += [Path(str(file.locate())) for file in metadata.files(package) or () if str(file).endswith(f"/{name}")]
    except metadata.PackageNotFoundError:
        if not places:
            raise UsageError(f"{text}: no package '{package}' is installed") from None
    found = [place for place in places if place.is_file()]
    if not found:
        raise UsageError(f"{text}: the package '{package}' holds no file {name}")
    return found[0]


def find_mesh(urdf: Path, name: str) -> Path | None:
    """Returns the file of a mesh that a URDF file names; None where it is not there."""
    plain = name.removeprefix("file://")
    if Path(plain).is_absolute():
        return Path(plain) if Path(plain).is_file() else None
    for prefix in ("package://", "model://"):
        plain = plain.removeprefix(prefix)
    # The folder of a package is seldom called as its name where it is installed: its first word may be left out.
    for folder in urdf.parents:
        for within in (plain, plain.partition("/")[2]):
            if within and (folder / within).is_file():
                return folder / within
    return None


def read_srdf(file: Path, robot: RobotDescription) -> dict[str, tuple[str, str]]:
    """Reads a semantic description.

    Returns:
        First and last link of each group that is a chain, by name.

    Raises:
        FileError: It cannot be read, or is that of another robot.
    """
    try:
        xml = ET.parse(file).getroot()  # noqa: S314
    except (OSError, ET.ParseError) as error:
        raise FileError(file, f"no SRDF: {error}") from error
    named = {str(link.get("name")) for link in xml.iterfind("group/link")}
    chains = {str(chain.get("tip_link")) for chain in xml.iter("chain")} | {
        str(chain.get("base_link")) for chain in xml.iter("chain")
    }
    pairs = {str(pair.get(end)) for pair in xml.iter("disable_collisions") for end in ("link1", "link2")}
    unknown = sorted((named | chains | pairs) - set(robot.links))
    virtual = {str(joint.get("name")) for joint in xml.iter("virtual_joint")}
    joints = {str(joint.get("name")) for joint in xml.iterfind("group/joint")} - set(robot.joints) - virtual
    if unknown or joints:
        lacks = ", ".join([*unknown, *sorted(joints)][:5])
        other = f"; it is of '{xml.get('name')}'" if xml.get("name") != robot.xml.get("name") else ""
        raise FileError(file, f"the SRDF of another robot: {robot.file.name} has no {lacks}{other}")
    groups: dict[str, tuple[str, str]] = {}
    for group in xml.findall("group"):
        chain = group.find("chain")
        if chain is not None:
            groups[str(group.get("name"))] = (str(chain.get("base_link")), str(chain.get("tip_link")))
    return groups


def _no_numbers(element: ET.Element) -> str | None:
    """Returns the first attribute below an element that has to hold numbers and does not; None if all do."""
    for one in element.iter():
        for key in _NUMBERS.intersection(one.keys()):
            text, count = one.get(key, ""), 3 if key in _TRIPLES else 1
            try:
                good = len(text.split()) == count and all(map(math.isfinite, map(float, text.split())))
            except ValueError:
                good = False
            if not good:
                return f'{key}="{text}"'
    return None


def _joint(file: Path, name: str, element: ET.Element) -> Joint:
    ends = [element.find(tag) for tag in ("parent", "child")]
    parent, child = ("" if end is None else end.get("link", "") for end in ends)
    axis = element.find("axis")
    direction = np.array(_numbers(axis.get("xyz") if axis is not None else "1 0 0"))
    length = float(np.linalg.norm(direction))
    kind = element.get("type", "fixed")
    if kind in _MOVES and length == 0.0:
        raise FileError(file, f"the axis of joint {name} is 0 0 0")
    limit, follows = element.find("limit"), element.find("mimic")
    lower, upper = (-math.pi, math.pi) if kind != "prismatic" else (0.0, 0.0)
    if limit is not None and (kind != "continuous" or limit.get("lower")):
        lower, upper = float(limit.get("lower", "0")), float(limit.get("upper", "0"))
    mimic = None
    if follows is not None:
        mimic = (
            follows.get("joint", ""),
            float(follows.get("multiplier", "1")),
            float(follows.get("offset", "0")),
        )
    origin = origin_of(element)
    return Joint(element, name, kind, parent, child, origin, direction / (length or 1.0), lower, upper, mimic)


def origin_of(element: ET.Element) -> Array:
    """Returns the pose that an element's ``origin`` states, shape (4, 4)."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    (x, y, z), (roll, pitch, yaw) = _numbers(origin.get("xyz")), _numbers(origin.get("rpy"))
    return Pose.of(x, y, z, roll=roll, pitch=pitch, yaw=yaw).matrix()


def _numbers(text: str | None) -> tuple[float, float, float]:
    x, y, z = map(float, (text or "0 0 0").split())
    return x, y, z

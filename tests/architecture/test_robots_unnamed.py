"""What comes along works on any robot by its description: no skill or primitive names one, or its links and joints."""

from __future__ import annotations

import importlib.util
import io
import re
import tokenize
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from skiros_py.ports.kinematics import GROUP, RobotModel, write_robot_urdf

ROBOTS = sorted(entry_points(group=GROUP), key=lambda entry: entry.name)
EVERYWHERE = {
    "map",
    "base_link",
    "base_x",
    "base_y",
    "base_yaw",
    "scanner",
    "tcp",
    "palm",
    "flange",
    "forearm",
    "bumper",
}
"""Names of the common frames of mobile bases, and plain words that a sentence may need."""


def sources() -> list[Path]:
    found = []
    for package in ("skiros_primitives", "skiros_skills"):
        spec = importlib.util.find_spec(package)
        assert spec is not None
        assert spec.origin is not None
        found += sorted(Path(spec.origin).parent.glob("**/*.py"))
    return found


def words(path: Path) -> Iterator[tuple[int, str]]:
    """Yields the words of a file, comments and texts among them, with their lines."""
    for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline):
        yield from ((token.start[0], word) for word in re.findall(r"[a-z0-9_]+", token.string.lower()))


def names_of(robot: str, directory: Path) -> set[str]:
    """Returns the name of a robot, its parts, and the names of its links and joints."""
    urdf = ET.parse(write_robot_urdf(robot, directory)).getroot()
    inside = {str(one.get("name")).lower() for tag in ("link", "joint") for one in urdf.iter(tag)}
    makers = {word for word in robot.lower().split("_") if word not in ("mobile", "cell")}
    return {robot.lower(), *makers, *inside} - EVERYWHERE


def named(forbidden: set[str], paths: list[Path]) -> list[str]:
    return [f"{path.name}:{line} {word}" for path in paths for line, word in words(path) if word in forbidden]


@pytest.mark.parametrize("robot", [entry.name for entry in ROBOTS if isinstance(entry.load(), RobotModel)])
def test_no_skill_or_primitive_names_a_robot(robot: str, tmp_path: Path) -> None:
    assert len(sources()) > 20
    assert named(names_of(robot, tmp_path), sources()) == []


def test_a_module_that_names_a_robot_is_found(tmp_path: Path) -> None:
    module = tmp_path / "grasp.py"
    module.write_text('TIP = "camera_optical"  # of the UR10e\n', encoding="utf-8")

    found = named(names_of("ur10e_cell", tmp_path), [module])

    assert found == ["grasp.py:1 camera_optical", "grasp.py:1 ur10e"]

"""Skills and primitives work on every robot: they name no robot, and none of its links and joints."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from skiros_py.plugins.installation import installation
from skiros_py.plugins.loading import find_plugin
from skiros_py.ports.kinematics import BASE_JOINTS, BASE_LINK, GROUP, RobotModel, write_robot_urdf

ROOT = Path(__file__).parents[2]
FILES = [file for part in ("skills", "primitives") for file in sorted((ROOT / part / "src").rglob("*.py"))]
COMMON = {BASE_LINK, *BASE_JOINTS, "map", "tcp", "flange", "scanner", "bumper"}
"""Names of links and joints that the platform gives every robot on wheels, or that are ordinary words."""


def _names(robot: str, directory: Path) -> set[str]:
    model = ET.parse(write_robot_urdf(robot, directory)).getroot()
    parts = {part.get("name", "") for part in (*model.iter("link"), *model.iter("joint"))}
    words = {word for word in robot.split("_") if word not in ("mobile", "cell")}
    return (parts - COMMON) | words | {robot}


@pytest.mark.parametrize("robot", [entry.name for entry in installation().of(GROUP)])
def test_no_skill_and_no_primitive_names_a_robot_or_a_part_of_it(robot: str, tmp_path: Path) -> None:
    if not isinstance(find_plugin(GROUP, robot, kind="robot model"), RobotModel):
        pytest.skip("it has no model of its own")
    names = _names(robot, tmp_path)
    wanted = re.compile(rf"\b({'|'.join(map(re.escape, sorted(names)))})\b", re.IGNORECASE)

    found = {file.name: named for file in FILES if (named := wanted.findall(file.read_text(encoding="utf-8")))}

    assert found == {}

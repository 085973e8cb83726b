"""A robot model is found by its entry point, and is one URDF file for all who need it."""

from typing import Any

import pytest

from skiros_py.errors import UnknownName, UsageError
from skiros_py.ports.kinematics import write_robot_urdf

CODE = """
from pathlib import Path
from skiros_py.ports.kinematics import RobotModel
WRITTEN = RobotModel("written", lambda: "<robot name='written'/>")
FILE = RobotModel("file", Path(__file__).parent / "own.urdf")
FOLDER = Path(__file__).parent
"""


def test_an_unknown_model_is_refused_with_the_known_ones(tmp_path):
    with pytest.raises(UnknownName, match=r"unknown robot model 'mobile_pandas'.*Did you mean 'mobile_panda'\?"):
        write_robot_urdf("mobile_pandas", tmp_path)


@pytest.fixture
def robots(site: Any) -> Any:
    """A distribution with a robot whose URDF is composed, one whose URDF is a file, and individuals alone."""
    names = {"written": "sk_robots:WRITTEN", "file": "sk_robots:FILE", "folder": "sk_robots:FOLDER"}
    files = {"sk_robots/__init__.py": CODE, "sk_robots/own.urdf": "<robot name='own'/>"}
    site.install("sk-robots", {"robots": names}, files)
    return site


def test_a_composed_urdf_is_written_to_a_file_and_an_existing_file_is_used_in_place(robots, tmp_path):
    written, file = write_robot_urdf("written", tmp_path), write_robot_urdf("file", tmp_path)

    assert written == tmp_path / "written.urdf"
    assert written.read_text() == "<robot name='written'/>"
    assert file.parent != tmp_path
    assert file.read_text() == "<robot name='own'/>"


def test_a_robot_without_a_urdf_has_no_model(robots, tmp_path):
    with pytest.raises(UsageError, match="robot model 'folder' has no URDF"):
        write_robot_urdf("folder", tmp_path)

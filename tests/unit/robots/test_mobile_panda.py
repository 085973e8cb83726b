"""The mobile Panda's model: one file for simulation and kinematics, complete and mended."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from skiros_py.ports.kinematics import write_robot_urdf


@pytest.fixture
def model(tmp_path):
    return ET.parse(write_robot_urdf("mobile_panda", tmp_path)).getroot()


def test_the_links_form_one_tree_rooted_in_the_map(model):
    links = {link.get("name") for link in model.iter("link")}
    children = [joint.find("child").get("link") for joint in model.iter("joint")]

    assert links - set(children) == {"map"}
    assert len(children) == len(set(children))
    assert {joint.find("parent").get("link") for joint in model.iter("joint")} <= links
    assert {"base_link", "tcp", "camera_optical"} <= links


def test_every_mesh_exists_and_is_named_absolutely(model):
    paths = [Path(mesh.get("filename")) for mesh in model.iter("mesh")]

    assert len(paths) > 20
    assert all(path.is_absolute() and path.is_file() for path in paths)


def test_every_link_has_mass_and_fingers_have_a_small_inertia(model):
    masses = [float(link.find("inertial/mass").get("value")) for link in model.iter("link")]
    fingers = [link for link in model.iter("link") if "finger" in link.get("name")]

    assert min(masses) > 0.0
    assert [float(f.find("inertial/inertia").get("ixx")) for f in fingers] == [1e-4, 1e-4]
    assert not [finger for finger in fingers if finger.find("contact") is not None]


def test_two_runs_write_the_same_model(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    first, second = (write_robot_urdf("mobile_panda", tmp_path / name).read_bytes() for name in ("a", "b"))

    assert first == second

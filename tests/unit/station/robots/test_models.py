"""Models of robots as they are drawn: made once, kept, and whole."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
from contextlib import suppress
from pathlib import Path

import pytest

from skiros_py.errors import Busy, DeviceError, UnknownName
from skiros_py.ports.kinematics import BASE_JOINTS
from skiros_py.station.robots.models import MESHES, DrawnModel, RobotModels


def made(folder: Path) -> DrawnModel:
    """Returns a model however long that takes: many tests may run beside this one."""
    models = RobotModels(folder)
    try:
        while True:
            with suppress(Busy):
                return models.get("mobile_panda")
    finally:
        models.close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("data") / "models"


@pytest.fixture(scope="module")
def model(folder: Path) -> DrawnModel:
    return made(folder)


@pytest.fixture
def urdf(model: DrawnModel) -> ET.Element:
    return ET.fromstring(model.urdf)


def test_the_model_names_the_meshes_that_go_with_it_and_no_file_of_the_disk(
    model: DrawnModel, urdf: ET.Element
) -> None:
    named = {mesh.get("filename", "") for mesh in urdf.iter("mesh")}

    assert named == {f"{MESHES}{name}" for name in model.meshes}
    assert b'="/' not in model.urdf


def test_a_whole_robot_has_few_triangles(model: DrawnModel, urdf: ET.Element) -> None:
    files = [mesh.get("filename", "").removeprefix(MESHES) for mesh in urdf.iter("mesh")]

    assert 5_000 < sum(struct.unpack("<I", model.meshes[name][80:84])[0] for name in files) < 15_000
    assert sum(map(len, model.meshes.values())) < 1_000_000


def test_a_served_model_has_no_collision_shapes_and_every_visual_has_a_colour(urdf: ET.Element) -> None:
    assert not list(urdf.iter("collision")) + list(urdf.iter("inertial"))
    visuals = list(urdf.iter("visual"))
    assert len(visuals) > 20
    assert all(visual.find("material/color") is not None for visual in visuals)


def test_a_served_model_keeps_links_and_joints(urdf: ET.Element) -> None:
    joints = {joint.get("name") for joint in urdf.iter("joint")}

    assert {*BASE_JOINTS, "panda_joint1", "panda_finger_joint1"} <= joints
    assert {"map", "base_link", "tcp", "camera_optical"} <= {link.get("name") for link in urdf.iter("link")}


def test_a_built_model_is_cached(folder: Path, model: DrawnModel, monkeypatch: pytest.MonkeyPatch) -> None:
    def nobody_is_asked(*_arguments: object) -> None:
        pytest.fail("it is made again")

    monkeypatch.setattr("skiros_py.station.robots.models.Worker", nobody_is_asked)

    assert made(folder) == model


def test_a_model_with_a_missing_mesh_is_rebuilt(folder: Path, model: DrawnModel) -> None:
    next(folder.glob("*/*.stl")).unlink()

    assert made(folder) == model
    assert len(list(folder.glob("*/*.stl"))) == len(model.meshes)


def test_a_model_is_served_even_if_it_cannot_be_cached(tmp_path: Path, model: DrawnModel) -> None:
    (tmp_path / "models").write_text("no folder")

    assert made(tmp_path / "models") == model


def test_a_request_during_a_long_model_build_is_refused_as_busy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("skiros_py.station.robots.models._PATIENCE", 0.0)
    models = RobotModels(tmp_path)
    try:
        with pytest.raises(Busy, match="still being made"):
            models.get("mobile_panda")
    finally:
        models.close()


def test_requesting_an_unknown_robot_model_names_the_known_models(tmp_path: Path) -> None:
    models = RobotModels(tmp_path)
    try:
        with pytest.raises(UnknownName, match="mobile_panda"):
            models.get("tiny")
    finally:
        models.close()


def test_a_server_that_ends_does_not_wait_for_a_model(tmp_path: Path) -> None:
    models = RobotModels(tmp_path)
    models.prepare(["mobile_panda"])
    models.close()

    with pytest.raises(DeviceError):
        models.get("mobile_panda")
    assert not any(tmp_path.iterdir())

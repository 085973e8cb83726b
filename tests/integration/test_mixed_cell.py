"""One robot of a scene is simulated, the other has a driver of its own, at the address that its individual states."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from skiros_py.config import find_scene
from skiros_py.devices.gripper import GripperTarget
from skiros_py.devices.mobile_base import BaseTwist
from skiros_py.station.session import Options, Session

CODE = """
from skiros_py.simulation.fake.cell import FakeCell

ADDRESSES = []

class Real(FakeCell):
    kind = "real"

    def __init__(self, spec, *, seed):
        super().__init__(spec, seed=seed)
        ADDRESSES.extend(robot.address for robot in spec.robots)
"""


@pytest.mark.physics
def test_a_cell_mixes_simulated_and_real_robots(site: Any, tmp_path: Path) -> None:
    site.install("sk-real", {"drivers": {"real": "sk_real:Real"}}, {"sk_real.py": CODE})
    text = find_scene("kitting_two").read_text(encoding="utf-8")
    said = 'sk:builtLike scene:robot_1 ; sk:driver "real" ; sk:address "10.0.0.7"'
    (tmp_path / "mixed.ttl").write_text(text.replace("sk:builtLike scene:robot_1", said), encoding="utf-8")

    with Session(str(tmp_path / "mixed.ttl"), Options(seed=1)) as session:
        import sk_real  # type: ignore[import-not-found]

        before = session.cell.read()
        for _ in range(100):
            after = session.cell.exchange({"base_1": BaseTwist(0.2, 0.0), "base_2": BaseTwist(0.2, 0.0)})
        moved = {base: before.devices[base].pose.distance(after.devices[base].pose) for base in ("base_1", "base_2")}
        simulated, bodies = set(session.simulation.devices), session.simulation.scene.bodies

    assert sk_real.ADDRESSES == ["10.0.0.7"]
    assert moved["base_2"] == pytest.approx(0.1, abs=1e-6)  # at once, as that driver does
    assert 0.01 < moved["base_1"] < 0.095  # it has to accelerate
    assert "base_1" in simulated
    assert "base_2" not in simulated
    assert "starter_1" in bodies


@pytest.mark.physics
def test_one_device_of_a_simulated_robot_has_a_driver_at_its_own_address(site: Any, tmp_path: Path) -> None:
    site.install("sk-real", {"drivers": {"real": "sk_real:Real"}}, {"sk_real.py": CODE})
    text = find_scene("kitting").read_text(encoding="utf-8")
    said = text + 'scene:gripper_1 sk:driver "real" ; sk:address "/dev/ttyUSB0" .\n'
    (tmp_path / "grip.ttl").write_text(said, encoding="utf-8")

    with Session(str(tmp_path / "grip.ttl"), Options(seed=1)) as session:
        sk_real = pytest.importorskip("sk_real")

        for _ in range(3):
            after = session.cell.exchange({"gripper_1": GripperTarget(0.01, 10.0), "base_1": BaseTwist(0.2, 0.0)})
        simulated = set(session.simulation.devices)

    assert sk_real.ADDRESSES[-1] == "/dev/ttyUSB0"
    assert after.devices["gripper_1"].gap == 0.01  # at once, as that driver does
    assert simulated == {"base_1", "localiser_1", "scanner_1", "arm_1", "camera_1", "force_torque_1"}
    assert after.devices["base_1"].linear > 0.0

"""An inverse kinematics of a foreign distribution serves the built-in skills, without a line changed in the core."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from skiros_py.errors import UsageError
from skiros_py.ports.kinematics import InverseKinematics
from skiros_py.station.session import Options, Session

SOLVER = """
import os
from pathlib import Path

import numpy as np

from skiros_py.geometry import Pose
from skiros_py.ports.adapters import Adapter
from skiros_py.ports.kinematics import InverseKinematics, Kinematics

LOG = Path(__file__).with_suffix(".log")


class Transposed(InverseKinematics):
    '''Damped least squares on the error of the pose, with the robot's own Jacobian.'''

    def __init__(self, request):
        self.arm = request.device
        self.kinematics = request.ports.port(Kinematics, self.arm.id)
        ranges = [self.kinematics.joints[joint] for joint in self.arm.joints]
        self.lower, self.upper = np.array([[one.lower, one.upper] for one in ranges]).T
        LOG.write_text(f"{os.getpid()} {self.arm.id}")

    def solve(self, target, seed, *, towards=None, pulls=1, strength=0.2, iterations=40):
        goal, q = Pose.from_matrix(target), np.array(seed)
        for iteration in range(2 * iterations):
            at = dict(zip(self.arm.joints, q.tolist()))
            step = self.kinematics.pose(self.arm.tip, at).inverse() @ goal
            x, y, z, w = step.orientation
            turn = 2.0 * np.array([x, y, z]) * (1.0 if w >= 0.0 else -1.0)
            error = np.array([*step.position, *turn])
            pulled = towards is not None and iteration < pulls
            if not pulled and np.abs(error).max() < 1e-5:
                return q
            jacobian = self.kinematics.jacobian(self.arm.tip, at, self.arm.joints)
            drift = strength * (towards - q) if pulled else np.zeros(len(q))
            square = jacobian @ jacobian.T + (1e-9 + 1e-3 * float(error @ error)) * np.eye(6)
            move = drift + jacobian.T @ np.linalg.solve(square, error - jacobian @ drift)
            move *= min(1.0, 0.5 / max(1e-9, float(np.abs(move).max())))
            q = np.clip(q + move, self.lower, self.upper)
        return None


SOLVER = Adapter(
    (InverseKinematics,), Transposed, serves=lambda device: device.kind == "arm", one_for="device", eager=False
)
"""


@pytest.mark.physics
def test_a_part_is_picked_with_the_inverse_kinematics_of_a_foreign_distribution(site: Any) -> None:
    site.install("sk-solver", {"adapters": {"transposed": "sk_solver:SOLVER"}}, {"sk_solver.py": SOLVER})
    log = Path(site.folder) / "sk_solver.log"

    with Session("kitting", Options(seed=3, goal="Holding(gripper_1, starter_1)")) as session:
        report = session.run()

    assert report.reached, report
    assert log.read_text(encoding="utf-8").endswith("arm_1")


SCENE = """
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
<https://w3id.org/skiros-py/scenes/solver> a owl:Ontology ; owl:imports <https://w3id.org/skiros-py/core> .
scene:floor a sk:Floor . scene:unknown_location a sk:UnknownLocation .
scene:robot_1 a sk:Robot ; sk:model "mobile_panda" ; sk:at scene:unknown_location ; sk:hasA scene:arm_1 ;
    sk:pose "0 0 0 0 0 0"^^sk:poseLiteral %s.
scene:arm_1 a sk:Arm ; sk:tip "tcp" ; sk:home "0 -0.8 0 -2.4 0 1.6 0.8"^^sk:vectorLiteral ;
    sk:joints "panda_joint1 panda_joint2 panda_joint3 panda_joint4 panda_joint5 panda_joint6 panda_joint7" %s.
"""


@pytest.mark.parametrize(("robot", "arm"), [("", '; sk:adapter "right" '), ('; sk:adapter "right" ', "")])
def test_of_two_foreign_inverse_kinematics_the_one_that_the_scene_names_serves_the_arm(
    site: Any, tmp_path: Path, robot: str, arm: str
) -> None:
    for name in ("left", "right"):
        text = SOLVER.replace("eager=False", "eager=False, without_physics=True")
        site.install(f"sk-{name}", {"adapters": {name: f"sk_{name}:SOLVER"}}, {f"sk_{name}.py": text})
    scene = tmp_path / "solver.ttl"
    scene.write_text(SCENE % (robot, arm), encoding="utf-8")

    with Session(str(scene), Options(fake=True)) as session:
        session.runtime.context.port(InverseKinematics, "arm_1")

    assert [log.name for log in Path(site.folder).glob("*.log")] == ["sk_right.log"]
    scene.write_text(SCENE % ("", ""), encoding="utf-8")
    with pytest.raises(UsageError, match=r"InverseKinematics of arm_1: left of sk-left .* and right of sk-right"):
        Session(str(scene), Options(fake=True))

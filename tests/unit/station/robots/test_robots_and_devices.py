from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self

import pytest

from skiros_py.api.robots import Jog, JogBase
from skiros_py.errors import UsageError
from skiros_py.geometry import Pose
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.device import FakeRobot, Individual, MobileSpec
from skiros_py.station.robots import devices, robots
from skiros_py.station.session import Options, Session
from skiros_py.testing import TINY_ONTOLOGY

SCENE = """
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
<https://w3id.org/skiros-py/scenes/stationary> a owl:Ontology ; owl:imports <https://w3id.org/skiros-py/core> .
scene:floor a sk:Floor . scene:unknown_location a sk:UnknownLocation .
scene:robot_1 a sk:Robot ; sk:model "none" ; sk:at scene:unknown_location ; sk:hasA scene:arm_1 ;
    sk:pose "1 2 0 0 0 0"^^sk:poseLiteral .
scene:arm_1 a sk:Arm ; sk:joints "shoulder" ; sk:tip "tip" ; sk:home "0"^^sk:vectorLiteral .
"""


def test_a_robot_without_a_base_is_told_with_its_place_and_cannot_be_driven(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))
    file = tmp_path / "stationary.ttl"
    file.write_text(SCENE, encoding="utf-8")
    with Session(str(file), Options(fake=True)) as session:
        (robot,) = session.spec.robots
        info, reading = robots.info(session, robot), robots.reading(session, robot)

        assert (info.base, info.footprint) == (None, ())
        assert info.place is not None
        assert info.place.position == reading.pose.position == (1.0, 2.0, 0.0)
        assert reading.base is None
        assert [device.id for device in devices.device_infos(session)] == ["arm_1"]
        with pytest.raises(UsageError, match="there is none"):
            robots.jog(robot, Jog(base=JogBase(dx=0.1, dy=0.0, dyaw=0.0)))


@dataclass(frozen=True)
class Hover(MobileSpec[Pose, None]):
    """A base of another distribution."""

    kind: ClassVar[str] = "hovercraft"
    device_class: ClassVar[str] = "test:Hover"
    state_type: ClassVar[type] = Pose

    @classmethod
    def read(cls, individual: Individual) -> Self:
        return cls(individual.id, Pose(), ())

    def fake(self, robot: FakeRobot) -> None:
        return None

    def pose(self, state: Pose) -> Pose:
        return state


def test_a_base_of_any_kind_is_jogged() -> None:
    robot = RobotSpec("robot_1", "", (Hover("hover_1", Pose(), ()),))

    assert robots.jog(robot, Jog(base=JogBase(dx=0.0, dy=0.1, dyaw=0.0))) == (
        "jog_base",
        {"base": "hover_1", "robot": "robot_1", "dx": 0.0, "dy": 0.1, "dyaw": 0.0},
    )

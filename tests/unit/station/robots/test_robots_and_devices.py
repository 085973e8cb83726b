from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from skiros_py.geometry import Pose
from skiros_py.station.robots.devices import DeviceService
from skiros_py.station.robots.robots import RobotService
from skiros_py.station.session import Options, Session
from skiros_py.testing import TINY_ONTOLOGY
from skiros_py.world import vocabulary as v

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


def test_a_robot_without_a_base_is_described_with_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))
    file = tmp_path / "stationary.ttl"
    file.write_text(SCENE, encoding="utf-8")
    with Session(str(file), Options(fake=True)) as session:
        station: Any = SimpleNamespace(session=session)
        robots = RobotService(station)
        info, reading = robots.get("robot_1"), robots.reading("robot_1")

        assert (info.carrier, info.footprint) == (None, ())
        assert info.place is not None
        assert info.place.position == reading.pose.position == (1.0, 2.0, 0.0)
        assert [device.id for device in info.devices] == list(reading.devices) == ["arm_1"]
        assert [device.id for device in DeviceService(station).all()] == ["arm_1"]


AT_PALLET_A = Pose.of(5.0 - 0.78, 1.6, 0.0)
"""Where a robot works at pallet A of the kitting scene."""


def where(session: Session) -> Pose:
    """Returns where the robot stands in the next cycle."""
    session.cycle.step()
    return session.spec.robots[0].pose(session.cycle.board.snapshot, session.cycle.board.guard)


def test_a_robot_without_physics_stands_where_it_is_believed_to_be() -> None:
    with Session("kitting", Options(fake=True)) as session:
        start = where(session)
        with session.world.transaction("anna", "moves it") as tx:
            tx.place("robot_1", v.AT, "pallet_a")
        moved = where(session)
        with session.world.transaction("anna", "moves it") as tx:
            tx.place("robot_1", v.AT, "floor")
        on_the_floor = where(session)
        with session.world.transaction("anna", "moves it") as tx:
            tx.set("base_1", v.POSE, Pose.of(1.0, -2.0, 0.0))

        assert (start, moved, on_the_floor) == (Pose(), AT_PALLET_A, AT_PALLET_A)
        assert where(session) == Pose.of(1.0, -2.0, 0.0)


def test_a_robot_without_physics_stands_where_its_skill_has_taken_it_also_after_a_restart(tmp_path: Path) -> None:
    options = Options(fake=True, data=tmp_path / "data")
    with Session("kitting", options) as session:
        session.run("RobotAtLocation(robot_1, pallet_a)")
        driven = where(session)
    with Session("", options) as again:
        assert (driven, where(again)) == (AT_PALLET_A, AT_PALLET_A)

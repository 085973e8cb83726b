"""A data directory opened again after a part was left in the gripper."""

from pathlib import Path

import pytest

from skiros_py.geometry import Pose
from skiros_py.skills.restart import respawn
from skiros_py.station.session import Options, Session
from skiros_py.world.change import Writer


def leave_a_part_in_the_gripper(data: Path) -> None:
    with Session("kitting", Options(fake=True, data=data)) as session:
        assert session.run("Holding(gripper_1, starter_1)").reached


def test_a_fake_robot_still_holds_its_part_after_a_restart(tmp_path: Path) -> None:
    leave_a_part_in_the_gripper(tmp_path / "data")
    with Session("kitting", Options(fake=True, data=tmp_path / "data")) as session:
        report = session.run("InKit(Starter, kit_1)")
    assert report.reached
    assert [step.skill for step in report.steps] == ["drive", "place"]


def test_a_simulation_restarts_with_a_held_part_at_its_previous_place_and_the_robot_at_an_unknown_one(
    tmp_path: Path,
) -> None:
    from skiros_py.station.worlds import open_data

    leave_a_part_in_the_gripper(tmp_path / "data")
    with open_data(tmp_path / "data", create=False) as directory:
        world = directory.world
        with world.transaction("grasp", "it is between the fingers", writer=Writer.SKILL) as tx:
            tx.relate("starter_1", "sk:poseFrame", "gripper_1")
            tx.set("starter_1", "sk:pose", Pose((0.0, 0.0, 0.1)))
        respawn(world, directory.journal)
        assert (world.value("starter_1", "sk:pose"), world.objects("starter_1", "sk:poseFrame")) == (None, ())
        assert (world.placement("starter_1").relation, world.placement("starter_1").place) == ("sk:in", "pallet_a")
        assert world.placement("robot_1").place == "unknown_location"
        assert world.changes[-1].writer is Writer.SYSTEM
        before = world.version
        respawn(world, directory.journal)
        assert world.version == before


@pytest.mark.physics
def test_a_goal_is_reached_in_physics_after_a_restart_with_a_part_in_the_gripper(tmp_path: Path) -> None:
    leave_a_part_in_the_gripper(tmp_path / "data")
    with Session("kitting", Options(data=tmp_path / "data")) as session:
        report = session.run("InKit(Starter, kit_1)")
    assert report.reached
    assert all(condition.true for condition in report.conditions)


def test_reopening_a_world_writes_no_changes(tmp_path: Path) -> None:
    versions = []
    for _ in range(3):
        with Session("kitting", Options(fake=True, data=tmp_path / "data")) as session:
            versions.append(session.world.version)
            assert len(session.world.instances("sk:Skill")) == 5
    assert len(set(versions)) == 1


def test_a_part_at_an_unknown_place_is_missing_when_a_simulation_starts(tmp_path: Path) -> None:
    from skiros_py.station.worlds import open_data

    with open_data(tmp_path / "data", "kitting") as directory:
        world = directory.world
        with world.transaction("watch", "it fell") as tx:
            tx.place("starter_1", "sk:on", "floor")
        respawn(world, directory.journal)
        assert world.placement("starter_1").place == "unknown_location"
        assert world.value("starter_1", "sk:missing") is True


def test_a_failed_restart_does_not_change_the_world(tmp_path: Path) -> None:
    from skiros_py.errors import DescriptionError
    from skiros_py.station.worlds import open_data

    def refuse(_view: object) -> None:
        raise DescriptionError("no room")

    leave_a_part_in_the_gripper(tmp_path / "data")
    with open_data(tmp_path / "data", create=False) as directory:
        before = directory.world.version
        with pytest.raises(DescriptionError, match="no room"):
            respawn(directory.world, directory.journal, refuse)
        assert directory.world.version == before


SCENE = """
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
<https://example.org/scenes/restart> a owl:Ontology ; owl:imports <https://w3id.org/skiros-py/core> .
scene:this a sk:Scene . scene:floor a sk:Floor . scene:unknown_location a sk:UnknownLocation .
scene:dock a sk:Container ; sk:on scene:floor . scene:store a sk:Container ; sk:on scene:floor .
scene:robot_1 a sk:Robot ; sk:model "tiny" ; sk:at scene:store ; sk:hasA scene:{part} . scene:{part} a sk:{kind} .
"""


@pytest.mark.parametrize(
    ("part", "kind", "start", "place"),
    [
        ("base_1", "Base", "", "unknown_location"),
        ("base_1", "Base", "scene:robot_1 sk:startLocation scene:dock .", "dock"),
        ("arm_1", "Arm", "", "store"),
        ("arm_1", "Arm", "scene:robot_1 sk:startLocation scene:store .", "store"),
    ],
)
def test_after_a_restart_a_base_is_at_its_start_and_a_robot_without_a_base_keeps_its_place(
    tmp_path: Path, part: str, kind: str, start: str, place: str
) -> None:
    from skiros_py.station.worlds import open_data

    scene = tmp_path / "restart.ttl"
    scene.write_text(SCENE.format(part=part, kind=kind) + start, encoding="utf-8")
    with open_data(tmp_path / "data", str(scene)) as directory:
        respawn(directory.world, directory.journal)
        placement = directory.world.placement("robot_1")
        changes = [change.reason for change in directory.world.changes if change.author == "simulation"]

    assert placement is not None
    assert placement.place == place
    assert changes == (["restarts"] if place != "store" else [])

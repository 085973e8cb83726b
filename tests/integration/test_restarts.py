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


def test_a_robot_that_pretends_goes_on_with_what_it_holds(tmp_path: Path) -> None:
    leave_a_part_in_the_gripper(tmp_path / "data")
    with Session("kitting", Options(fake=True, data=tmp_path / "data")) as session:
        report = session.run("InKit(Starter, kit_1)")
    assert report.reached
    assert [step.skill for step in report.steps] == ["drive", "place"]


def test_a_simulation_starts_with_the_part_where_it_was_taken_and_the_robot_anywhere(tmp_path: Path) -> None:
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
def test_physics_goes_on_after_a_restart_with_a_part_in_the_gripper(tmp_path: Path) -> None:
    leave_a_part_in_the_gripper(tmp_path / "data")
    with Session("kitting", Options(data=tmp_path / "data")) as session:
        report = session.run("InKit(Starter, kit_1)")
    assert report.reached
    assert all(condition.true for condition in report.conditions)


def test_opening_a_world_again_writes_down_nothing_that_is_known(tmp_path: Path) -> None:
    versions = []
    for _ in range(3):
        with Session("kitting", Options(fake=True, data=tmp_path / "data")) as session:
            versions.append(session.world.version)
            assert len(session.world.instances("sk:Skill")) == 3
    assert len(set(versions)) == 1


def test_a_part_that_nobody_knows_the_place_of_is_missing_when_a_simulation_starts(tmp_path: Path) -> None:
    from skiros_py.station.worlds import open_data

    with open_data(tmp_path / "data", "kitting") as directory:
        world = directory.world
        with world.transaction("watch", "it fell") as tx:
            tx.place("starter_1", "sk:on", "floor")
        respawn(world, directory.journal)
        assert world.placement("starter_1").place == "unknown_location"
        assert world.value("starter_1", "sk:missing") is True


def test_where_a_restart_would_fail_nothing_is_believed_otherwise(tmp_path: Path) -> None:
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
def test_after_a_restart_a_base_is_where_it_starts_and_a_robot_without_one_stays(
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

"""A world takes an author a few lines."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import FileError, UnknownName
from skiros_py.skills.cell_reader import read_cell
from skiros_py.testing import TINY_ONTOLOGY, Bench, tiny_scene, world_of


def test_two_lines_of_turtle_make_a_world_with_floor_and_robot() -> None:
    world = world_of("scene:box_1 a sk:Container ; sk:on scene:floor .")

    assert world.objects("box_1", "sk:on") == ("floor",)
    assert world.instances("sk:Robot") == ("robot_1",)
    assert world.instances("sk:UnknownLocation") == ("unknown_location",)


def test_further_ontologies_bring_their_prefixes() -> None:
    world = world_of(
        "scene:box_1 a tiny:Box ; sk:on scene:floor .\nscene:ball_1 a tiny:Ball ; sk:in scene:box_1 .",
        ontologies=[TINY_ONTOLOGY],
    )

    assert world.objects("ball_1", "sk:in") == ("box_1",)
    with Bench(world) as bench:
        assert bench.pursue("Holding(gripper_1, ball_1)").reached


@pytest.mark.parametrize("count", [0, 1, 3])
def test_as_many_robots_as_wanted(count: int) -> None:
    world = world_of("", robots=count)

    assert len(world.instances("sk:Robot")) == count
    assert len(read_cell(world, world.instances("sk:Robot")).robots) == count


def test_robots_of_a_file_are_imported_by_its_iri() -> None:
    world = world_of(
        'scene:base_1 sk:pose "0 0 0 0 0 0"^^sk:poseLiteral .',
        imports=["https://w3id.org/skiros-py/robots/mobile_panda"],
    )

    assert "camera_1" in world.instances("sk:Camera")


def test_statements_in_the_text_are_not_added_again() -> None:
    world = world_of('scene:hall a sk:Floor ; rdfs:label "hall" .')

    assert world.instances("sk:Floor") == ("hall",)


def test_a_scene_is_taken_by_name_or_by_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(TINY_ONTOLOGY))
    file = tiny_scene(tmp_path)

    assert world_of("kitting").has("kit_1")
    assert world_of(file).has("ball_1")
    assert world_of(str(file)).has("ball_1")
    with pytest.raises(UnknownName, match="kitting"):
        world_of("kiting")


def test_a_mistake_is_told_with_its_line() -> None:
    with pytest.raises(FileError) as refused:
        world_of("scene:box_1 a sk:Container ;\n    sk:on scene:floor .\nscene:box_2 a sk:Contaner .")

    assert "sk:Contaner" in str(refused.value)
    assert refused.value.line == 3

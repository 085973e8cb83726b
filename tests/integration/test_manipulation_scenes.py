"""The small version of benchmarks/manipulation.py: what its generators draw, and how a running scene is judged."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from manipulation import CAMPAIGNS
from manipulation_scenes import Chance, Scene
from manipulation_stage import Forces, Stage, Trial, at_most, conditions, honest, none, share
from table import Figure, finish_side_by_side

from skiros_py.config import ONTOLOGIES
from skiros_py.geometry import Pose
from skiros_py.simulation.spawn import start_poses
from skiros_py.simulation.truth import RobotContact
from skiros_py.skills.cell_reader import read_cell
from skiros_py.station.session import Options, Session
from skiros_py.station.worlds import open_world
from skiros_py.tasks.report import ConditionReport


@pytest.fixture(autouse=True)
def _own_ontologies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(ONTOLOGIES, os.environ.get(ONTOLOGIES, ""))  # set back, whatever a stage makes of it


def scene(campaign: str, seed: int) -> Scene:
    return CAMPAIGNS[campaign].scene(seed)


@pytest.mark.parametrize("campaign", sorted(CAMPAIGNS))
def test_generated_scenes_are_scene_files_with_room_for_all_that_stands_in_them(
    campaign: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for seed in range(4):
        drawn = scene(campaign, seed)
        path = drawn.write(tmp_path / drawn.name)
        monkeypatch.setenv(ONTOLOGIES, str(path.parent / "parts"))
        world = open_world(str(path))
        cell = read_cell(world, world.instances("sk:Robot"))

        assert set(world.goals) == set(drawn.goals)
        assert start_poses(cell, seed).keys() == {body.id for body in cell.bodies}


@pytest.mark.parametrize("campaign", ["compartments", "standing"])
def test_the_goal_of_a_generated_scene_can_be_planned(
    campaign: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = scene(campaign, 1).write(tmp_path)
    monkeypatch.setenv(ONTOLOGIES, str(tmp_path / "parts"))

    with Session(str(path), Options(fake=True)) as session:
        assert session.run().reached


def test_a_seed_draws_the_same_scene_again_and_another_seed_another_one() -> None:
    assert scene("standing", 3).turtle == scene("standing", 3).turtle
    assert scene("standing", 3).turtle.replace("_3", "_5") != scene("standing", 5).turtle


def test_odd_and_even_seeds_draw_from_different_halves_of_each_range() -> None:
    odd, even = ([Chance(seed).within(0.0, 4.0) for seed in range(first, 400, 2)] for first in (1, 0))

    assert {int(number) for number in odd} == {0, 2}
    assert {int(number) for number in even} == {1, 3}


def test_forces_are_averaged_over_ten_milliseconds_and_over_half_a_second() -> None:
    forces = Forces()
    for cycle, force in ((10, 100.0), (11, 300.0), (12, 0.0), (13, 50.0)):
        forces.note(cycle, [RobotContact("panda_hand", "rack_1", 0.0, force)])

    assert forces.transient("rack_1") == 200.0
    assert forces.held("rack_1") == pytest.approx(4.5)
    assert forces.links == {"rack_1": {"panda_hand"}}
    assert forces.transient("table") == forces.held("table") == 0.0


def trial(*pairs: tuple[bool, bool]) -> Trial:
    reports = [ConditionReport("InKit(Post, kit_1)", believed, true, 1) for believed, true in pairs]
    return Trial(scene("standing", 1), reports, [], {}, {}, [])


def test_bars_are_held_against_the_truth_and_not_against_the_belief() -> None:
    good, lie = trial((True, True), (True, True)), trial((True, False), (True, True))

    assert conditions([good, lie], 75.0).holds
    assert not conditions([good, lie], 76.0).holds
    assert honest([good]).holds
    assert not honest([good, lie]).holds
    assert not share("nothing was tried", [], 0.0).holds
    assert not none("hits", [False, True]).holds
    assert not at_most("force", [100.0, 300.0], 280.0, "N").holds


def test_engines_are_shown_side_by_side_and_each_miss_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    good, bad = ([conditions([trial((True, true))], 75.0), Figure("scenes", "1")] for true in (True, False))

    assert finish_side_by_side("standing", {"one": good, "other": good}) == 0
    capsys.readouterr()
    assert finish_side_by_side("standing", {"one": good, "other": bad}) == 1
    head, first, second, summary = capsys.readouterr().out.splitlines()
    assert head.split() == ["figure", "bar", "one", "other"]
    assert "  >= 75 %  1 of 1, 100.0 %  ok  0 of 1, 0.0 %  MISSED" in first
    assert second.split() == ["scenes", "1", "1"]
    assert summary == "standing: 1 of 4 bars missed: other: conditions that hold by the truth"


@pytest.mark.physics
def test_what_is_done_to_a_running_scene_is_seen_by_the_truth_and_judged(tmp_path: Path) -> None:
    campaign = CAMPAIGNS["compartments"]
    with Stage(scene("compartments", 1), tmp_path, pictures=True) as stage:
        cell, before = stage.session.simulation, stage.truth.placements()
        inside = [part for part, place in before.items() if place.startswith("kit_1_")]
        stage.shift([*inside, "kit_1"], "kit_1", Pose.of(0.03, -0.02, 0.0, yaw=0.17))
        after = dict(stage.truth.placements())
        over = stage.truth.pose("part_3") @ Pose((0.0, 0.0, 0.075))
        cell.move_body("part_1", over)
        stage.later(0.2, lambda: cell.move_body("part_2", over @ Pose((0.0, 0.0, 1.0))))
        for _ in range(100):
            stage.session.cycle.step()
        misses = list(campaign.faults(stage, dict.fromkeys(stage.lying_on_parts(), 1.0)))
        stage.shoot("a picture")

        assert len(inside) == 2
        assert after == before
        assert stage.moved("kit_1") == pytest.approx(0.036, abs=0.001)
        assert misses == ["part_1 was put onto another part"]
        assert stage.moved("part_2") > 0.5
        assert stage.shots[0][1].result().shape == (360, 480, 3)
        assert list(campaign.must_not_touch(stage)) == ["kit_table", "pallet_1"]

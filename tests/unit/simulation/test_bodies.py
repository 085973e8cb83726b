"""Bodies stand where they should, ride along when bolted, and people can move them behind the robot's back."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from skiros_py.devices.mobile_base import BaseTwist
from skiros_py.errors import DescriptionError, DeviceError, UnknownName, UsageError
from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.ports.cell import BodySpec
from skiros_py.simulation import spawn
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.simulation.truth import Truth


def _parts_on(kitting, place):
    return [part.body(None, place, name) for name, part in kitting.PARTS.items()]


@pytest.mark.parametrize("seed", range(5))
def test_randomly_placed_parts_rest_upright_and_apart_at_their_place(make_cell, kitting, seed):
    cell = make_cell(kitting.cell_spec(*_parts_on(kitting, "table")), seed)
    truth = Truth(cell)
    poses = [truth.pose(name) for name in kitting.PARTS]
    distances = [a.distance(b) for n, a in enumerate(poses) for b in poses[:n]]

    assert set(truth.placements().values()) == {"table"}
    assert min(distances) > 0.129
    assert [pose.position[2] for pose in poses] == pytest.approx([kitting.TOP] * 4, abs=5e-4)
    assert min(pose.matrix()[2, 2] for pose in poses) > 0.9999


def test_parts_with_a_pose_rest_exactly_there(make_cell, kitting):
    wanted = Pose.of(0.7, 0.1, kitting.TOP, yaw=1.0)
    cell = make_cell(kitting.cell_spec(kitting.PARTS["Starter"].body(wanted, "table")))
    for _ in range(400):
        cell.exchange({})
    pose = Truth(cell).pose("part")

    assert pose.distance(wanted) < 2e-4
    assert pose.yaw == pytest.approx(1.0, abs=1e-3)


def test_a_body_of_many_primitives_carries_what_lies_on_any_of_them(make_cell, kitting):
    tiles = [Primitive("box", (0.05, 0.05, 0.02), Pose((0.05 * (n - 19.5), 0.0, 0.01))) for n in range(40)]
    plank = BodySpec("plank", "test:Plank", Solid(tuple(tiles)), pose=Pose((1.5, 1.5, 0.5)))
    ends = [BodySpec(f"cube_{n}", "test:Cube", Solid.box(0.03, 0.03, 0.03), 0.2, Pose((x, 1.5, 0.52)))
            for n, x in enumerate((0.525, 2.475))]  # fmt: skip
    cell = make_cell(kitting.cell_spec(plank, *ends))
    for _ in range(200):
        cell.exchange({})
    heights = [Truth(cell).pose(cube.id).position[2] for cube in ends]
    touched = {contact.other for cube in ends for contact in cell.scene.engine.contacts(cube.id)}
    cell.move_body("plank", Pose((1.5, 1.5, 1.0)))
    ray = cell.scene.engine.cast_rays(np.array([[2.475, 1.5, 1.5]]), np.array([[2.475, 1.5, 0.6]]))

    assert heights == pytest.approx([0.52] * 2, abs=1e-3)
    assert touched == {"plank"}
    assert ray[0] is not None
    assert ray[0].body == "plank"


def test_a_place_without_room_is_refused_by_name(make_cell, kitting):
    many = [kitting.PARTS["Starter"].body(None, "table", f"s{n}") for n in range(60)]

    with pytest.raises(DescriptionError, match="no room on 'table' for s0"):
        make_cell(kitting.cell_spec(*many))


def test_too_many_parts_are_refused_before_any_is_placed(make_cell, kitting, monkeypatch):
    many = [kitting.PARTS["Starter"].body(None, "table", f"s{n}") for n in range(1000)]
    monkeypatch.setattr(spawn, "_draw", None)  # to call it would be another error

    with pytest.raises(DescriptionError, match=r"no room on 'table' for s0.* and 992 more"):
        make_cell(kitting.cell_spec(*many))


@pytest.mark.parametrize("place", [None, "nowhere"])
def test_a_part_with_neither_pose_nor_place_is_refused(make_cell, kitting, place):
    with pytest.raises(DescriptionError, match="part: "):
        make_cell(kitting.cell_spec(kitting.PARTS["Starter"].body(None, place)))


def test_a_kit_on_the_deck_moves_with_the_robot_and_keeps_its_contents(make_cell, kitting):
    kit = kitting.kit(Pose((-0.27, 0.0, 0.35)), carrier="base")
    start = Pose.of(-2.0, 0.5, 0.0, yaw=0.8)
    in_kit = kitting.PARTS["Compressor"].body(None, "kit_2")
    cell = make_cell(kitting.cell_spec(*kit, in_kit, start=start))
    truth = Truth(cell)

    for twist in [BaseTwist(0.5, 0.0)] * 500 + [BaseTwist(0.0, 0.8)] * 400 + [BaseTwist(-0.5, 0.4)] * 300:
        cell.exchange({"base": twist})
    for _ in range(200):
        cell.exchange({})
    mounted = truth.base_pose("base").inverse() @ truth.pose("kit")

    assert truth.base_pose("base").distance(start) > 1.0
    assert mounted.position == pytest.approx((-0.27, 0.0, 0.35), abs=5e-4)
    assert mounted.yaw == pytest.approx(0.0, abs=1e-3)
    assert truth.placements() == {"part": "kit_2"}


def test_moving_a_body_does_not_change_the_snapshot(make_cell, kitting):
    part = kitting.PARTS["Alternator"].body(Pose((0.7, 0.0, kitting.TOP)), "table")
    touched, left_alone = make_cell(kitting.cell_spec(part)), make_cell(kitting.cell_spec(part))

    touched.move_body("part", Pose((0.7, 0.25, kitting.TOP)))
    after = [cell.exchange({}) for cell in (touched, left_alone)]

    assert after[0] == after[1]
    assert Truth(touched).pose("part").position[1] == pytest.approx(0.25, abs=1e-3)


def test_a_removed_body_is_gone_and_its_id_free_again(make_cell, kitting):
    part = kitting.PARTS["Alternator"].body(Pose((0.7, 0.0, kitting.TOP)), "table")
    cell = make_cell(kitting.cell_spec(part))

    cell.remove_body("part")

    assert "part" not in Truth(cell).placements()
    with pytest.raises(UnknownName, match="unknown body 'part'"):
        cell.move_body("part", Pose())
    cell.add_body(dataclasses.replace(part, pose=Pose((0.8, 0.0, kitting.TOP))))
    assert Truth(cell).placements() == {"part": "table"}


def test_a_bolted_body_is_not_moved_by_hand(make_cell, kitting):
    cell = make_cell(kitting.cell_spec(*kitting.kit(Pose((-0.27, 0.0, 0.35)), carrier="base")))

    with pytest.raises(UsageError, match="bolted to 'base'"):
        cell.move_body("kit", Pose())


def test_a_window_without_a_display_is_refused_with_the_alternative(monkeypatch, kitting):
    monkeypatch.delenv("DISPLAY", raising=False)

    with pytest.raises(UsageError, match="run without the window"):
        SimulatedCell(kitting.cell_spec(), seed=1, gui=True)


def test_exceptions_of_the_library_become_device_errors(make_cell, kitting):
    cell = make_cell(kitting.cell_spec())

    with pytest.raises(DeviceError, match="PyBullet, getJointInfo"):
        cell.scene.engine.client.getJointInfo(999, 0)


def test_a_closed_cell_can_be_closed_again_and_leaves_no_files(kitting):
    cell = SimulatedCell(kitting.cell_spec(), seed=1)
    urdf = Path(cell._directory.name) / "mobile_panda.urdf"
    existed = urdf.exists()

    cell.close()
    cell.close()

    assert existed
    assert not urdf.exists()


def test_the_bounding_box_of_a_body_matches_its_solid(make_cell, kitting):
    """The physics body's box around it is the solid's, whatever its centre of mass."""
    cell = make_cell(kitting.cell_spec(kitting.PARTS["Starter"].body(Pose((0.7, 0.0, kitting.TOP)), "table")))
    engine = cell.scene.engine
    low, high = engine.client.getAABB(engine.bodies["part"].index)
    expected_low, expected_high = cell.scene.bodies["part"].solid.bounds()

    assert np.subtract(high, low) == pytest.approx(expected_high - expected_low, abs=0.006)
    assert np.add(low, high) / 2 == pytest.approx(
        (0.7, 0.0, kitting.TOP) + (expected_low + expected_high) / 2, abs=2e-3
    )

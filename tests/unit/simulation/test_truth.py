"""The judge: where a part really is, by physics and geometry."""

import pytest

from skiros_py.geometry import Pose
from skiros_py.simulation.truth import Truth

KIT = (0.92, 0.0)
FLOOR_OF_COMPARTMENT = 0.506


def _place(kitting, make_cell, pose, part="Compressor"):
    bodies = (*kitting.kit(Pose((*KIT, kitting.TOP)), place="table"), kitting.PARTS[part].body(pose, "table"))
    return make_cell(kitting.cell_spec(*bodies))


def _in_front_left(x=0.0, y=0.0, **angles):
    return Pose.of(KIT[0] + 0.073 + x, KIT[1] + 0.073 + y, FLOOR_OF_COMPARTMENT, **angles)


def test_a_part_that_stands_in_a_compartment_is_in_it(make_cell, kitting):
    assert Truth(_place(kitting, make_cell, _in_front_left(yaw=0.3))).placements() == {"part": "kit_3"}


def test_a_part_on_a_wall_is_on_the_kit_and_in_no_compartment(make_cell, kitting):
    above_the_middle_wall = Pose.of(KIT[0], 0.073, kitting.TOP + 0.006 + 0.033)

    assert Truth(_place(kitting, make_cell, above_the_middle_wall)).placements() == {"part": "kit"}


def test_a_part_lying_on_its_side_in_a_compartment_does_not_count_as_in_it(make_cell, kitting):
    lying = Pose.of(KIT[0] + 0.073 - 0.035, 0.073, FLOOR_OF_COMPARTMENT + 0.030, pitch=1.5708)

    assert Truth(_place(kitting, make_cell, lying, "Alternator")).placements() == {"part": "kit"}


def test_a_part_on_the_table_is_on_the_table(make_cell, kitting):
    assert Truth(_place(kitting, make_cell, Pose((0.6, 0.2, kitting.TOP)))).placements() == {"part": "table"}


def test_a_part_pushed_off_the_table_is_on_the_floor(make_cell, kitting):
    cell = _place(kitting, make_cell, Pose((0.6, 0.2, kitting.TOP)))
    cell.move_body("part", Pose((0.6, 0.6, kitting.TOP)))
    for _ in range(200):
        cell.exchange({})

    assert Truth(cell).placements() == {"part": "floor"}
    assert Truth(cell).pose("part").position[2] < 0.05


def test_a_moved_kit_takes_its_compartments_with_it(make_cell, kitting):
    cell = _place(kitting, make_cell, Pose((0.6, 0.2, kitting.TOP)))
    before = Truth(cell).poses()["kit_0"]

    cell.move_body("kit", Pose((KIT[0], -0.1, kitting.TOP)))
    after = Truth(cell).poses()["kit_0"]

    assert after.position == pytest.approx((before.position[0], before.position[1] - 0.1, before.position[2]))


def test_contacts_name_link_body_depth_and_force(make_cell, kitting):
    cell = _place(kitting, make_cell, Pose((0.6, 0.2, kitting.TOP)))
    truth = Truth(cell)
    clear = truth.contacts()

    hand = Truth(cell).base_pose("base") @ Pose((0.62, 0.0, 0.84))
    cell.move_body("part", hand)
    cell.exchange({})
    truth.watch()

    assert clear == ()
    assert {body for _, body in truth.worst} == {"part"}
    assert {link for link, _ in truth.worst} <= {"panda_hand", "panda_leftfinger", "panda_rightfinger"}
    assert max(contact.depth for contact in truth.worst.values()) > 0.001
    assert max(contact.force for contact in truth.worst.values()) > 1.0

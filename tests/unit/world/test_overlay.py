from __future__ import annotations

import pytest

from skiros_py.errors import UnknownName
from skiros_py.geometry import Pose
from skiros_py.skills.conditions.watch import ReadingView
from skiros_py.world.element import Placement
from skiros_py.world.overlay import Overlay
from skiros_py.world.poses import map_pose
from skiros_py.world.view import NO_SENSORS
from skiros_py.world.world import World


def test_changes_in_an_overlay_do_not_reach_its_base(world: World) -> None:
    overlay = Overlay(world)

    overlay.place("starter_1", "sk:heldBy", "gripper_1")
    overlay.set_value("starter_1", "sk:missing", True)

    assert overlay.placement("starter_1") == Placement("sk:heldBy", "gripper_1")
    assert overlay.value("starter_1", "sk:missing") is True
    assert world.placement("starter_1") == Placement("sk:in", "pallet_a")
    assert (world.value("starter_1", "sk:missing"), world.version) == (None, 1)


def test_placing_an_element_replaces_any_other_placement_relation(world: World) -> None:
    overlay = Overlay(world)

    overlay.set_relation("starter_1", "sk:heldBy", "gripper_1")

    assert overlay.objects("starter_1", "sk:placement") == ("gripper_1",)
    assert overlay.subjects("sk:in", "pallet_a") == ("alternator_1", "relay_box_1")
    assert not overlay.related("starter_1", "sk:placement", "pallet_a")
    assert overlay.related("starter_1", "sk:placement", "gripper_1")


def test_moving_back_leaves_the_overlay_as_its_base(world: World) -> None:
    overlay = Overlay(world)

    overlay.place("starter_1", "sk:heldBy", "gripper_1")
    overlay.place("starter_1", "sk:in", "pallet_a")

    assert overlay.subjects("sk:in", "pallet_a") == world.subjects("sk:in", "pallet_a")
    assert overlay.subjects("sk:heldBy", "gripper_1") == ()


def test_unsetting_a_relation_unsets_its_sub_relations(world: World) -> None:
    overlay = Overlay(world)

    overlay.unset_relation("kit_1", "sk:structure", "kit_1_a")
    overlay.unset_relation("starter_1", "sk:placement", "pallet_a")
    overlay.unset_relation("starter_1", "sk:in", "kit_1_a")

    assert not overlay.related("kit_1", "sk:hasA", "kit_1_a")
    assert overlay.objects("kit_1", "sk:structure") == ("kit_1_b", "kit_1_c", "kit_1_d")
    assert overlay.placement("starter_1") is None


def test_an_overlay_may_lie_on_an_overlay(world: World) -> None:
    below = Overlay(world)
    below.place("starter_1", "sk:heldBy", "gripper_1")
    above = Overlay(below)

    above.place("starter_1", "sk:in", "kit_1_a")

    assert above.subjects("sk:heldBy", "gripper_1") == ()
    assert below.subjects("sk:heldBy", "gripper_1") == ("starter_1",)
    assert above.objects("starter_1", "sk:placement") == ("kit_1_a",)


def test_unsetting_the_value_of_an_element_reveals_the_class_value(world: World) -> None:
    overlay = Overlay(world)
    overlay.set_value("starter_1", "sk:mass", 2.0)

    above = Overlay(overlay)
    above.set_value("starter_1", "sk:mass", None)

    assert (overlay.value("starter_1", "sk:mass"), above.value("starter_1", "sk:mass")) == (2.0, 0.8)


def test_unknown_names_are_refused(world: World) -> None:
    with pytest.raises(UnknownName, match="element 'kit_9'"):
        Overlay(world).place("starter_1", "sk:in", "kit_9")
    with pytest.raises(UnknownName, match="relation 'sk:inn'"):
        Overlay(world).place("starter_1", "sk:inn", "kit_1_a")


def test_a_pose_in_the_map_follows_the_frames(world: World) -> None:
    overlay = Overlay(world)
    overlay.set_value("kit_1", "sk:pose", Pose.of(1.0, 2.0, 0.5))

    pose = map_pose(overlay, "kit_1_a")

    assert pose is not None
    assert pose.position == pytest.approx((0.927, 2.073, 0.506))
    assert map_pose(world, "starter_1") is None


def test_a_frame_cycle_in_an_overlay_gives_no_pose(world: World) -> None:
    overlay = Overlay(world)
    overlay.set_relation("kit_1", "sk:poseFrame", "kit_1_a")

    assert map_pose(overlay, "kit_1_a") is None


def test_reads_through_a_copied_overlay_are_recorded_by_the_reading_view_below(world: World) -> None:
    reading = ReadingView(world.snapshot(), NO_SENSORS)
    overlay = Overlay(Overlay(reading)).copy()
    overlay.place("starter_1", "sk:heldBy", "gripper_1")

    assert overlay.subjects("sk:heldBy", "gripper_1") == ("starter_1",)
    assert ("to", "sk:heldBy", "gripper_1") in reading.keys
    assert reading.subjects("sk:heldBy", "gripper_1") == ()


def test_hidden_elements_keep_their_placement_and_a_copied_overlay_is_independent(world: World) -> None:
    overlay = Overlay(world, hidden=["starter_1"])
    copied = overlay.copy()
    copied.unplace("alternator_1")

    assert "starter_1" not in copied.instances("kitting:Starter")
    assert copied.instances_among("kitting:Starter", ["starter_1"]) == ()
    assert overlay.subjects("sk:in", "pallet_a") == ("alternator_1", "relay_box_1", "starter_1")
    assert copied.subjects("sk:in", "pallet_a") == ("relay_box_1", "starter_1")

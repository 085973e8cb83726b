"""Where a part is put, how far the fingers may open there, and where one is found that is not where it was put."""

from __future__ import annotations

import json
import math

import pytest

from skiros_primitives.gripper import opening
from skiros_primitives.put_down import finger_room, fitting_quarters
from skiros_primitives.surfaces import lost_part, surfaces
from skiros_py.devices.gripper import FINGER, GripperSpec
from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.ports.motion import Obstacle
from skiros_py.ports.perception import Detection, DetectionResult
from skiros_py.testing import Bench, tiny_world

DOWN = Pose.of(0.0, 0.0, 0.03, roll=math.pi)
GAP = 0.04
BOX = json.dumps([{"kind": "box", "size": [0.2, 0.3, 0.1], "at": [0.0, 0.0, 0.05]}])
CELL = json.dumps([{"kind": "box", "size": [0.1, 0.1, 0.03], "at": [0.0, 0.0, 0.015]}])
BALL = json.dumps([{"kind": "box", "size": [0.02, 0.06, 0.05], "at": [0.0, 0.0, 0.025]}])
FACTS = (
    f"""scene:table_1 a sk:Surface ; sk:on scene:floor ; sk:pose "1 0 0 0 0 0"^^sk:poseLiteral ;
    sk:solid '{BOX}'^^rdf:JSON .""",
    """scene:tray_1 a tiny:Box ; sk:on scene:table_1 ; sk:pose "1 0 0.1 0 0 0"^^sk:poseLiteral ;
    sk:hasA scene:cell_a , scene:cell_b , scene:cell_c ; sk:solid '"""
    + BOX
    + """'^^rdf:JSON .""",
    *(
        f"""scene:cell_{name} a tiny:Box ; sk:poseFrame scene:tray_1 ; sk:pose "{x} 0 0.006 0 0 0"^^sk:poseLiteral ;
    sk:solid '{CELL}'^^rdf:JSON ."""
        for name, x in (("a", -0.1), ("b", 0.0), ("c", 0.1))
    ),
    """scene:inside a tiny:Ball ; sk:in scene:cell_c ; sk:poseFrame scene:tray_1 ;
    sk:pose "0.1 0 0 0 0 0"^^sk:poseLiteral .""",
    f"""scene:lost a tiny:Ball ; sk:in scene:box_a ; sk:mass 0.2 ; sk:solid '{BALL}'^^rdf:JSON .""",
)


def wall(y: float, height: float) -> Obstacle:
    return Obstacle("wall", Solid((Primitive("box", (0.3, 0.004, height), Pose((0.0, y, height / 2.0))),)), Pose())


@pytest.mark.parametrize(
    ("half", "room", "quarters"),
    [
        ((0.05, 0.02), (0.053, 0.023), [0, 2]),
        ((0.05, 0.02), (0.023, 0.053), [1, 3]),
        ((0.05, 0.02), (0.06, 0.06), [0, 1, 2, 3]),
    ],
)
def test_a_part_is_turned_so_that_it_fits(
    half: tuple[float, float], room: tuple[float, float], quarters: list[int]
) -> None:
    assert list(fitting_quarters(half, room)) == quarters


def test_fingers_open_as_far_as_walls_and_neighbours_allow() -> None:
    free, near, touching = (finger_room([wall(y, 0.05)], DOWN, GAP, FINGER) for y in (0.20, 0.042, 0.036))

    assert free == pytest.approx(0.016)
    assert 0.002 < near < 0.012
    assert touching == 0.0
    assert finger_room([wall(0.042, 0.015)], DOWN, GAP, FINGER) == pytest.approx(0.016), (
        "the wall ends below the fingers"
    )
    assert finger_room([wall(0.042, 0.05)], DOWN @ Pose.of(0.0, 0.0, 0.0, yaw=math.pi / 2.0), GAP, FINGER) > near


def test_wide_fingers_have_less_room_beside_a_post() -> None:
    post = Obstacle("post", Solid((Primitive("box", (0.006, 0.004, 0.05), Pose((0.02, 0.036, 0.025))),)), Pose())

    narrow, wide = (finger_room([post], DOWN, GAP, (width, 0.015, 0.01)) for width in (0.022, 0.05))

    assert narrow == pytest.approx(0.016), "it is beside the finger"
    assert wide == 0.0


def seen(type_: str | None, x: float, y: float, z: float) -> Detection:
    return Detection(type_, Pose.of(x, y, z, yaw=0.3), 0.001, 0.01, (0.06, 0.02, 0.06))


def found(*detections: Detection, let_go: Pose | None = None) -> Pose | None:
    with Bench(tiny_world(*FACTS)) as made:
        return lost_part(made.context, "lost", DetectionResult(0.0, detections, 1.0), let_go)


def test_a_lost_part_may_lie_in_other_compartments_on_the_kit_and_on_what_it_stands_on() -> None:
    with Bench(tiny_world(*FACTS)) as made:
        places = [
            (one.relation, one.place, one.region.pose.position[2]) for one in surfaces(made.context, "tray_1", "cell_a")
        ]

    assert places[:3] == [
        ("sk:in", "cell_b", pytest.approx(0.106)),
        ("sk:on", "tray_1", pytest.approx(0.2)),
        ("sk:on", "table_1", pytest.approx(0.1)),
    ]


def test_what_is_seen_beside_a_known_part_is_that_part_and_not_the_lost_one() -> None:
    here, there = seen("tiny:Ball", 1.11, 0.01, 0.2), seen("tiny:Ball", 0.9, 0.0, 0.2)

    assert found(here) is None
    assert found(seen("tiny:RedBall", 0.9, 0.0, 0.2)) is None
    assert found(here, there) == there.pose


def test_what_is_not_recognised_is_the_lost_part_only_where_that_was_let_go() -> None:
    strange = seen(None, 0.9, 0.0, 0.2)

    assert found(strange) is None
    assert found(strange, let_go=Pose((1.2, 0.0, 0.1))) is None
    taken = found(strange, let_go=Pose((0.93, 0.0, 0.1)))
    assert taken is not None
    assert taken.position == pytest.approx((0.9, 0.0, 0.21)), "so high that its top is where it is seen"
    assert taken.yaw == pytest.approx(0.3 + math.pi / 2.0), "the part is longer along y"


@pytest.mark.parametrize(("widest", "gap"), [(0.08, 0.08), (0.14, 0.089)])
def test_fingers_come_down_around_a_part_no_wider_open_than_needed(widest: float, gap: float) -> None:
    assert opening(GripperSpec("gripper", ("a", "b"), "arm", widest, 60.0), 0.049) == pytest.approx(gap)

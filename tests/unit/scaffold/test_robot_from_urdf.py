"""A robot from a URDF: what is found, what is asked for, and what is wrong with a model."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from skiros_py.errors import FileError, UsageError
from skiros_py.scaffold.orders import NewRobot
from skiros_py.scaffold.robot import draft_from_urdf
from skiros_py.scaffold.robot_model import RobotDescription, Undecided, read_srdf
from skiros_py.scaffold.robot_urdf import Composed, Composer

INERTIAL = '<inertial><mass value="2"/><inertia ixx="{0}" ixy="0" ixz="0" iyy="{0}" iyz="0" izz="{0}"/></inertial>'
LIMIT = '<limit lower="-2.8" upper="2.8" velocity="2" effort="150"/>'
AXES = ("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "0 0 1")


def link(name: str, moment: float = 0.01, geometry: str = '<box size="0.08 0.08 0.1"/>') -> str:
    shape = f"<collision><geometry>{geometry}</geometry></collision>"
    return f'<link name="{name}">{INERTIAL.format(moment) if moment else ""}{shape}</link>'


def joint(name: str, kind: str, parent: str, child: str, at: str, more: str = "") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}<origin xyz="{at}"/>{more}</joint>'


def arm(prefix: str = "", limit: str = LIMIT) -> str:
    text = link(f"{prefix}l0", 0.02)
    for number, axis in enumerate(AXES, start=1):
        at = "0 0 0.2" if number in (2, 3, 4) else "0 0 0.1"
        text += link(f"{prefix}l{number}", 0.01 + number / 1000.0)
        ends = f"{prefix}l{number - 1}", f"{prefix}l{number}"
        text += joint(f"{prefix}j{number}", "revolute", *ends, at, f'<axis xyz="{axis}"/>{limit}')
    return text


def fingers(palm: str = "l7") -> str:
    text = ""
    for name, sign in (("left", 1), ("right", -1)):
        text += link(name, 1e-5, '<box size="0.02 0.01 0.08"/>')
        more = f'<axis xyz="0 {sign} 0"/><limit lower="0" upper="0.04" velocity="0.2" effort="30"/>'
        text += joint(f"{name}_joint", "prismatic", palm, name, f"0 {sign * 0.005} 0.1", more)
    return text


def model(folder: Path, body: str, name: str = "toy") -> RobotDescription:
    file = folder / f"{name}.urdf"
    file.write_text(f'<robot name="{name}">{body}</robot>', encoding="utf-8")
    return RobotDescription(file)


def composed(robot: RobotDescription, gripper: str = "") -> Composed:
    joints = robot.arm("", {})
    return Composer(robot, joints, robot.gripper(joints[-1].child, gripper), "toy").compose()


def test_arm_gripper_tool_point_and_home_are_found(tmp_path: Path) -> None:
    made = composed(model(tmp_path, arm() + fingers()))

    assert made.arm == tuple(f"j{number}" for number in range(1, 8))
    assert made.fingers is not None
    assert made.fingers.joints == ("left_joint", "right_joint")
    assert made.fingers.max_gap == pytest.approx(0.08)
    assert made.fingers.max_force == 30.0
    assert all(-2.8 < angle < 2.8 for angle in made.home)
    origin = next(one.find("origin") for one in made.urdf.findall("joint") if one.get("name") == "tcp_joint")
    assert origin is not None
    assert np.array(origin.get("xyz", "").split(), dtype=float) == pytest.approx([0.0, 0.0, 0.13], abs=1e-6)


def test_fingers_are_at_zero_where_their_pads_meet(tmp_path: Path) -> None:
    robot = model(
        tmp_path, arm() + fingers().replace("0 0.005 0.1", "0 0.025 0.1").replace("0 -0.005 0.1", "0 -0.025 0.1")
    )

    made = composed(robot)

    assert made.fingers is not None
    assert made.fingers.max_gap == pytest.approx(0.12)
    for one in made.urdf.findall("joint"):
        if one.get("name") in made.fingers.joints:
            at = np.array(one.find("origin").get("xyz", "").split(), dtype=float)  # type: ignore[union-attr]
            assert abs(at[1]) == pytest.approx(0.005, abs=1e-6)


def test_a_plain_gripper_is_mounted_where_there_is_none(tmp_path: Path) -> None:
    robot = model(tmp_path, arm())
    with pytest.raises(Undecided, match="no gripper: no joint moves behind l7") as asked:
        robot.gripper("l7", "")

    assert asked.value.option == "gripper"
    assert composed(robot, "parallel").fingers is not None


def test_two_arms_are_asked_for_by_their_ends(tmp_path: Path) -> None:
    body = link("torso") + arm("a_") + arm("b_")
    body += joint("a", "fixed", "torso", "a_l0", "0 0.2 0") + joint("b", "fixed", "torso", "b_l0", "0 -0.2 0")
    robot = model(tmp_path, body)

    with pytest.raises(Undecided, match=r"has 2 arms.*a_l0 a_l7; b_l0 b_l7. Say it by --arm"):
        robot.arm("", {})
    assert [one.name for one in robot.arm("b_l0 b_l7", {})] == [f"b_j{number}" for number in range(1, 8)]


RING = link("a") + link("b") + joint("ab", "fixed", "a", "b", "0 0 0") + joint("ba", "fixed", "b", "a", "0 0 0")
BAD = {
    "two joints with one name: j1": arm() + joint("j1", "fixed", "l7", "tool", "0 0 0") + link("tool"),
    "no tree: no joint connects the links l0, alone": arm() + link("alone"),
    "no tree: two joints carry the link l7": arm() + joint("again", "fixed", "l1", "l7", "0 0 0"),
    "joint more is at a link that is not there: tool": arm() + joint("more", "fixed", "l7", "tool", "0 0 0"),
    "go round in a ring": arm() + RING,
    "xacro file": arm().replace("0 0 0.2", "0 0 ${x}"),
}


@pytest.mark.parametrize("text", BAD)
def test_a_model_that_is_no_tree_of_named_links_is_refused(text: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=text):
        model(tmp_path, BAD[text])


def test_a_model_without_an_arm_is_refused_with_its_longest_chain(tmp_path: Path) -> None:
    body = link("a") + link("b") + joint("wheel", "continuous", "a", "b", "0 0 0", '<axis xyz="0 1 0"/>')
    with pytest.raises(UsageError, match=r"has no arm: its longest chain of turning joints has 1 \(wheel\)"):
        model(tmp_path, body).arm("", {})


def test_missing_limits_are_named_with_what_was_assumed(tmp_path: Path) -> None:
    made = composed(model(tmp_path, arm(limit="") + fingers()))

    assert any("no limits, assumed half a turn to each side: j1" in note for note in made.notes)
    assert any("no greatest speed, assumed 1.0 rad/s: j1" in note for note in made.notes)
    assert any("no greatest effort" in note for note in made.notes)
    limits = {one.get("name"): one.find("limit") for one in made.urdf.findall("joint")}
    efforts = [float(limit.get("effort", "0")) for name in made.arm if (limit := limits[name]) is not None]
    assert min(efforts) > 0.0
    assert efforts[1] > efforts[5]


def test_missing_and_absurd_inertia_is_computed_and_named(tmp_path: Path) -> None:
    body = (
        (arm() + fingers())
        .replace(link("l3", 0.01 + 3 / 1000.0), link("l3", 0.0))
        .replace(link("l4", 0.01 + 4 / 1000.0), link("l4", 99.0))
    )

    made = composed(model(tmp_path, body))

    assert any(note.startswith("no inertia") and note.endswith(": l3") for note in made.notes)
    assert any(note.startswith("inertia that cannot be true") and note.endswith(": l4") for note in made.notes)
    masses = {one.get("name"): one.find("inertial/mass") for one in made.urdf.findall("link")}
    assert float(masses["l3"].get("value", "0")) == pytest.approx(800.0 * 0.08 * 0.08 * 0.1)  # type: ignore[union-attr]


def test_the_same_inertia_for_all_links_is_no_inertia(tmp_path: Path) -> None:
    body = arm()
    for number in range(8):
        body = body.replace(f'"{0.01 + number / 1000.0}"', '"0.5"')

    made = composed(model(tmp_path, body), "parallel")

    assert any("the same for all" in note and "l5" in note for note in made.notes)


def test_missing_meshes_are_named_and_a_model_without_any_is_refused(tmp_path: Path) -> None:
    gone = '<mesh filename="package://toy/gone.stl"/>'
    some = (arm() + fingers()).replace(link("l2", 0.01 + 2 / 1000.0), link("l2", 0.012, gone))
    assert "missing meshes, left out: package://toy/gone.stl" in composed(model(tmp_path, some)).notes

    with pytest.raises(UsageError, match=r"none of its meshes are there, beside it or above: package://toy/gone.stl"):
        composed(model(tmp_path, arm().replace('<box size="0.08 0.08 0.1"/>', gone)), "parallel")


def test_links_whose_names_engines_reserve_are_renamed(tmp_path: Path) -> None:
    body = (arm() + fingers() + link("world") + joint("stand", "fixed", "world", "base_link", "0 0 0.1")).replace(
        '"l0"', '"base_link"'
    )

    names = [one.get("name") for one in composed(model(tmp_path, body)).urdf.findall("link")]

    assert {"toy_world", "toy_base_link", "base_link"} <= set(names)
    assert "world" not in names
    assert len(names) == len(set(names))


def test_a_gripper_that_is_none_is_refused(tmp_path: Path) -> None:
    robot = model(tmp_path, arm() + fingers())

    with pytest.raises(UsageError, match="thumb is not behind the arm; there are left, right"):
        robot.gripper("l7", "left thumb")


def test_the_srdf_of_another_robot_is_refused(tmp_path: Path) -> None:
    robot, file = model(tmp_path, arm()), tmp_path / "toy.srdf"
    file.write_text(
        '<robot name="toy"><group name="arm"><chain base_link="l0" tip_link="l7"/></group></robot>', "utf-8"
    )
    assert read_srdf(file, robot) == {"arm": ("l0", "l7")}

    file.write_text('<robot name="other"><disable_collisions link1="base" link2="l1"/></robot>', encoding="utf-8")
    with pytest.raises(FileError, match=r"the SRDF of another robot: toy.urdf has no base; it is of 'other'"):
        read_srdf(file, robot)


def test_own_meshes_are_copied_and_heavy_ones_simplified(tmp_path: Path) -> None:
    corners = np.random.default_rng(1).normal(size=(400, 3))
    corners = 0.05 * corners / np.linalg.norm(corners, axis=1)[:, None]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {n} {n + 1} {n + 2}" for n in range(1, 398)]
    (tmp_path / "ball.obj").write_text("\n".join(lines), encoding="utf-8")
    geometry = '<geometry><mesh filename="ball.obj"/></geometry>'
    ball = (
        f'<link name="l2">{INERTIAL.format(0.012)}<collision>{geometry}</collision><visual>{geometry}</visual></link>'
    )
    model(tmp_path, (arm() + fingers()).replace(link("l2", 0.01 + 2 / 1000.0), ball))
    (tmp_path / "work").mkdir()

    draft = draft_from_urdf(tmp_path / "work", NewRobot(str(tmp_path / "toy.urdf")))
    draft.write()

    at = tmp_path / "work" / "toy" / "src" / "toy" / "robots" / "toy"
    assert (at / "ball.obj").read_bytes() == (tmp_path / "ball.obj").read_bytes()
    hull = (at / "ball_hull.obj").read_text(encoding="utf-8").splitlines()
    assert 20 < sum(line.startswith("v ") for line in hull) <= 60
    urdf = ET.parse(at / "toy.urdf").getroot()
    assert {mesh.get("filename") for mesh in urdf.iter("mesh")} == {"ball.obj", "ball_hull.obj"}


def test_a_file_that_is_not_there_or_no_urdf_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"there is no file gone.urdf"):
        draft_from_urdf(tmp_path, NewRobot("gone.urdf"))
    with pytest.raises(UsageError, match="no package 'no_such_package' is installed"):
        draft_from_urdf(tmp_path, NewRobot("no_such_package:arm.urdf"))

    for text, why in (("{}", "no XML"), ("<sdf/>", "no URDF: its first element is <sdf>, not <robot>")):
        file = tmp_path / "bad.urdf"
        file.write_text(text, encoding="utf-8")
        with pytest.raises(FileError, match=why):
            draft_from_urdf(tmp_path, NewRobot(str(file)))


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ("l0 hand", "there is no link hand; the links are l0, l1"),
        ("l7", "it takes two links"),
        ("left l7", "left does not carry l7"),
        ("l0 l0", "no joint moves between them"),
    ],
)
def test_an_arm_that_is_none_is_refused(said: str, why: str, tmp_path: Path) -> None:
    robot = model(tmp_path, arm() + fingers())

    with pytest.raises(UsageError, match=why):
        robot.arm(said, {})


def test_a_folder_that_is_there_is_left_alone(tmp_path: Path) -> None:
    model(tmp_path, arm() + fingers())
    (tmp_path / "toy").mkdir()

    with pytest.raises(UsageError, match="toy is there already, and nothing is overwritten"):
        draft_from_urdf(tmp_path, NewRobot(str(tmp_path / "toy.urdf")))

    assert list((tmp_path / "toy").iterdir()) == []


@pytest.mark.parametrize(("there", "broken"), [('mass value="2"', 'mass value="two"'), ('size="0.08 ', 'size="wide ')])
def test_what_is_no_number_is_named_with_its_link(there: str, broken: str, tmp_path: Path) -> None:
    third = link("l3", 0.01 + 3 / 1000.0)

    with pytest.raises(FileError, match="link l3 has what is no number"):
        model(tmp_path, arm().replace(third, third.replace(there, broken)))


def test_an_srdf_beside_the_model_that_does_not_fit_is_left_out_and_named(tmp_path: Path) -> None:
    model(tmp_path, arm() + fingers())
    (tmp_path / "toy.srdf").write_text('<robot name="toy"><group name="a"><link name="gone"/></group></robot>', "utf-8")
    (tmp_path / "work").mkdir()

    draft = draft_from_urdf(tmp_path / "work", NewRobot(str(tmp_path / "toy.urdf")))

    assert any(note.startswith("not used") and "toy.urdf has no gone" in note for note in draft.notes)
    with pytest.raises(FileError, match="the SRDF of another robot"):
        draft_from_urdf(tmp_path / "work", NewRobot(str(tmp_path / "toy.urdf"), srdf=str(tmp_path / "toy.srdf")))


def test_a_joint_with_the_name_of_a_link_gets_one_of_its_own(tmp_path: Path) -> None:
    robot = model(tmp_path, arm().replace('name="j3"', 'name="l3"'))

    assert [one.name for one in robot.arm("", {})] == ["j1", "j2", "l3_joint", "j4", "j5", "j6", "j7"]


def test_an_arm_that_cannot_turn_its_hand_freely_is_named(tmp_path: Path) -> None:
    assert not any("directions of 6" in note for note in composed(model(tmp_path, arm() + fingers())).notes)

    less = (arm() + fingers()).replace('name="j3" type="revolute"', 'name="j3" type="fixed"')
    less = less.replace('name="j5" type="revolute"', 'name="j5" type="fixed"')
    notes = composed(model(tmp_path, less)).notes
    assert "the hand moves and turns in 5 directions of 6: it reaches few grasps" in notes

"""Pictures of every engine: colours of bodies and meshes, lit from one side."""

import math

import numpy as np
import pytest

from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.ports.simulation import View
from skiros_py.simulation.renderer import BodyAppearance, Renderer, RobotAppearance, intrinsics_of

ABOVE = View(64, 48, math.radians(50.0), 0.1, 3.0, pose=Pose.of(0.0, 0.0, 1.0, roll=math.pi))
RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
MIDDLE = (24, 32)
URDF = """
<robot name="signs">
  <link name="board">
    <visual><geometry><mesh filename="board.obj"/></geometry></visual>
    <visual><origin xyz="0.3 0 0"/><geometry><sphere radius="0.05"/></geometry>
      <material name="red"><color rgba="1 0 0 1"/></material></visual>
  </link>
</robot>
"""
BOARD = """mtllib board.mtl
v -0.1 -0.1 0.2
v 0.1 -0.1 0.2
v 0.1 0.1 0.2
v -0.1 0.1 0.2
usemtl green
f 1 2 3
f 1 3 4
"""
GREEN = "newmtl green\nKd 0.0 1.0 0.0\n"


@pytest.fixture(scope="module")
def renderer():
    return Renderer()


def _picture(renderer, bodies=(), robots=(), view=ABOVE):
    return renderer.render(bodies, robots, view, lambda rendering: rendering)


def test_a_body_has_its_colour_and_a_side_away_from_the_light_is_darker(renderer):
    box = BodyAppearance(Solid.box(0.4, 0.4, 0.4), RED, Pose((0.0, 0.0, 0.0)))
    side = View(64, 48, math.radians(50.0), 0.1, 3.0, pose=Pose.of(-1.0, 0.0, 0.2, pitch=math.pi / 2))

    top, dark = (_picture(renderer, [box], view=view).colour[MIDDLE] for view in (ABOVE, side))

    assert top[0] > 200
    assert tuple(top[1:]) == (0, 0)
    assert 0.5 < dark[0] / top[0] < 0.75


def test_the_nearer_of_two_bodies_is_seen_and_a_cylinder_is_round(renderer):
    low = BodyAppearance(Solid.box(2.0, 2.0, 0.1), RED, Pose())
    disc = BodyAppearance(Solid((Primitive("cylinder", (0.2, 0.1), Pose((0.0, 0.0, 0.25))),)), BLUE, Pose())

    seen = _picture(renderer, [low, disc])
    blue = seen.colour[..., 2] > 100
    k = intrinsics_of(ABOVE)

    assert seen.depth[MIDDLE] == pytest.approx(0.7, abs=1e-4)
    assert blue.sum() == pytest.approx(math.pi * (0.2 / 0.7 * k.fx) ** 2, rel=0.06)


def test_what_leaves_comes_back_or_changes_its_colour_is_in_the_next_picture(renderer):
    colours = []
    for colour in (RED, None, BLUE):
        bodies = [] if colour is None else [BodyAppearance(Solid.box(0.4, 0.4, 0.1), colour, Pose())]
        colours.append(_picture(renderer, bodies).colour[MIDDLE].argmax())

    assert [colours[0], colours[2]] == [0, 2]
    assert np.isfinite(_picture(renderer).depth[MIDDLE])  # the floor


def test_meshes_have_the_colours_of_their_files_and_shapes_those_of_the_model(renderer, tmp_path):
    for name, text in {"signs.urdf": URDF, "board.obj": BOARD, "board.mtl": GREEN}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    at = Pose((0.0, 0.0, 0.3))

    seen = _picture(renderer, robots=[RobotAppearance(tmp_path / "signs.urdf", {"board": at})])

    assert seen.depth[MIDDLE] == pytest.approx(0.5, abs=1e-4)
    assert seen.colour[MIDDLE].argmax() == 1
    assert (seen.colour[..., 0].astype(int) - seen.colour[..., 1] > 100).sum() > 20

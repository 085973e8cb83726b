"""Which camera is chosen for a look, where none is named."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from skiros_primitives.cameras import best_camera
from skiros_primitives.surfaces import support_region
from skiros_py.config import find_scene
from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Pose
from skiros_py.ports.perception import Region
from skiros_py.skills.context import RunContext
from skiros_py.station.session import Options, Session
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement

KIT = Region(Pose((-1.55, 0.0, 0.54)), (0.15, 0.15))
FIRST, EXACT = 0.015, None
CAMERA = """
scene:kit_camera a sk:Camera ;
    rdfs:label "kit camera" ;
    sk:on scene:floor ;
    sk:pose "-1.55 0 1.25 3.141592653589793 0 0"^^sk:poseLiteral ;
    sk:width 640 ; sk:height 480 ; sk:verticalFov 0.9774 ;
    sk:minDepth 0.05 ; sk:maxDepth 2.0 ; sk:depthNoise 0.0005 ; sk:latency 0.1 .
"""


@pytest.fixture
def context(tmp_path: Path) -> Iterator[RunContext]:
    scene = tmp_path / "watched.ttl"
    scene.write_text(find_scene("kitting").read_text(encoding="utf-8") + CAMERA, encoding="utf-8")
    with Session(str(scene), Options(fake=True)) as session:
        session.cycle.step()
        yield session.runtime.context


def chosen(context: RunContext, region: Region, most: float | None, *without: str) -> str | None:
    return best_camera(context, context.cell.device("arm_1", ArmSpec), region, most, without)


def test_one_that_sees_the_place_is_taken_for_a_first_look_and_that_of_the_arm_for_an_exact_one(
    context: RunContext,
) -> None:
    assert chosen(context, KIT, FIRST) == "kit_camera"
    assert chosen(context, KIT, EXACT) == "camera_1"


def test_it_is_not_taken_where_it_does_not_see_the_place_or_has_looked_in_vain(context: RunContext) -> None:
    pallet = support_region(context, "pallet_a")
    assert isinstance(pallet, Region)

    assert chosen(context, pallet, FIRST) == "camera_1"
    assert chosen(context, KIT, FIRST, "kit_camera") == "camera_1"


def test_it_is_not_taken_where_something_is_in_between(context: RunContext) -> None:
    with context.world.transaction(author="test", reason="hangs there") as tx:
        board = tx.add(v.OBSTACLE, placement=Placement(v.ON, "floor"))
        tx.set(board, v.POSE, Pose((-1.55, 0.0, 0.9)))
        tx.set(board, v.SOLID, '[{"kind": "box", "size": [0.3, 0.3, 0.02], "at": [0, 0, 0]}]')

    assert chosen(context, KIT, FIRST) == "camera_1"

"""Where a calibration has found a camera is what everything takes for its place, also after a restart."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from skiros_py.devices.camera import CameraSpec
from skiros_py.geometry import Pose
from skiros_py.skills.cell_reader import read_board, read_cell
from skiros_py.skills.context import RunContext
from skiros_py.station.session import Options, Session
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement

FOUND = Pose.of(0.005, 0.0, 0.0, pitch=math.radians(1.0))


@pytest.fixture
def context() -> Iterator[RunContext]:
    with Session("kitting", Options(fake=True)) as session:
        session.cycle.step()
        yield session.runtime.context


def test_a_camera_is_where_it_was_found(context: RunContext) -> None:
    before = context.frames.at(context.board.snapshot)
    link = before.located("camera_1")

    context.frames.mount("camera_1", FOUND)

    tree = context.frames.at(context.board.snapshot)
    frames = {frame: (parent, pose) for parent, frame, pose in tree.transforms()}
    assert tree.located("camera_1") == link @ FOUND
    assert before.located("camera_1") == link
    assert frames["camera_1"] == ("robot_1/camera_optical", FOUND)


def test_it_is_there_after_a_restart(context: RunContext) -> None:
    with context.world.transaction(author="test", reason="calibrated") as tx:
        tx.set("camera_1", v.MOUNTING, FOUND)

    cell = read_cell(context.world, ["robot_1"], simulated=False)

    assert cell.device("camera_1", CameraSpec).mounting == FOUND
    assert cell.robots[0].device("force_torque_1").mounting == Pose()


def test_a_board_is_read_with_what_its_class_says(context: RunContext) -> None:
    with context.world.transaction(author="test", reason="brought") as tx:
        board = tx.add(v.MARKER_BOARD, placement=Placement(v.ON, "kit_table"))

    found = read_board(context.world, board)

    assert found is not None
    assert (found.columns, found.rows, found.square, found.marker) == (7, 5, 0.03, 0.0225)
    assert read_board(context.world, "kit_1") is None

"""Following paths with bases that have limits of acceleration and a localiser with errors."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import shapely

from skiros_py.devices.base_curves import Curve, Speeds
from skiros_py.devices.common import approach
from skiros_py.devices.mobile_base import BaseSpec, BaseTwist
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose, Solid, wrap_angle
from skiros_py.motion.base_paths import BasePaths
from skiros_py.ports.device import FakeRobot
from skiros_py.ports.motion import BasePathRequest, Obstacle
from skiros_py.ports.paths import BaseLeg, BasePath, Layer, floor_area, placed, swept

FOOTPRINT = ((-0.50, -0.28), (0.32, -0.28), (0.32, 0.28), (-0.50, 0.28))
SPEC = BaseSpec("base", Pose(), FOOTPRINT, 0.8, 1.2, 0.5, 1.5)
OMNI = replace(SPEC, max_sideways=0.4)
PERIOD = 1.0 / 200.0


class Base:
    """A base that slips nowhere, and whose localiser errs differently where it starts and where it arrives."""

    def __init__(self, start: Pose, rng: np.random.Generator, spec: BaseSpec = SPEC) -> None:
        self._spec = spec
        self._old, self._new = rng.normal(size=(2, 3)) * (0.005, 0.005, math.radians(0.3))
        self._faded = self._linear = self._angular = self._sideways = 0.0
        x, y, yaw = self._old.tolist()
        self.truth = start @ Pose.of(x, y, 0.0, yaw=yaw).inverse()

    @property
    def speed(self) -> float:
        return self._linear

    @property
    def turning(self) -> float:
        return self._angular

    def believed(self) -> Pose:
        angle = self._faded * math.pi / 2.0
        x, y, yaw = (math.cos(angle) * self._old + math.sin(angle) * self._new).tolist()
        here = self.truth.position
        return Pose.of(here[0] + x, here[1] + y, 0.0, yaw=self.truth.yaw + yaw)

    def drive(self, path: BasePath) -> Iterator[Pose]:
        """Drives a path, and yields where it believes to be."""
        follower = self._spec.follow(path, self.believed)
        for _, target in follower:
            self._step(target)
            yield self.believed()
        while self._linear or self._angular or self._sideways:
            self._step(BaseTwist(0.0, 0.0))

    def _step(self, target: BaseTwist) -> None:
        self._linear = approach(self._linear, target.linear, SPEC.max_linear_acceleration * PERIOD)
        self._angular = approach(self._angular, target.angular, SPEC.max_angular_acceleration * PERIOD)
        sideways = max(-self._spec.max_sideways, min(self._spec.max_sideways, target.sideways))
        self._sideways = approach(self._sideways, sideways, SPEC.max_linear_acceleration * PERIOD)
        turn = self._angular * PERIOD
        way, aside = self._linear * PERIOD, self._sideways * PERIOD
        self.truth @= Pose.of(0.0, 0.0, 0.0, yaw=turn / 2.0) @ Pose.of(way, aside, 0.0, yaw=turn / 2.0)
        moved = abs(self._linear) + abs(self._sideways) + abs(self._angular)
        self._faded = min(1.0, self._faded + moved * PERIOD / 0.5)


def drive_through_a_hall(rng: np.random.Generator, *, glides: bool = False) -> tuple[Pose, Pose, BasePath]:
    """Returns a start, a goal and the path between them, among boxes."""

    def anywhere() -> Pose:
        return Pose.of(rng.uniform(-1, 6), rng.uniform(-1, 6), 0.0, yaw=rng.uniform(-3, 3))

    while True:
        boxes = tuple(Obstacle(f"box_{k}", Solid.box(*rng.uniform(0.3, 1.0, 2), 1.0), anywhere()) for k in range(5))
        areas = shapely.union_all([floor_area(box.solid, box.pose) for box in boxes]).buffer(0.03)
        start, goal = anywhere(), anywhere()
        if not any(areas.intersects(placed(FOOTPRINT, pose)) for pose in (start, goal)):
            path = BasePaths().plan(BasePathRequest(start, goal, (Layer(FOOTPRINT),), boxes, glides=glides))
            if isinstance(path, BasePath):
                return start, goal, path


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("spec", [SPEC, OMNI])
def test_a_base_arrives_within_5_mm_and_half_a_degree_and_stays_on_its_path(spec: BaseSpec, seed: int) -> None:
    rng = np.random.default_rng(seed)
    start, goal, path = drive_through_a_hall(rng, glides=spec.drives_sideways)
    declared = shapely.union_all(swept(FOOTPRINT, [pose for _, pose in path.poses(start)])).buffer(0.06)
    base = Base(start, rng, spec)

    beside = [not declared.covers(placed(FOOTPRINT, pose)) for k, pose in enumerate(base.drive(path)) if k % 20 == 0]

    assert not any(beside)
    assert math.dist(base.believed().position[:2], goal.position[:2]) <= 0.005
    assert abs(wrap_angle(base.believed().yaw - goal.yaw)) <= math.radians(0.5)


def test_a_base_comes_back_to_its_line_backwards_too() -> None:
    path = BasePath((BaseLeg(-2.0, 0.0, backwards=True),), 0.0)
    base = Base(Pose(), np.random.default_rng(3))
    base.truth = base.truth @ Pose.of(0.0, 0.02, 0.0)

    *_, last = base.drive(path)

    assert math.dist(last.position[:2], (-2.0, 0.0)) <= 0.005


def test_a_curve_is_driven_without_a_stop() -> None:
    turns = np.linspace(0.0, math.pi / 2.0, 40)[1:].tolist()
    *via, end = [(2.0 * math.sin(turn), 2.0 * (1.0 - math.cos(turn)), turn) for turn in turns]
    base = Base(Pose(), np.random.default_rng(5))

    speeds = [base.speed for _ in base.drive(BasePath((BaseLeg(*end[:2], via=tuple(via)),), math.pi / 2.0))]

    under_way = speeds[speeds.index(max(speeds)) : -400]
    assert max(speeds) > 0.6
    assert min(under_way) > 0.3


def test_a_base_that_comes_out_of_a_dock_turns_while_it_stops_and_drives_ahead() -> None:
    dock = Obstacle("dock", Solid.box(0.6, 0.8, 0.5), Pose((0.78, 0.0, 0.0)))
    goal = Pose.of(-4.0, 0.3, 0.0, yaw=math.pi)
    path = BasePaths().plan(BasePathRequest(Pose(), goal, (Layer(FOOTPRINT),), (dock,)))
    assert isinstance(path, BasePath)
    base = Base(Pose(), np.random.default_rng(7))

    seen = [(base.speed, base.turning) for _ in base.drive(path)]

    assert min(speed for speed, _ in seen) < -0.2
    turning_at_rest = [turning for speed, turning in seen if abs(speed) < 0.02 and abs(turning) > 0.5]
    assert turning_at_rest
    assert len(turning_at_rest) * PERIOD < 0.5
    assert math.dist(base.believed().position[:2], goal.position[:2]) <= 0.005


# ------------------------------------------------------------------ omnidirectional bases

TABLE = Obstacle("table", Solid.box(0.6, 4.0, 0.5), Pose((0.65, 0.0, 0.0)))


def glide(start: Pose, goal: Pose, *obstacles: Obstacle) -> BasePath:
    path = BasePaths().plan(BasePathRequest(start, goal, (Layer(FOOTPRINT),), obstacles, glides=True))
    assert isinstance(path, BasePath)
    return path


def test_docked_at_a_table_it_glides_along_it_without_turning() -> None:
    path = glide(Pose(), Pose((0.0, 0.3, 0.0)), TABLE)

    poses = [pose for _, pose in path.poses(Pose(), way=0.02)]

    assert [leg.glides for leg in path.legs] == [True]
    assert max(abs(pose.yaw) for pose in poses) < 1e-6
    assert max(abs(pose.position[0]) for pose in poses) < 1e-6


def test_from_a_far_place_at_the_same_table_it_does_not_come_as_near_on_the_way_as_where_it_docks() -> None:
    start, goal = Pose((0.0, -1.2, 0.0)), Pose((0.0, 1.2, 0.0))

    path = glide(start, goal, TABLE)

    area = floor_area(TABLE.solid, TABLE.pose)
    midway = [pose for _, pose in path.poses(start, way=0.02) if abs(pose.position[1]) < 0.8]
    assert midway
    assert min(float(shapely.distance(area, placed(FOOTPRINT, pose))) for pose in midway) >= 0.08


def test_its_speeds_keep_their_limits_where_it_turns_while_it_glides() -> None:
    turns = np.linspace(0.0, math.pi / 2.0, 60).tolist()
    poses = [Pose.of(1.6 * k / 59.0, 0.0, 0.0, yaw=yaw) for k, yaw in enumerate(turns)]
    curve = Curve(BaseLeg.gliding(*poses), Pose())

    rates = Speeds(0.8, 1.2, 0.5, 1.5, 0.4).along(curve, start=0.0)

    inner = slice(0, -1)
    time = np.cumsum(2.0 * np.diff(curve.along) / np.maximum(1e-9, rates[1:] + rates[:-1]))
    for share, speed, acceleration in ((curve.ahead, 0.8, 0.5), (curve.aside, 0.4, 0.5), (curve.turn, 1.2, 1.5)):
        velocity = share * rates
        assert np.abs(velocity).max() <= speed + 1e-9
        assert np.abs(np.gradient(velocity[1:], time)[1:-2][inner]).max() <= acceleration * 1.05
    assert np.abs(curve.aside * rates).max() > 0.2
    assert 2.0 < time[-1] < 8.0


def test_it_drives_a_short_way_directly_to_its_side_and_a_differential_base_cannot() -> None:
    start, goal = Pose.of(1.0, 2.0, 0.0, yaw=0.4), Pose.of(1.0, 2.0, 0.0, yaw=0.4) @ Pose((0.0, -0.15, 0.0))
    path = OMNI.direct_path(start, goal)
    base = Base(start, np.random.default_rng(2), OMNI)

    *_, last = base.drive(path)

    assert last.distance(goal) < 0.005
    with pytest.raises(DeviceError, match="a differential drive cannot follow a path that goes sideways"):
        next(SPEC.follow(path, lambda: start))
    with pytest.raises(DeviceError, match="a differential drive does not drive sideways"):
        SPEC.check(BaseTwist(0.0, 0.0, 0.1))


def test_a_fake_one_drives_where_it_is_told() -> None:
    base = OMNI.fake(FakeRobot())

    for _ in range(200):
        base.command(BaseTwist(0.1, 0.0, 0.2))

    assert base.state().pose.position == pytest.approx((0.1, 0.2, 0.0))
    assert base.state().sideways == pytest.approx(0.2)
    assert not base.state().still

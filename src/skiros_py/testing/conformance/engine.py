"""What every physics engine behind the simulation port must do."""

# ruff: noqa: D102 - the names of tests say what they claim

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from skiros_py.errors import UnknownName, UsageError
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.simulation import FLOOR, Engine, Rendering, SimulatedRobot, Surface, View, Wrench

_PERIOD = 1.0 / 200.0
_GRAVITY = 9.81
_GREY = (0.5, 0.5, 0.5, 1.0)
_BOX = Solid.box(0.2, 0.2, 0.1)
_ROBOT = """
<robot name="crane">
  <link name="post"><inertial><mass value="5"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
  <link name="jib"><inertial><mass value="2"/><inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.2"/></inertial></link>
  <link name="hoist"><inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="drum"><inertial><origin xyz="0.2 0 0.1" rpy="0 0 0.5"/><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="hook"><inertial><mass value="0.5"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
  <joint name="slew" type="revolute"><parent link="post"/><child link="jib"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="500" velocity="2"/></joint>
  <joint name="trolley" type="prismatic"><parent link="jib"/><child link="hoist"/><origin xyz="0.5 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="400" velocity="1"/></joint>
  <joint name="counter" type="prismatic"><parent link="jib"/><child link="drum"/><origin xyz="-0.5 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="400" velocity="1"/></joint>
  <joint name="hook_mount" type="fixed"><parent link="hoist"/><child link="hook"/><origin xyz="0 0 -0.3"/></joint>
</robot>
"""  # noqa: E501 - a file


def _depth(rendering: Rendering) -> Array:
    return rendering.depth


class EngineContract(ABC):
    """Claims about a :class:`~skiros_py.ports.simulation.Engine`; every test gets an empty world of its own.

    Class attributes:
        dynamics: False for an engine in which bodies do not fall and do not collide.
        tolerance: How well joints keep positions and velocities [m, rad].
        depth_tolerance: How exact rendered depth is [m].
    """

    dynamics: ClassVar[bool] = True
    tolerance: ClassVar[float] = 2e-3
    depth_tolerance: ClassVar[float] = 1e-3

    @abstractmethod
    def make(self, period: float) -> Engine:
        """Returns the engine with an empty world."""

    @pytest.fixture
    def engine(self) -> Iterator[Engine]:
        """An engine of its own for each test."""
        engine = self.make(_PERIOD)
        yield engine
        engine.close()

    @pytest.fixture
    def urdf(self, tmp_path: Path) -> Path:
        """A robot of four joints: a jib that slews at 1 m, a trolley on it with a hook below, a counterweight."""
        file = tmp_path / "crane.urdf"
        file.write_text(_ROBOT, encoding="utf-8")
        return file

    @pytest.fixture
    def crane(self, engine: Engine, urdf: Path) -> SimulatedRobot:
        """The robot at the origin."""
        return engine.add_robot("crane", urdf)

    @staticmethod
    def hold(robot: SimulatedRobot, **positions: float) -> None:
        """Lets joints go to positions and hold them."""
        joints = robot.joints(tuple(positions))
        joints.hold_positions(tuple(positions.values()), gain=0.3, effort=joints.limits.effort)

    @staticmethod
    def run(engine: Engine, steps: int) -> None:
        """Simulates some steps."""
        for _ in range(steps):
            engine.step()

    def needs_dynamics(self) -> None:
        """Skips a test where bodies do not fall."""
        if not self.dynamics:
            pytest.skip("it has no dynamics")

    # ------------------------------------------------------------------ joints and links

    def test_it_has_a_name_and_the_period_it_was_built_with(self, engine: Engine) -> None:
        assert engine.name
        assert engine.period == _PERIOD

    def test_joints_and_links_have_the_names_and_limits_of_the_urdf(self, crane: SimulatedRobot) -> None:
        joints = crane.joints(("slew", "trolley"))

        assert sorted(crane.joint_names) == ["counter", "slew", "trolley"]
        assert sorted(crane.link_names) == ["drum", "hoist", "hook", "jib", "post"]
        assert (joints.names, joints.links) == (("slew", "trolley"), ("jib", "hoist"))
        assert np.array(joints.limits).T.tolist() == [[-3.0, 3.0, 500.0, 2.0], [0.0, 1.0, 400.0, 1.0]]

    def test_unknown_joints_and_links_are_refused_with_those_there_are(self, crane: SimulatedRobot) -> None:
        with pytest.raises(UnknownName, match="trolley"):
            crane.joints(("trolleys",))
        with pytest.raises(UnknownName, match="hook"):
            crane.link("hok")

    def test_reset_joints_are_there_at_rest(self, crane: SimulatedRobot) -> None:
        joints = crane.joints(("slew", "trolley"))
        before = joints.read().positions

        joints.reset((math.pi / 2, 0.5))
        positions, velocities, _ = joints.read()

        assert before == pytest.approx((0.0, 0.0))
        assert positions == pytest.approx((math.pi / 2, 0.5))
        assert velocities == pytest.approx((0.0, 0.0))

    def test_links_are_where_the_joints_put_them(self, crane: SimulatedRobot) -> None:
        crane.joints(("slew", "trolley")).reset((math.pi / 2, 0.5))

        assert crane.link("hook").pose().position == pytest.approx((0.0, 1.0, 0.7), abs=1e-6)
        assert crane.link("hook").pose().yaw == pytest.approx(math.pi / 2)
        assert crane.link("post").pose().position == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)

    def test_a_robot_stands_where_it_is_put(self, engine: Engine, urdf: Path) -> None:
        crane = engine.add_robot("crane", urdf, Pose.of(1.0, 2.0, 0.0, yaw=math.pi / 2))

        assert crane.link("hook").pose().position == pytest.approx((1.0, 2.5, 0.7), abs=1e-6)

    def test_joints_reach_positions_and_hold_them(self, engine: Engine, crane: SimulatedRobot) -> None:
        self.hold(crane, slew=0.4, trolley=0.3, counter=0.1)
        self.run(engine, 200)

        positions, velocities, _ = crane.joints(("slew", "trolley", "counter")).read()
        assert positions == pytest.approx((0.4, 0.3, 0.1), abs=self.tolerance)
        assert velocities == pytest.approx((0.0, 0.0, 0.0), abs=self.tolerance)

    def test_joints_keep_the_greatest_speed_on_their_way(self, engine: Engine, crane: SimulatedRobot) -> None:
        self.hold(crane, slew=0.0, counter=0.0)
        trolley = crane.joints(("trolley",))
        trolley.hold_positions((0.5,), gain=0.3, effort=(400.0,), max_velocity=0.2)
        speeds = []
        for _ in range(200):
            engine.step()
            speeds.append(trolley.read().velocities[0])

        assert max(speeds) == pytest.approx(0.2, abs=0.02)
        assert trolley.read().positions[0] == pytest.approx(0.2, abs=0.02)

    def test_joints_keep_velocities(self, engine: Engine, crane: SimulatedRobot) -> None:
        self.hold(crane, slew=0.0, counter=0.0)
        crane.joints(("trolley",)).drive_velocities((0.4,), effort=400.0)
        self.run(engine, 200)

        assert crane.joints(("trolley",)).read().positions[0] == pytest.approx(0.4, abs=0.01)
        assert crane.joints(("trolley",)).read().velocities[0] == pytest.approx(0.4, abs=0.01)

    def test_an_effort_accelerates(self, engine: Engine, crane: SimulatedRobot) -> None:
        self.needs_dynamics()
        self.hold(crane, slew=0.0, counter=0.0)
        trolley = crane.joints(("trolley",))
        for _ in range(100):
            trolley.apply_efforts((0.9,))  # on 1.5 kg
            engine.step()

        assert trolley.read().velocities[0] == pytest.approx(0.3, rel=0.03)

    def test_motors_say_what_they_apply_to_accelerate_a_joint(self, engine: Engine, crane: SimulatedRobot) -> None:
        self.needs_dynamics()
        self.hold(crane, slew=0.0, counter=0.0)
        trolley = crane.joints(("trolley",))
        efforts = []
        for step in range(1, 101):
            trolley.drive_velocities((0.002 * step,), effort=400.0)
            engine.step()
            efforts.append(trolley.read().efforts[0])

        assert efforts[20:] == pytest.approx([1.5 * 0.002 / _PERIOD] * 80, rel=0.05)

    def test_a_coupled_joint_moves_by_its_ratio(self, engine: Engine, crane: SimulatedRobot) -> None:
        self.hold(crane, slew=0.0)
        crane.joints(("trolley", "counter")).couple(ratio=1.0, effort=1000.0)
        crane.joints(("counter",)).drive_velocities((0.0,), effort=0.0)
        crane.joints(("trolley",)).drive_velocities((0.2,), effort=400.0)
        self.run(engine, 200)

        trolley, counter = crane.joints(("trolley", "counter")).read().positions
        assert trolley == pytest.approx(0.2, abs=0.02)
        assert counter == pytest.approx(trolley, abs=0.02)

    def test_more_than_two_joints_are_not_coupled(self, crane: SimulatedRobot) -> None:
        with pytest.raises(UsageError):
            crane.joints(("slew", "trolley", "counter")).couple(ratio=1.0, effort=1.0)

    def test_velocity_and_acceleration_of_a_link_are_those_of_its_frame(
        self, engine: Engine, crane: SimulatedRobot
    ) -> None:
        self.hold(crane, trolley=0.5, counter=0.0)
        crane.joints(("trolley",)).reset((0.5,))
        crane.joints(("slew",)).drive_velocities((1.0,), effort=500.0)
        hook = crane.link("hook")
        assert hook.acceleration().linear == pytest.approx((0.0, 0.0, 0.0))
        self.run(engine, 100)

        outwards = np.array(hook.pose().position) * (1.0, 1.0, 0.0)
        twist, acceleration = hook.twist(), hook.acceleration()
        assert twist.angular == pytest.approx((0.0, 0.0, 1.0), abs=0.01)
        assert np.cross((0.0, 0.0, 1.0), outwards) == pytest.approx(np.array(twist.linear), abs=0.01)
        assert np.array(acceleration.linear) == pytest.approx(-outwards, abs=0.05)

    def test_the_reaction_at_a_joint_carries_what_hangs_on_it(self, engine: Engine, crane: SimulatedRobot) -> None:
        self.hold(crane, slew=0.0, trolley=0.0, counter=0.0)
        crane.joints(("trolley", "counter")).reactions()
        self.run(engine, 100)

        hoist, drum = crane.joints(("trolley", "counter")).reactions()
        assert hoist.force == pytest.approx((0.0, 0.0, 1.5 * _GRAVITY), abs=0.2)
        if self.dynamics:  # the drum weighs on its joint beside it
            assert drum.force == pytest.approx((0.0, 0.0, _GRAVITY), abs=0.2)
            assert drum.torque == pytest.approx((0.0, -0.2 * _GRAVITY, 0.0), abs=0.05)

    # ------------------------------------------------------------------ bodies

    def test_a_body_is_where_it_is_put_until_it_is_removed(self, engine: Engine) -> None:
        engine.add_body("box", _BOX, Pose.of(1.0, 2.0, 0.0, yaw=0.5), colour=_GREY)
        before = engine.poses()
        first = engine.pose("box")
        engine.move_body("box", Pose((3.0, 2.0, 0.0)))

        assert first.position == pytest.approx((1.0, 2.0, 0.0), abs=1e-9)
        assert first.yaw == pytest.approx(0.5)
        assert engine.pose("box").position == pytest.approx((3.0, 2.0, 0.0), abs=1e-9)
        assert engine.poses()["box"] == engine.pose("box")
        assert before["box"] == first

        engine.remove_body("box")

        assert "box" not in engine.poses()
        engine.add_body("box", _BOX, Pose(), colour=_GREY)

    def test_names_are_taken_once_and_unknown_ones_refused(self, engine: Engine, crane: SimulatedRobot) -> None:
        engine.add_body("box", _BOX, Pose(), colour=_GREY)

        for taken in ("box", crane.name, FLOOR):
            with pytest.raises(UsageError):
                engine.add_body(taken, _BOX, Pose(), colour=_GREY)
        for refused in (engine.pose, engine.twist, engine.remove_body, engine.contacts, engine.detach):
            with pytest.raises(UnknownName):
                refused("bx")
        with pytest.raises(UnknownName):
            engine.attach("box", "crane", "hok")

    def test_an_attached_body_moves_with_its_link_until_it_is_detached(
        self, engine: Engine, crane: SimulatedRobot
    ) -> None:
        self.hold(crane, slew=0.0, trolley=0.0, counter=0.0)
        engine.add_body("load", _BOX, Pose((0.5, 0.0, 0.55)), mass=0.5, colour=_GREY)
        engine.attach("load", "crane", "hook")
        self.hold(crane, slew=1.0, trolley=0.4, counter=0.0)
        self.run(engine, 300)

        under = crane.link("hook").pose().inverse() @ engine.pose("load")
        assert under.position == pytest.approx((0.0, 0.0, -0.15), abs=0.01)
        assert under.yaw == pytest.approx(0.0, abs=0.02)
        with pytest.raises(UsageError):
            engine.attach("load", "crane", "hook")

        engine.detach("load")
        self.hold(crane, slew=0.0, trolley=0.0, counter=0.0)
        self.run(engine, 300)

        assert crane.link("hook").pose().distance(engine.pose("load")) > 0.3

    def test_a_body_without_mass_is_not_attached(self, engine: Engine, crane: SimulatedRobot) -> None:
        engine.add_body("wall", _BOX, Pose((0.5, 0.0, 0.55)), colour=_GREY)

        with pytest.raises(UsageError):
            engine.attach("wall", crane.name, "hook")

    def test_a_body_falls(self, engine: Engine) -> None:
        self.needs_dynamics()
        engine.add_body("box", _BOX, Pose((0.0, 0.0, 2.0)), mass=2.0, colour=_GREY)
        self.run(engine, 50)

        assert engine.twist("box").linear == pytest.approx((0.0, 0.0, -_GRAVITY * 50 * _PERIOD), rel=0.02)
        assert engine.pose("box").position[2] == pytest.approx(2.0 - _GRAVITY / 2.0 * 0.25**2, abs=0.01)

    def test_the_floor_carries_the_weight_of_what_lies_on_it(self, engine: Engine) -> None:
        self.needs_dynamics()
        on = Pose((0.0, 0.0, 0.0005))
        surface = Surface(lateral=0.8, spinning=0.01, rolling=1e-4)
        engine.add_body("box", _BOX, on, mass=2.0, colour=_GREY, surface=surface)
        self.run(engine, 200)

        contacts = engine.contacts("box")
        assert engine.pose("box").position[2] == pytest.approx(0.0, abs=1e-3)
        assert {(contact.body, contact.other) for contact in contacts} == {("box", FLOOR)}
        assert sum(contact.force for contact in contacts) == pytest.approx(2.0 * _GRAVITY, rel=0.05)
        assert all(contact.normal == pytest.approx((0.0, 0.0, 1.0), abs=1e-6) for contact in contacts)

    def test_a_wrench_acts_for_one_step(self, engine: Engine) -> None:
        self.needs_dynamics()
        engine.add_body("box", _BOX, Pose((0.0, 0.0, 1.0)), mass=2.0, colour=_GREY)
        engine.apply_wrench("box", Wrench((0.0, 40.0, 0.0)))
        self.run(engine, 2)

        assert engine.twist("box").linear[1] == pytest.approx(40.0 / 2.0 * _PERIOD, rel=0.01)
        assert engine.twist("box").angular == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)

    def test_what_does_not_touch_has_no_contacts(self, engine: Engine, crane: SimulatedRobot) -> None:
        engine.add_body("box", _BOX, Pose((5.0, 0.0, 1.0)), colour=_GREY)
        engine.step()

        assert engine.contacts("box") == ()
        assert engine.contacts(crane.name, "hook") == ()

    # ------------------------------------------------------------------ rays and pictures

    def test_rays_meet_bodies_and_floor_where_they_are(self, engine: Engine) -> None:
        engine.add_body("box", _BOX, Pose((1.0, 0.0, 0.5)), colour=_GREY)
        starts = np.array([[0.0, 0.0, 0.55], [0.0, 1.0, 0.5], [0.0, 0.0, 2.0]])
        ends = np.array([[2.0, 0.0, 0.55], [2.0, 1.0, 0.5], [0.0, 0.0, -2.0]])

        side, nothing, down = engine.cast_rays(starts, ends)

        assert nothing is None
        assert side is not None
        assert (side.body, side.link) == ("box", "")
        assert side.fraction == pytest.approx(0.45, abs=1e-3)
        assert side.point == pytest.approx((0.9, 0.0, 0.55), abs=2e-3)
        assert side.normal == pytest.approx((-1.0, 0.0, 0.0), abs=1e-3)
        assert down is not None
        assert down.body == FLOOR
        assert down.fraction == pytest.approx(0.5, abs=1e-3)

    def test_rendered_depth_is_the_distance_along_the_optical_axis(self, engine: Engine) -> None:
        engine.add_body("box", _BOX, Pose(), colour=_GREY)
        above = View(64, 48, math.radians(50.0), 0.1, 1.05, pose=Pose.of(0.0, 0.0, 1.0, roll=math.pi))

        call = engine.render(above, _depth, latency=0.2)
        depth, k = call.result(), engine.intrinsics(above)

        assert call.latency == pytest.approx(0.2)
        assert depth.shape == (48, 64)
        assert depth[int(k.cy), int(k.cx)] == pytest.approx(0.9, abs=self.depth_tolerance)
        assert depth[1, 1] == pytest.approx(1.0, abs=self.depth_tolerance)
        assert k.fy == pytest.approx(24.0 / math.tan(math.radians(25.0)))

    def test_what_is_out_of_range_is_infinitely_far_away(self, engine: Engine) -> None:
        upwards = View(32, 24, math.radians(50.0), 0.1, 2.0, pose=Pose((0.0, 0.0, 1.0)))

        assert np.isinf(engine.render(upwards, _depth).result()).all()

    def test_a_view_on_a_link_moves_with_it_and_shows_the_moment_it_was_asked_for(
        self, engine: Engine, crane: SimulatedRobot
    ) -> None:
        engine.add_body("box", _BOX, Pose((1.0, 0.0, 0.0)), colour=_GREY)
        down = Pose.of(0.0, 0.0, -0.1, roll=math.pi)
        view = View(32, 24, math.radians(50.0), 0.1, 5.0, pose=down, robot=crane.name, link="hook")
        crane.joints(("trolley",)).reset((0.5,))

        over_the_box = engine.render(view, _depth)
        crane.joints(("trolley",)).reset((0.0,))
        beside_it = engine.render(view, _depth)

        assert over_the_box.result()[12, 16] == pytest.approx(0.5, abs=5e-3)
        assert beside_it.result()[12, 16] == pytest.approx(0.6, abs=5e-3)

    # ------------------------------------------------------------------ state

    def test_a_saved_state_comes_back(self, engine: Engine, crane: SimulatedRobot) -> None:
        engine.add_body("box", _BOX, Pose((2.0, 0.0, 0.5)), mass=1.0, colour=_GREY)
        self.hold(crane, slew=0.0, trolley=0.5, counter=0.0)
        self.run(engine, 5)
        saved, then = engine.save(), engine.state_bytes()
        crane.joints(("slew",)).drive_velocities((0.5,), effort=500.0)
        self.run(engine, 20)
        later = engine.state_bytes()

        engine.restore(saved)

        assert later != then
        assert np.frombuffer(engine.state_bytes()) == pytest.approx(np.frombuffer(then), abs=1e-9)

    def test_the_same_steps_give_the_same_bytes(self, urdf: Path) -> None:
        results = []
        for _ in range(2):
            engine = self.make(_PERIOD)
            crane = engine.add_robot("crane", urdf)
            engine.add_body("box", _BOX, Pose((2.0, 0.0, 0.5)), mass=1.0, colour=_GREY)
            self.hold(crane, slew=1.0, trolley=0.5, counter=0.3)
            self.run(engine, 50)
            results.append(engine.state_bytes())
            engine.close()

        assert results[0] == results[1]

    def test_it_can_be_closed_twice(self, engine: Engine) -> None:
        engine.close()
        engine.close()

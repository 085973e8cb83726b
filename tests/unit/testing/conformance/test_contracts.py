"""A contract finds what is wrong with an adapter, and nothing else."""

from __future__ import annotations

import pytest

pytest_plugins = "pytester"

GOOD = '''
import pytest
from dataclasses import replace
from skiros_py.errors import DeviceError
from skiros_py.devices.arm import *
from skiros_py.devices.mobile_base import *
from skiros_py.devices.gripper import *
from skiros_py.ports.values import *
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.testing.conformance import CellDriverContract, BasePlannerContract, PlannerContract, PendingContract

class Contract(CellDriverContract):
    pictures = False
    Cell = None
    def make(self, spec):
        return self.Cell(spec)

def after(speed, wanted, step):
    return wanted if abs(wanted - speed) <= step else speed + (step if wanted > speed else -step)

class Heavy(FakeCell):
    """A fake whose base keeps limits of speed and acceleration, and whose arm needs a moment to stand."""
    braking_time = 1.1
    limits = 0.8, 0.8 / 200.0, 1.2, 1.6 / 200.0
    held = False

    def exchange(self, commands):
        now = self.read()
        commands = {} if self.held else dict(commands)
        twists = {}
        for base, state in now.of(BaseState).items():
            wanted = commands.get(base, BaseTwist(0.0, 0.0))
            top, step, turn, turn_step = self.limits
            linear = after(state.linear, max(-top, min(top, wanted.linear)), step)
            angular = after(state.angular, max(-turn, min(turn, wanted.angular)), turn_step)
            twists[base] = BaseTwist(linear, angular)
        return super().exchange({**commands, **twists})

    def halt(self):
        self.held = True

    def release(self):
        self.held = False

class TestGood(Contract):
    Cell = Heavy
'''
WRONG = {
    "Skipping": (
        """
    def exchange(self, commands):
        super().exchange(commands)
        return super().exchange(commands)
""",
        {
            "test_cycles_count_up_and_time_is_cycle_times_period",
            "test_a_refused_command_takes_no_time_and_it_goes_on",
            "test_a_base_keeps_its_limits_whatever_it_is_told",
        },
    ),
    "Reckless": ("\n    limits = 99.0, 99.0, 99.0, 99.0\n", {"test_a_base_keeps_its_limits_whatever_it_is_told"}),
    "Coasting": (
        """
    def exchange(self, commands):
        old = getattr(self, "old", {})
        self.old = {**old, **{b: t for b, t in commands.items() if b == "base"}}
        return super().exchange({**self.old, **commands})
""",
        {
            "test_a_base_without_a_command_brakes_and_stands",
            "test_a_base_that_drives_is_not_still",
            "test_a_released_cell_stands_until_it_is_told_to_move",
        },
    ),
    "Limp": (
        """
    def exchange(self, commands):
        now = super().exchange(commands)
        if "arm" in commands or self.held:
            return now
        arm = now.state("arm", ArmState)
        sagging = replace(arm, positions=tuple(p - 0.001 for p in arm.positions))
        self._models.models["arm"]._state = sagging
        self._snapshot = replace(now, devices={**now.devices, "arm": sagging})
        return self._snapshot
""",
        {"test_an_arm_without_a_command_holds", "test_an_arm_follows_its_set_points"},
    ),
    "Letting": (
        """
    def exchange(self, commands):
        return super().exchange({"gripper": GripperTarget(0.08, 1.0), **commands})
""",
        {"test_a_gripper_keeps_its_target_until_it_gets_another"},
    ),
    "Lying": (
        """
    def exchange(self, commands):
        now = super().exchange(commands)
        standing = {b: replace(s, still=True) for b, s in now.of(BaseState).items()}
        self._snapshot = replace(now, devices={**now.devices, **standing})
        return self._snapshot
""",
        {"test_a_base_that_drives_is_not_still"},
    ),
    "Unstoppable": (
        "\n    def halt(self): pass\n",
        {"test_a_halted_cell_brakes_whatever_is_commanded", "test_a_halted_gripper_keeps_what_it_has"},
    ),
    "Stubborn": ("\n    def release(self): pass\n", {"test_a_released_cell_stands_until_it_is_told_to_move"}),
    "Waiting": (
        """
    def halt(self):
        import time
        time.sleep(0.6)
        super().halt()
""",
        {"test_halting_returns_at_once_in_any_thread"},
    ),
    "Seeing": ("\n    def capture(self, camera): return None\n", {"test_a_camera_that_is_not_there_is_refused"}),
    "Once": (
        """
    def close(self):
        assert not getattr(self, "gone", False)
        self.gone = True
""",
        {"test_it_may_be_closed_twice"},
    ),
    "Deaf": (
        """
    def exchange(self, commands):
        return super().exchange({})
""",
        {
            "test_a_command_for_an_unknown_device_is_refused[arms]",
            "test_a_command_for_an_unknown_device_is_refused[grippers]",
            "test_a_command_for_an_unknown_device_is_refused[bases]",
            "test_a_refused_command_takes_no_time_and_it_goes_on",
            "test_an_arm_follows_its_set_points",
            "test_an_arm_whose_commands_cease_in_motion_comes_to_a_standstill",
            "test_a_gripper_keeps_its_target_until_it_gets_another",
            "test_a_base_drives_ahead_and_turns_as_told",
            "test_a_base_that_drives_is_not_still",
            "test_a_released_cell_stands_until_it_is_told_to_move",
        },
    ),
    "Hasty": (
        """
    def read(self):
        now = super().read()
        return replace(now, time=now.time + 1.0)
""",
        {
            "test_reading_gives_the_last_snapshot_and_takes_no_time",
            "test_cycles_count_up_and_time_is_cycle_times_period",
        },
    ),
}


def failures(pytester: pytest.Pytester, text: str) -> dict[str, set[str]]:
    """Runs a file of contracts; returns the failed claims by class."""
    pytester.makepyfile(text)
    recorded = pytester.inline_run("-p", "no:dash", "-p", "no:skiros", "-q", "-W", "ignore::DeprecationWarning")
    found: dict[str, set[str]] = {}
    for report in recorded.getreports("pytest_runtest_logreport"):
        if report.failed:
            _, class_, name = report.nodeid.split("::")
            found.setdefault(class_, set()).add(name)
    return found


def test_each_wrong_driver_fails_exactly_the_claims_that_it_breaks(pytester: pytest.Pytester) -> None:
    wrong = [
        f"class {name}(Heavy):{body}\nclass Test{name}(Contract):\n    Cell = {name}\n"
        for name, (body, _) in WRONG.items()
    ]

    found = failures(pytester, GOOD + "\n".join(wrong))

    assert found.pop("TestGood", set()) == set()
    assert found == {f"Test{name}": claims for name, (_, claims) in WRONG.items()}


OTHERS = '''
from skiros_py.planning.planners.planner import Solved, Unsolvable
from skiros_py.ports.motion import NoMotion
from skiros_py.ports.paths import BasePath, BaseLeg
from skiros_py.ports.values import Done

class TestStraight(BasePlannerContract):
    """Drives straight through everything."""
    def make(self):
        class Straight:
            def plan(self, request):
                x, y, _ = request.goal.position
                legs = () if request.start == request.goal else (BaseLeg(x, y),)
                return Done(BasePath(legs, request.goal.yaw))
        return Straight()

class TestOptimist(PlannerContract):
    """Has a plan for everything."""
    def make(self):
        class Optimist:
            name = "optimist"
            supports = (":strips", "typing")
            def solve(self, domain, problem):
                return Done(Solved((("enter", "dove_1", "hole_1"),)))
            def close(self):
                pass
        return Optimist()

class TestMoody(PendingContract):
    """Says something else each time."""
    def make(self):
        class Moody:
            latency = 0.0
            def done(self):
                return True
            def result(self):
                return object()
        return Moody()
'''


def test_wrong_planners_and_answers_are_found_too(pytester: pytest.Pytester) -> None:
    found = failures(pytester, GOOD + OTHERS)

    assert found["TestMoody"] == {"test_the_answer_comes_and_stays_the_same"}
    assert found["TestStraight"] == {
        "test_the_last_stretch_is_driven_straight_ahead_into_the_goal",
        "test_nothing_on_the_way_is_touched",
        "test_out_of_a_narrow_dock_it_leaves_without_turning_in_it",
        "test_a_goal_inside_an_obstacle_has_a_reason_that_names_it",
        "test_where_there_is_no_way_it_says_so",
    }
    assert found["TestOptimist"] == {
        "test_it_says_which_requirements_it_takes",
        "test_a_plan_reaches_its_goal_step_by_step",
        "test_a_goal_that_holds_has_an_empty_plan",
        "test_no_plan_is_an_answer",
        "test_several_tasks_at_once_each_get_their_own_answer",
        "test_what_is_no_pddl_is_a_fault_and_no_answer",
        "test_closing_ends_what_still_searches",
        "test_a_closed_planner_takes_nothing_more",
    }

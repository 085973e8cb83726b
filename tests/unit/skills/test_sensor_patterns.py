from __future__ import annotations

import pytest

from skiros_py.errors import DescriptionError
from skiros_py.execution.signals import Signals
from skiros_py.ports.board import DeviceBoard
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import AllOf, AnyOf, Exists, Not, Pattern, Related, Sensor, Verdict, is_sensed
from skiros_py.skills.sensing import SignalSensors
from skiros_py.testing import Bench, tiny_world
from skiros_py.world.overlay import FilteredView, Overlay
from skiros_py.world.world import World

STILL = Sensor("device", "still", "=", True)
WIDE = Sensor("device", "gap", ">", 0.5)


def sensing_world() -> World:
    world = tiny_world()
    world.sensors = SignalSensors(Signals(DeviceBoard(FakeCell(read_cell(world, ("robot_1",))))))
    return world


def ask(pattern: Pattern, device: str, world: World | None = None) -> Verdict:
    return pattern.evaluate(world or sensing_world(), {"device": device})


@pytest.mark.parametrize("device", ["gripper_1", "base_1", "arm_1"])
def test_every_device_says_whether_it_stands(device: str) -> None:
    verdict = ask(STILL, device)

    assert (verdict.holds, verdict.text) == (True, f"the still of {device} is true")


def test_every_single_value_that_a_device_offers_is_read() -> None:
    sensors = sensing_world().sensors
    offered = {
        "arm_1": ["still"],
        "gripper_1": ["gap", "force", "still"],
        "base_1": ["x", "y", "yaw", "linear", "angular", "still"],
    }

    for device, signals in offered.items():
        assert all(isinstance(sensors.read(device, signal), float | bool) for signal in signals)
    assert sensors.read("arm_1", "positions") is None, "a condition compares single values"


def test_what_a_sensor_says_instead_is_the_reason() -> None:
    verdict = ask(WIDE, "gripper_1")

    assert not verdict
    assert verdict.text.endswith(", not more than 0.5")


def test_a_sensor_expression_is_made_by_all_any_and_not() -> None:
    assert ask(AllOf((STILL, Not(WIDE), AnyOf((WIDE, STILL)))), "gripper_1")


def test_what_a_device_does_not_say_does_not_hold() -> None:
    assert ask(Sensor("device", "colour", "=", 1), "gripper_1").text == "gripper_1 does not say its colour"
    assert ask(STILL, "ball_1").text == "ball_1 does not say its still"


def test_suppositions_and_states_know_no_sensors() -> None:
    world = sensing_world()
    for view in (Overlay(world), FilteredView(world, frozenset()), world.snapshot(), tiny_world()):
        verdict = STILL.evaluate(view, {"device": "gripper_1"})
        assert (verdict.holds, verdict.text) == (False, "no sensors here")


def test_a_sensor_is_compared_with_what_makes_sense() -> None:
    with pytest.raises(DescriptionError, match="'<' compares numbers, and true is a truth value"):
        Sensor("device", "still", "<", True)


def test_a_pattern_is_sensed_wherever_in_it_a_sensor_is() -> None:
    stored = Related("sk:in", "a", "b")

    assert is_sensed(Not(AllOf((stored, Exists("d", "sk:Gripper", AnyOf((stored, STILL)))))))
    assert not is_sensed(Not(AllOf((stored, Exists("d", "sk:Gripper", AnyOf((stored,)))))))


def test_the_world_of_a_bench_is_sensed() -> None:
    with Bench(tiny_world()) as bench:
        assert STILL.evaluate(bench.world, {"device": "gripper_1"})

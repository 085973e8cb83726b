"""Expressions over signals and parameters: one grammar, errors with the column and what would be right."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.errors import DescriptionError
from skiros_py.execution.signals import Signals
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.signals import Request, Signal, Value
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.skills.conditions import AllOf, AnyOf, Exists, Expression, Not, Pattern, Related, Verdict, holds
from skiros_py.skills.conditions.expression import is_sensed
from skiros_py.testing import Bench, tiny_world
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import NoSensors
from skiros_py.world.world import World

STILL = Expression("device.still")
WIDE = Expression("device.gap > 0.5")


class Said(NoSensors):
    """Signals that a test gives."""

    def __init__(self, **values: Any) -> None:
        self.values = values

    def value(self, name: str) -> Any:
        return self.values.get(name.replace(".", "_"))


def sensing_world() -> World:
    world = tiny_world()
    world.sensors = Signals(DeviceBoard(FakeCell(read_cell(world, ("robot_1",)))))
    return world


def ask(pattern: Pattern, device: str, world: World | None = None) -> Verdict:
    return pattern.evaluate(world or sensing_world(), {"device": device})


def computed(text: str, binding: dict[str, Any] | None = None, **signals: Any) -> Verdict:
    world = tiny_world()
    world.sensors = Said(**signals)
    return holds(text).evaluate(world, binding or {})


@pytest.mark.parametrize("device", ["gripper_1", "base_1", "arm_1"])
def test_every_device_says_whether_it_stands(device: str) -> None:
    verdict = ask(STILL, device)

    assert (verdict.holds, verdict.text) == (True, f"{device}.still is true")


def test_every_value_that_a_device_offers_is_read() -> None:
    sensors = sensing_world().sensors
    offered = {
        "arm_1": ["still", "positions"],
        "gripper_1": ["gap", "force", "still"],
        "base_1": ["x", "y", "yaw", "linear", "angular", "still"],
    }

    for device, signals in offered.items():
        assert all(isinstance(sensors.value(f"{device}.{signal}"), float | bool | tuple) for signal in signals)


def test_a_failed_signal_expression_gives_the_actual_value() -> None:
    verdict = ask(WIDE, "gripper_1")

    assert not verdict
    assert verdict.text.startswith("gripper_1.gap is 0.")
    assert verdict.text.endswith(", not device.gap > 0.5")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2 * 3 = 7", True),
        ("(1 + 2) * 3 = 9", True),
        ("2 - 3 - 4 == -5", True),
        ("8 / 4 / 2 = 1", True),
        ("-2 < 1 and not 2 < 1", True),
        ("not 1 < 2 or true", True),
        ("false or true and false", False),
        ("min(3, 1, 2) = 1 and max(3, 1) = 3 and abs(-2) = 2", True),
        ("norm(arm.positions) = 5", True),
        ("arm.positions[1] = 4", True),
        ("limit >= 2.5 and limit <= 2.5 and limit != 3", True),
        ("Gripper.force > limit", True),
        ('mode = "fast"', True),
        ("`kit distance` < 1", True),
        ("`Gripper` = 7", True),
    ],
)
def test_expressions_are_computed_as_in_other_languages(text: str, expected: bool) -> None:
    world = tiny_world()
    world.sensors = Said(arm_positions=(3.0, 4.0), gripper_1_force=3.0, **{"kit distance": 0.5, "Gripper": 7.0})
    verdict = holds(text).evaluate(world, {"limit": 2.5, "mode": "fast", "Gripper": "gripper_1"})  # type: ignore[dict-item]

    assert verdict.holds is expected, verdict.text


@given(st.lists(st.booleans(), min_size=1, max_size=6), st.data())
def test_precedence_is_that_of_python(values: list[bool], data: st.DataObject) -> None:
    words = [data.draw(st.sampled_from(["", "not "])) + str(value) for value in values]
    joints = [data.draw(st.sampled_from([" and ", " or "])) for _ in values[1:]] + [""]
    text = "".join(word + joint for word, joint in zip(words, joints, strict=True))

    assert computed(text.lower()).holds is bool(eval(text))


@pytest.mark.parametrize(
    ("text", "column", "right"),
    [
        ("Gripper.force >", 16, "a value: a name such as Gripper.force"),
        ("Gripper.force 2", 15, "an operator such as 'and'"),
        ("and 2 < 3", 1, "a value"),
        ("(1 < 2", 7, "an operator"),
        ("1 < 2 < 3", 7, "an operator"),
        ("a $ b", 3, "an operator"),
        ("", 1, "a value"),
    ],
)
def test_an_invalid_expression_is_refused_with_the_column_and_a_valid_form(text: str, column: int, right: str) -> None:
    with pytest.raises(DescriptionError) as caught:
        holds(text)

    assert str(caught.value).startswith(f"expression '{text}', column {column}: expected {right}")


def test_an_unknown_function_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(DescriptionError, match=r"unknown function 'sqrt'. Known: abs, max, min, norm"):
        holds("sqrt(2) > 1")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("a.force > 1", "there is no value of 'a.force'"),
        ("1 + 1", "'1 + 1' is 2, not true or false"),
        ("1 / 0 > 1", "divides by zero"),
        ("true < 1", "'<' takes a number, and true is a truth value"),
        ("1 and true", "'and' takes a truth value, and 1 is a number"),
        ('1 = "one"', "cannot be compared"),
        ("x[2] > 1", "there is no [2] in 2 values"),
        ("Gripper.force > 1", "Gripper is not specified"),
    ],
)
def test_an_expression_without_a_value_fails_and_so_does_its_negation(text: str, reason: str) -> None:
    world = tiny_world()
    world.sensors = Said(x=(1.0, 2.0))
    verdict, negated = (c.evaluate(world, {"Gripper": None}) for c in (holds(text), ~holds(text)))  # type: ignore[dict-item]

    assert not verdict
    assert reason in verdict.sentence
    assert not negated


class Broken:
    """A signal provider that raises."""

    name = "maker of odd"
    provides: tuple[Signal, ...] = (Signal("odd"),)
    requests: tuple[Request, ...] = ()
    every_cycle = False

    def compute(self, inputs: Mapping[str, Value], time: float) -> Mapping[str, Value]:
        raise KeyError("boom")


def test_an_expression_without_a_value_gives_the_reason_of_its_provider() -> None:
    world = tiny_world()
    world.sensors = Signals(DeviceBoard(FakeCell(read_cell(world, ("robot_1",)))), [Broken()])

    sentence = holds("odd > 1").evaluate(world, {}).sentence

    assert (
        "there is no value of 'odd': maker of odd was switched off in cycle 0: it raised KeyError: 'boom'" in sentence
    )


def test_the_pattern_of_a_condition_type_uses_its_roles() -> None:
    renamed = Expression("device.force > device.limit and `device.x` < 1").rename({"device": "Gripper"})

    assert renamed.text == "Gripper.force > Gripper.limit and `device.x` < 1"
    assert renamed.names == ("Gripper",)


def test_patterns_of_expressions_are_combined_by_all_any_and_not() -> None:
    assert ask(AllOf((STILL, Not(WIDE), AnyOf((WIDE, STILL)))), "gripper_1")


def test_overlays_and_snapshots_have_no_sensor_values() -> None:
    world = sensing_world()
    for view in (Overlay(world), Overlay(Overlay(world)), world.snapshot(), tiny_world()):
        verdict = STILL.evaluate(view, {"device": "gripper_1"})
        assert (verdict.holds, verdict.text) == (False, "no sensors here")


def test_a_pattern_with_an_expression_anywhere_needs_sensors() -> None:
    stored = Related("sk:in", "a", "b")

    assert is_sensed(Not(AllOf((stored, Exists("d", "sk:Gripper", AnyOf((stored, STILL)))))))
    assert not is_sensed(Not(AllOf((stored, Exists("d", "sk:Gripper", AnyOf((stored,)))))))


def test_the_world_of_a_bench_is_sensed() -> None:
    with Bench(tiny_world()) as bench:
        assert STILL.evaluate(bench.world, {"device": "gripper_1"})


# ---------------------------------------------------------------------- without values


def kinds(name: str) -> frozenset[str]:
    return {"any": frozenset({"number", "truth value", "vector", "text"}), "id": frozenset({"text"})}.get(
        name, frozenset({"number", "truth value", "vector"})
    )


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('Arm.force > "x"', "'>' takes a number, and 'x' is a text"),
        ('Arm.force == "x"', "Arm.force (number or truth value or vector) cannot be compared with 'x' (text)"),
        ("id + 1 > 2", "'+' takes a number, and id is a text"),
        ("Arm.still or norm(1) > 2", "norm takes a vector, and 1 is a number"),
        ("not (Arm.force + 1)", "'not' takes a truth value, and a number is a number"),
        ("Arm.force + 1", "'Arm.force + 1' as a condition takes a truth value, and a number is a number"),
        ("(Arm.force > 1) > 2", "'>' takes a number, and a truth value is a truth value"),
        ("1 / 0 > 1", "'1 / 0 > 1' divides by zero"),
    ],
)
def test_an_expression_that_can_never_hold_says_why_without_values(text: str, problem: str) -> None:
    assert Expression(text).problem(kinds) == problem


@pytest.mark.parametrize(
    "text",
    [
        "Arm.still",
        "not Arm.still and Arm.force > 2",
        "any == id",
        "abs(Arm.force - any) / any < max(1, any)",
        "norm(Arm.wrench) > 1 or Arm.wrench[2] > 1 or Arm.wrench[9] > 1",
        "`kit distance` >= 0.1 and any",
        "1 > 2",
    ],
)
def test_an_expression_whose_values_may_fit_has_no_problem(text: str) -> None:
    assert Expression(text).problem(kinds) is None

"""Signals: ordered once, computed when read, once a cycle; what breaks is named and hurts only its readers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import DescriptionError, UnknownName, UsageError
from skiros_py.execution.cycle import ControlCycle
from skiros_py.execution.signals import SignalLost, Signals
from skiros_py.execution.watchdog import Watchdog
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.signals import Input, Latest, Request, Signal, SignalProvider, Value
from skiros_py.ports.values import Done
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.testing import robot_turtle, world_of


class Provider:
    """A provider whose computation a test gives."""

    def __init__(
        self,
        name: str,
        compute: Callable[[Mapping[str, Value]], Any],
        *requests: str,
        optional: tuple[str, ...] = (),
        every_cycle: bool = False,
        length: int | None = None,
    ) -> None:
        self.name = f"maker of {name}"
        self.provides: tuple[Signal, ...] = (Signal(name, length=length),)
        self.requests = (*map(Request, requests), *(Request(one, optional=True) for one in optional))
        self.every_cycle = every_cycle
        self.computed = 0
        self._compute = compute

    def compute(self, inputs: Mapping[str, Value], time: float) -> Mapping[str, Value]:
        self.computed += 1
        return {self.provides[0].name: self._compute(inputs)}


@pytest.fixture
def board() -> DeviceBoard:
    view = world_of(robot_turtle()).snapshot()
    return DeviceBoard(FakeCell(read_cell(view, view.instances("sk:Robot"))))


def raises(_inputs: Mapping[str, Value]) -> float:
    raise ZeroDivisionError("no such luck")


def test_a_signal_is_computed_at_most_once_per_cycle_and_only_if_it_is_read(board: DeviceBoard) -> None:
    one = Provider("one", lambda _: 1.0)
    two = Provider("two", lambda inputs: inputs["one"] + 1.0, "one")
    unused = Provider("unused", lambda _: 0.0)
    signals = Signals(board, [two, unused, one])

    for _ in range(3):
        board.exchange()
        signals.update()
        assert (signals.read("two").value, signals.read("two").value, signals.read("one").value) == (2.0, 2.0, 1.0)

    assert (one.computed, two.computed, unused.computed) == (3, 3, 0)


def test_a_sample_contains_its_cycle_and_its_source(board: DeviceBoard) -> None:
    signals = Signals(board, [Provider("one", lambda _: 1.0)])
    board.exchange()
    board.exchange()

    sample = signals.read("one")

    assert (sample.value, sample.cycle, sample.source) == (1.0, 2, "maker of one")


def test_the_values_of_a_device_are_signals(board: DeviceBoard) -> None:
    base = "base_1"
    signals = Signals(board, [Provider("back", lambda inputs: -inputs[f"{base}.linear"], f"{base}.linear")])

    assert signals.read(f"{base}.still").source == base
    assert signals.read("back").value == 0.0


def test_a_stateful_signal_is_computed_in_each_cycle_after_its_first_read(board: DeviceBoard) -> None:
    counted = iter(range(100))
    counter = Provider("count", lambda _: float(next(counted)), every_cycle=True)
    signals = Signals(board, [counter])

    for _ in range(3):
        board.exchange()
        signals.update()
    assert counter.computed == 0
    signals.read("count")
    for _ in range(4):
        board.exchange()
        signals.update()

    assert signals.read("count").value == 4.0


def test_providers_in_a_cycle_are_refused_by_name(board: DeviceBoard) -> None:
    ring = [Provider("a", lambda _: 0.0, "b"), Provider("b", lambda _: 0.0, "c"), Provider("c", lambda _: 0.0, "a")]

    with pytest.raises(DescriptionError, match=r"maker of a.*maker of") as raised:
        Signals(board, ring)

    assert all(f"maker of {name}" in str(raised.value) for name in "abc")


def test_a_missing_mandatory_signal_is_refused_with_the_nearest_name(board: DeviceBoard) -> None:
    with pytest.raises(DescriptionError, match=r"maker of far.*'distence'.*distance"):
        Signals(board, [Provider("distance", lambda _: 1.0), Provider("far", lambda _: True, "distence")])


def test_a_provider_that_reads_a_signal_of_a_missing_device_is_left_out_and_named(
    board: DeviceBoard, caplog: pytest.LogCaptureFixture
) -> None:
    soft = Provider("soft", lambda inputs: inputs["gripper_9.force"], "gripper_9.force")
    softer = Provider("softer", lambda inputs: inputs["soft"], "soft")
    signals = Signals(board, [softer, soft, Provider("other", lambda _: 5.0)], sources=["lab 1.0"] * 3)

    signals.restart()

    why = "maker of soft of lab 1.0 is left out: it reads 'gripper_9.force', and this cell has no gripper_9"
    with pytest.raises(SignalLost, match=why):
        signals.read("soft")
    with pytest.raises(SignalLost, match=f"maker of softer of lab 1.0 is left out: it reads 'soft', and {why}"):
        signals.read("softer")
    assert signals.read("other").value == 5.0
    assert (soft.computed, softer.computed) == (0, 0)
    assert set(signals.faults) == {"maker of soft", "maker of softer"}
    assert [record.levelname for record in caplog.records] == ["WARNING"] * 2


def test_a_misspelt_signal_of_a_device_that_this_cell_lacks_is_refused_with_the_distribution(
    board: DeviceBoard,
) -> None:
    with pytest.raises(DescriptionError, match=r"maker of soft of lab 1.0: .*'gripper_9.farce'"):
        Signals(board, [Provider("soft", lambda _: 0.0, "gripper_9.farce")], sources=["lab 1.0"])


def test_cycles_and_signals_provided_twice_are_refused_and_name_the_distributions(board: DeviceBoard) -> None:
    ring = [Provider("a", lambda _: 0.0, "b"), Provider("b", lambda _: 0.0, "a")]
    twins = [Provider("one", lambda _: 1.0), Provider("one", lambda _: 2.0)]

    with pytest.raises(DescriptionError, match=r"ring: .*(a of lab 1.0.*b of hut 2.0|b of hut 2.0.*a of lab 1.0)"):
        Signals(board, ring, sources=["lab 1.0", "hut 2.0"])
    with pytest.raises(DescriptionError, match=r"maker of one of lab 1.0 and maker of one of hut 2.0"):
        Signals(board, twins, sources=["lab 1.0", "hut 2.0"])


def test_switching_off_a_provider_is_logged_once(board: DeviceBoard, caplog: pytest.LogCaptureFixture) -> None:
    signals = Signals(board, [Provider("broken", raises)], sources=["lab 1.0"])

    for _ in range(3):
        signals.value("broken")
        board.exchange()

    (record,) = caplog.records
    assert record.getMessage() == (
        "maker of broken of lab 1.0 was switched off in cycle 0: it raised ZeroDivisionError: no such luck"
    )


def test_an_optional_signal_may_be_missing(board: DeviceBoard) -> None:
    signals = Signals(board, [Provider("safe", lambda inputs: "lidar" not in inputs, optional=("lidar",))])

    assert signals.read("safe").value is True


def test_a_signal_that_is_provided_twice_is_refused(board: DeviceBoard) -> None:
    with pytest.raises(DescriptionError, match="'one' is provided twice"):
        Signals(board, [Provider("one", lambda _: 1.0), Provider("one", lambda _: 2.0)])


@pytest.mark.parametrize(
    ("compute", "length", "why"),
    [
        (raises, None, "ZeroDivisionError: no such luck"),
        (lambda _: math.nan, None, "finite number"),
        (lambda _: (0.0, math.inf), 2, "finite numbers"),
        (lambda _: (0.0,), 2, "tuple of 2"),
        (lambda _: "red", None, "finite number"),
    ],
    ids=["raises", "not a number", "infinite", "too short", "a text"],
)
def test_a_provider_that_raises_is_switched_off_and_named_with_its_dependants(
    board: DeviceBoard, compute: Callable[[Mapping[str, Value]], Any], length: int | None, why: str
) -> None:
    broken = Provider("broken", compute, length=length)
    signals = Signals(board, [broken, Provider("next", lambda _: 1.0, "broken"), Provider("other", lambda _: 5.0)])

    with pytest.raises(SignalLost, match=why):
        signals.read("broken")
    with pytest.raises(SignalLost, match=f"maker of next needs 'broken'.*{why}") as raised:
        signals.read("next")
    board.exchange()
    assert signals.value("broken") is None

    assert raised.value.signal == "next"
    assert signals.read("other").value == 5.0
    assert broken.computed == 1
    assert list(signals.faults) == ["maker of broken"]


def test_after_a_reset_switched_off_providers_are_tried_again(board: DeviceBoard) -> None:
    values = iter([math.nan, 3.0])
    signals = Signals(board, [Provider("shaky", lambda _: next(values))])
    assert signals.value("shaky") is None

    signals.restart()
    board.exchange()

    assert signals.read("shaky").value == 3.0
    assert not signals.faults


def test_an_input_takes_effect_in_the_next_cycle(board: DeviceBoard) -> None:
    signals = Signals(board, [Input(Signal("limit"), 0.5), Provider("half", lambda i: i["limit"] / 2.0, "limit")])
    assert signals.read("half").value == 0.25

    signals.set("limit", 0.2)
    assert signals.read("limit").value == 0.5
    board.exchange()
    signals.update()

    assert signals.read("half").value == 0.1


@pytest.mark.parametrize("value", [math.nan, "fast", (1.0,)])
def test_an_input_takes_only_finite_values_of_its_shape(board: DeviceBoard, value: Any) -> None:
    signals = Signals(board, [Input(Signal("limit"), 0.5)])

    with pytest.raises(UsageError, match="limit"):
        signals.set("limit", value)


def test_computed_and_unknown_signals_cannot_be_set(board: DeviceBoard) -> None:
    signals = Signals(board, [Provider("one", lambda _: 1.0)])

    with pytest.raises(UsageError, match="comes from maker of one: only inputs"):
        signals.set("one", 2.0)
    with pytest.raises(UnknownName):
        signals.set("two", 2.0)


def test_a_worker_result_is_used_after_its_latency_and_then_the_next_is_requested(board: DeviceBoard) -> None:
    asked: list[float] = []

    def ask(inputs: Mapping[str, Value]) -> Done[float]:
        asked.append(float(len(asked)))
        return Done(asked[-1], latency=0.01)  # two periods

    signals = Signals(board, [Latest(Signal("seen"), ask)])

    seen = []
    for _ in range(6):
        seen.append(signals.value("seen"))
        board.exchange()
        signals.update()

    assert seen == [None, None, 0.0, 0.0, 1.0, 1.0]


@settings(deadline=None)
@given(st.permutations(range(6)), st.data())
def test_signals_of_any_acyclic_graph_are_computed_after_their_inputs(order: list[int], data: st.DataObject) -> None:
    view = world_of(robot_turtle()).snapshot()
    board = DeviceBoard(FakeCell(read_cell(view, view.instances("sk:Robot"))))
    reads = {n: data.draw(st.sets(st.integers(0, n - 1))) if n else set() for n in range(6)}

    def provider(n: int) -> SignalProvider:
        names = [f"s{one}" for one in sorted(reads[n])]
        return Provider(f"s{n}", lambda inputs: 1.0 + sum(float(inputs[name]) for name in names), *names)  # type: ignore[arg-type]

    signals = Signals(board, [provider(n) for n in order])
    expected: dict[int, float] = {}
    for n in range(6):
        expected[n] = 1.0 + sum(expected[one] for one in reads[n])

    assert {n: signals.read(f"s{n}").value for n in order} == expected


def hangs(_inputs: Mapping[str, Value]) -> float:
    while True:
        pass


def test_a_provider_that_hangs_is_interrupted_and_named_and_the_others_continue_after_a_reset(
    board: DeviceBoard,
) -> None:
    cycle = ControlCycle(board)
    signals = cycle.signals = Signals(board, [Provider("stuck", hangs), Provider("fine", lambda _: 1.0)])
    with Watchdog(cycle, 0.1, again=0.1):
        assert signals.value("stuck") is None
        assert "maker of stuck held the control cycle" in signals.faults["maker of stuck"]
        assert "maker of stuck" in cycle.halted

        cycle.stop_all()
        cycle.reset()
        cycle.step()

    assert signals.read("fine").value == 1.0


def test_a_provider_that_reads_a_missing_signal_of_a_plug_in_is_left_out_and_named(board: DeviceBoard) -> None:
    providers = [Provider("softer", lambda _: 1.0, "soft"), Provider("fine", lambda _: 5.0)]
    signals = Signals(board, providers, missing="signals 'soft' of lab 1.0: KeyError: 'no'")

    assert signals.value("fine") == 5.0
    assert "reads 'soft', and none provides it (signals 'soft' of lab 1.0: KeyError: 'no')" in signals.why_not("softer")

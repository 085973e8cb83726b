"""Any function of a kind of device that raises, hangs or returns NaN is named; its users fail, and the rest goes on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import pytest

from skiros_py.devices.gripper import GripperSpec
from skiros_py.devices.mobile_base import Base, BaseSpec, BaseTwist, FakeBase
from skiros_py.errors import DeviceError, SkirosError
from skiros_py.geometry import Pose
from skiros_py.ports.adapters import NO_PORTS
from skiros_py.ports.board import Mobile
from skiros_py.ports.device import DeviceModel, DeviceSignal, DeviceSpec, LocalisingSpec, MobileSpec
from skiros_py.recording import Recording, RecordingWriter
from skiros_py.recording.recorder import Devices
from skiros_py.recording.topic import Topic, own_schema
from skiros_py.skills.outcome import Outcome
from skiros_py.skills.parameters import Access, Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.testing import Bench, tiny_world

LIMIT = 0.3


class Fault:
    """A mistake in one function, from the moment on when it is begun."""

    def __init__(self, how: str) -> None:
        self.how = how
        self.begun = False

    def make(self, original: Any) -> Any:
        """Returns the function, or property, with the mistake."""
        if isinstance(original, property):
            assert original.fget is not None
            return property(self.make(original.fget), lambda _self, _value: None)

        def function(*arguments: Any, **options: Any) -> Any:
            if not self.begun:
                return original(*arguments, **options)
            if self.how == "raises":
                raise ZeroDivisionError("no such luck")
            while self.how == "hangs":
                pass
            return math.nan

        return classmethod(lambda _cls, *given: function(*given)) if isinstance(original, classmethod) else function


class Push(Primitive["Push.Params"]):
    """Drives at a constant speed and lets others drive, too."""

    name: ClassVar[str] = "push"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE, access=Access.SHARED)

    def execute(self) -> Execution[Outcome]:
        while True:
            Base(self.context.board, self.params.base).command(BaseTwist(0.2, 0.0))
            yield


class Shove(Push):
    """The same under another name."""

    name: ClassVar[str] = "shove"


class Drive(Push):
    """Follows a path again and again."""

    name: ClassVar[str] = "drive"

    def execute(self) -> Execution[Outcome]:
        base = Mobile(self.context.board, self.params.base)
        while True:
            pose = self.context.frames.at(self.context.board.snapshot).robot(base.id)
            path = base.direct_path(pose, pose @ Pose((1.0, 0.0, 0.0)))
            _, target = next(base.follow(path, partial(Pose, pose.position, pose.orientation)))
            base.command(target)
            yield


class See(Push):
    """Asks where everything is."""

    name: ClassVar[str] = "see"

    def execute(self) -> Execution[Outcome]:
        while True:
            frames = self.context.frames.at(self.context.board.snapshot)
            for group in self.context.cell.groups:
                frames.joints(group)
            frames.located("gripper_1")
            yield


class Feel(Push):
    """Reads a signal of the base."""

    name: ClassVar[str] = "feel"

    def execute(self) -> Execution[Outcome]:
        while True:
            self.context.signals.read("base_1.linear")
            yield


def push_both(bench: Bench) -> None:
    bench.start("push", base="base_1")
    bench.start("shove", base="base_1")


def run(module: str) -> Callable[[Bench], None]:
    return lambda bench: bench.start(module, base="base_1") and None


def push_and_pause(bench: Bench) -> None:
    running = bench.start("push", base="base_1")
    bench.cycle.observe(running.task.pause)


IN_THE_CYCLE: dict[str, tuple[type, Callable[[Bench], None]]] = {
    "state": (FakeBase, run("push")),
    "command": (FakeBase, run("push")),
    "braking_time": (FakeBase, run("push")),
    "check": (BaseSpec, run("push")),
    "scaled": (BaseSpec, push_and_pause),
    "mixed": (BaseSpec, push_both),
    "still": (BaseSpec, run("push")),
    "pose": (BaseSpec, run("drive")),
    "direct_path": (BaseSpec, run("drive")),
    "follow": (BaseSpec, run("drive")),
    "joint_positions": (GripperSpec, run("see")),
    "platform": (GripperSpec, run("see")),
}
"""Functions that the control thread calls: on what they are broken, and what calls them."""
AT_THE_START = {
    "read",
    "fake",
    "simulate",
    "joint_names",
    "frame_names",
    "mounted_on",
    "platform_link",
    "mounting",
}
"""What a cell is brought up with: it is refused by name."""
ELSEWHERE = {"encode", "decode_state", "decode_target", "noisy", "planned_poses", "has_arrived"}
"""What recordings, requests and tests call in threads of their own."""
CONSTANT = {"state_type", "target_type", "signals", "carries", "jog", "teach", "id"} | {
    "start", "footprint", "mixes", "signal", "plans_motions", "drives_sideways"
}  # fmt: skip


def members() -> set[str]:
    kinds = (DeviceSpec, LocalisingSpec, MobileSpec, DeviceModel)
    return {name for kind in kinds for name in vars(kind) if not name.startswith("_")}


def test_each_function_of_a_device_kind_is_covered() -> None:
    assert members() == {*IN_THE_CYCLE, *AT_THE_START, *ELSEWHERE, *CONSTANT}


UNUSED = {("command", "returns NaN"), ("check", "returns NaN")}
"""What these return means nothing."""
CASES = [
    pytest.param(member, how, id=f"{member} {how}")
    for member in IN_THE_CYCLE
    for how in ("raises", "hangs", "returns NaN")
    if (member, how) not in UNUSED
]


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    with Bench(tiny_world(), (), [Push, Shove, Drive, See, Feel], overrun=LIMIT) as bench:
        monkeypatch.setattr(GripperSpec, "carries", True)
        monkeypatch.setattr(GripperSpec, "platform", lambda _self, _state: Pose())
        yield bench


def text_of(bench: Bench) -> str:
    """Returns what is known about what broke."""
    board = bench.cycle.board
    return " ".join([bench.cycle.halted, *board.guard.off.values(), *board.unmixed.values()])


@pytest.mark.parametrize(("member", "how"), CASES)
def test_a_failing_device_kind_function_is_named_and_only_its_device_is_switched_off(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, member: str, how: str
) -> None:
    on, begin = IN_THE_CYCLE[member]
    fault = Fault(how)
    original = getattr(on, member, None) if member != "braking_time" else property(lambda _self: 0.0)
    monkeypatch.setattr(on, member, fault.make(original), raising=False)
    ticks: list[float] = []
    bench.cycle.observe(lambda: ticks.append(bench.time))
    begin(bench)
    bench.advance(0.05)
    fault.begun = True
    if member == "braking_time":
        bench.cycle.stop_all("everything")
    elif member == "still":
        bench.managers["base_1"].stop()
    for _ in range(30):
        bench.cycle.step()

    device = "gripper_1" if on is GripperSpec else "base_1"
    assert ticks[-1] == pytest.approx(bench.time), "the cycle goes on"
    assert member in text_of(bench) or "mix rule" in text_of(bench)
    assert device in text_of(bench) or "kind 'base'" in text_of(bench)
    assert bool(bench.cycle.halted) == (how == "hangs" or member in ("command", "braking_time"))
    assert bench.cycle.board.still
    assert all(running.done for manager in bench.managers.values() for running in manager.running.values())
    if device in bench.cycle.board.guard.off:
        with pytest.raises(DeviceError, match=device):
            bench.cycle.board.send(device, BaseTwist(0.1, 0.0))
        assert device in bench.signals.why_not(f"{device}.{'gap' if on is GripperSpec else 'linear'}")

    fault.begun = False
    bench.cycle.reset()
    bench.start("push", base="base_1")
    bench.advance(0.05)
    assert bench.cycle.board.snapshot.devices["base_1"].linear == 0.2, "after a reset it gets another try"


@pytest.mark.parametrize("how", ["raises", "hangs", "returns NaN"])
def test_signals_of_a_failing_device_are_switched_off_and_their_readers_fail_by_name(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    fault = Fault(how)
    signal = DeviceSignal("linear", fault.make(lambda state: state.linear), "m/s", "speed")
    monkeypatch.setattr(BaseSpec, "signals", (signal,))
    bench.cycle.observe(lambda: bench.signals.value("base_1.linear"))
    feeling = bench.start("feel", base="base_1")
    bench.advance(0.05)
    fault.begun = True
    bench.advance(0.05)

    assert feeling.done
    assert "base_1.linear" in feeling.result.reason or "base_1.linear" in bench.cycle.halted
    assert bool(bench.cycle.halted) == (how == "hangs")
    assert "switched off" in bench.signals.why_not("base_1.linear")
    assert "base_1" not in bench.cycle.board.guard.off


@pytest.mark.parametrize("how", ["raises", "returns NaN"])
@pytest.mark.parametrize("member", sorted(AT_THE_START - {"simulate"}))
def test_a_device_that_fails_at_the_start_of_a_cell_is_refused_by_name(
    monkeypatch: pytest.MonkeyPatch, member: str, how: str
) -> None:
    fault = Fault(how)
    original = next(vars(one)[member] for one in BaseSpec.__mro__ if member in vars(one))
    monkeypatch.setattr(BaseSpec, member, fault.make(original))
    fault.begun = True

    with pytest.raises(SkirosError, match=r"base_1 \(kind 'base'") as refused:
        Bench(tiny_world(), ()).close()

    assert member in str(refused.value)


@pytest.mark.parametrize("how", ["raises", "hangs"])
def test_a_device_kind_that_fails_during_recording_is_no_longer_recorded(
    monkeypatch: pytest.MonkeyPatch, how: str, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("skiros_py.recording.recorder._LONGEST", LIMIT)
    fault = Fault(how)
    monkeypatch.setattr(GripperSpec, "joint_positions", fault.make(GripperSpec.joint_positions))
    with Bench(tiny_world(), ()) as bench:
        devices, written = Devices(bench.context.cell, NO_PORTS), list[str]()
        devices.take(bench.cycle.board.snapshot, lambda topic, _time, _value: written.append(topic.name))
        fault.begun = True
        bench.advance(0.1)
        devices.take(bench.cycle.board.snapshot, lambda *_: None)

    assert "/devices/gripper_1" in written
    assert "/devices/gripper_1 is no longer recorded: its kind 'gripper'" in caplog.text


@pytest.mark.parametrize("how", ["raises", "hangs"])
def test_a_failing_encoder_ends_its_topic_and_the_recording_continues(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    monkeypatch.setattr("skiros_py.recording.writer._LONGEST", LIMIT)
    fault = Fault(how)
    fault.begun = True
    writer = RecordingWriter(tmp_path / "run.mcap")
    writer.put(Topic("/odd", own_schema(BaseTwist), fault.make(lambda _time, value: value)), 0.0, BaseTwist(0.0, 0.0))
    writer.put(Topic("/good", own_schema(BaseTwist)), 0.0, BaseTwist(0.0, 0.0))
    writer.close()

    with Recording(tmp_path / "run.mcap") as recording:
        assert set(recording.topics) == {"/good"}

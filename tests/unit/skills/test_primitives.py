"""What authors of primitives get wrong is said in words that help them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.devices.arm import Arm
from skiros_py.devices.gripper import Gripper
from skiros_py.devices.mobile_base import Base
from skiros_py.errors import DescriptionError
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.testing import run_primitive, tiny_world


class Calm(Primitive["Calm.Params"]):
    """Does nothing."""

    name: ClassVar[str] = "calm"

    @dataclass(frozen=True, slots=True)
    class Params:
        pass

    def execute(self) -> Execution[Outcome]:
        yield
        return Success()


def failure_of(code: Callable[[Any], Any]) -> str:
    """Runs a primitive whose execution is that code; returns why it failed."""

    class Wrong(Calm):
        name: ClassVar[str] = "wrong"

        def execute(self) -> Execution[Outcome]:
            yield
            made = code(self)
            yield from made if made is not None else ()
            return Success()

    trial = run_primitive(Wrong, tiny_world(), primitives=[Calm])
    assert isinstance(trial.outcome, Failure)
    return trial.reason


def takes_time(*_: Any) -> Any:
    yield


async def is_async(*_: Any) -> None:
    pass


@pytest.mark.parametrize("method", ["load", "start", "stop", "reset"])
@pytest.mark.parametrize("code", [takes_time, is_async])
@pytest.mark.parametrize("kind", [classmethod, staticmethod, lambda code: code])
def test_methods_that_are_called_once_must_not_be_generators(
    method: str, code: Any, kind: Callable[[Any], Any]
) -> None:
    with pytest.raises(DescriptionError, match=rf"{method}\(\) of primitive Slow: .* would never run"):
        type("Slow", (Calm,), {method: kind(code)})


def test_recover_may_take_several_cycles() -> None:
    type("Careful", (Calm,), {"recover": takes_time})


@pytest.mark.parametrize("answer", [Success("already there"), True, "ready", takes_time()])
def test_start_returns_a_failure_or_none(answer: Any) -> None:
    class Early(Calm):
        def start(self) -> Failure | None:
            return answer  # type: ignore[no-any-return]

    trial = run_primitive(Early, tiny_world())

    assert isinstance(trial.outcome, Failure)
    assert "start() returned" in trial.reason
    assert "None lets it run, a Failure refuses" in trial.reason


@pytest.mark.parametrize(
    ("code", "told"),
    [
        (lambda own: own.join(1, None), "join() takes calls, one by one, such as self.call('drive'), not 1"),
        (lambda own: own.join(own.call("calm"), None), "such as self.call('drive'), not None"),
        (lambda own: own.join([own.call("calm")]), "join() takes calls, one by one"),
        (lambda own: own.wait(None), "wait() takes an answer that is on its way, such as camera.capture(), not None"),
    ],
)
def test_a_value_that_cannot_be_awaited_fails_its_run_with_a_message(code: Callable[[Any], Any], told: str) -> None:
    assert told in failure_of(code)


@pytest.mark.parametrize(
    ("device", "kind"),
    [
        (lambda board: Base(board, "base_1"), "BaseTwist"),
        (lambda board: Arm(board, "arm_1"), "ArmTarget"),
        (lambda board: Gripper(board, "gripper_1"), "GripperTarget"),
    ],
)
@pytest.mark.parametrize("command", ["full ahead", None, 0.5])
def test_a_device_says_what_it_is_commanded_by(device: Callable[[Any], Any], kind: str, command: object) -> None:
    told = failure_of(lambda own: device(own.context.board).command(command))

    assert f"it is commanded by a {kind}, not by {command!r}" in told


def test_endlessly_recursive_primitives_are_ended_with_a_reason() -> None:
    class Ping(Calm):
        """Calls pong."""

        name: ClassVar[str] = "ping"

        def execute(self) -> Execution[Outcome]:
            return (yield from self.call("pong"))

    class Pong(Calm):
        """Calls ping."""

        name: ClassVar[str] = "pong"

        def execute(self) -> Execution[Outcome]:
            return (yield from self.call("ping"))

    trial = run_primitive(Ping, tiny_world(), primitives=[Pong])

    assert isinstance(trial.outcome, Failure)
    assert "modules call each other without end: pong > ping > pong > ping" in trial.reason

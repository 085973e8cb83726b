"""Adapters: which of those that are installed serves a device, how often it is made, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import DeviceError, UnknownName, UsageError
from skiros_py.ports.adapters import InstalledPorts
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import ArmPlanner

ADAPTERS = """
from typing import Protocol
from skiros_py.ports.adapters import Adapter
from skiros_py.ports.motion import ArmPlanner

class Tracker(Protocol):
    pass

class Made:
    def __init__(self, request):
        self.groups = [group.id for group in request.groups]
        self.device = request.device and request.device.id
        self.closed = False
    def close(self):
        self.closed = True

def broken(request):
    raise ValueError("no camera")

CELL = Adapter((Tracker,), Made)
ROBOT = Adapter((Tracker,), Made, one_for="robot")
DEVICE = Adapter((Tracker,), Made, one_for="device")
LEFT = Adapter((ArmPlanner,), Made, serves=lambda device: device.id == "left", one_for="device", eager=False)
BROKEN = Adapter((Tracker,), broken)


def hangs(request):
    while True:
        pass


SHY = Adapter((Tracker,), Made, one_for="device", by_name=True)
STUCK = Adapter((Tracker,), hangs)
RUDE = Adapter((ArmPlanner,), Made, serves=lambda device: device.nothing, one_for="device")
FAKE = Adapter((Tracker,), Made, without_physics=True)
"""

ARMS = [ArmSpec(name, ("j",), "tip", (0.0,)) for name in ("left", "right", "third")]
ROBOTS = (RobotSpec("one", "", (ARMS[0], ARMS[1])), RobotSpec("two", "", (ARMS[2],)))


@pytest.fixture
def install(site: Any) -> Any:
    def install(name: str, **adapters: str) -> Any:
        module = f"{name.replace('-', '_')}_adapters"
        entries = {entry: f"{module}:{adapter}" for entry, adapter in adapters.items()}
        site.install(name, {"adapters": entries}, {f"{module}.py": ADAPTERS})
        return __import__(module)

    return install


@pytest.mark.parametrize(("scope", "groups", "device"), [
    ("CELL", ["one", "two"], None), ("ROBOT", ["one"], None), ("DEVICE", ["one"], "left"),
])  # fmt: skip
def test_an_adapter_is_created_once_for_all_devices_that_share_it(
    install: Any, scope: str, groups: list[str], device: Any
) -> None:
    module = install(f"sk-{scope.lower()}", tracker=scope)
    ports = InstalledPorts(ROBOTS)

    adapters = [ports.port(module.Tracker, arm.id) for arm in ARMS]

    assert (adapters[0].groups, adapters[0].device) == (groups, device)
    assert len(set(map(id, adapters))) == {"CELL": 1, "ROBOT": 2, "DEVICE": 3}[scope]
    ports.close()
    assert all(adapter.closed for adapter in adapters)


def test_a_foreign_adapter_takes_precedence_for_the_devices_that_it_serves(install: Any) -> None:
    module = install("sk-left", left="LEFT")
    ports = InstalledPorts(ROBOTS)
    try:
        assert isinstance(ports.port(ArmPlanner, "left"), module.Made)
        assert type(ports.port(ArmPlanner, "right")).__module__ == "skiros_py.motion.adapters"
    finally:
        ports.close()


def test_two_foreign_adapters_for_one_port_are_refused_by_name(install: Any) -> None:
    install("sk-first", first="LEFT")
    install("sk-second", second="LEFT")

    with pytest.raises(UsageError, match=r"ArmPlanner of left: first of sk-first 0.3 and second of sk-second 0.3"):
        InstalledPorts(ROBOTS)


def named(device: str, *names: str) -> tuple[RobotSpec, ...]:
    """Returns the robots, of which one device names adapters."""
    return tuple(replace(one, adapters=((device, names),)) if one.has(device) else one for one in ROBOTS)


@pytest.mark.parametrize("name", ["first", "second"])
def test_of_two_plug_in_adapters_the_one_named_by_the_device_is_used(install: Any, name: str) -> None:
    made = {entry: install(f"sk-{entry}", **{entry: "LEFT"}).Made for entry in ("first", "second")}
    ports = InstalledPorts(named("left", "kinematics", name))

    assert type(ports.port(ArmPlanner, "left")) is made[name]


def test_devices_may_name_different_adapters_of_the_cell(site: Any) -> None:
    text = ADAPTERS + "FIRST, SECOND = (Adapter((Tracker,), Made) for _ in range(2))"
    site.install("sk-two", {"adapters": {"first": "sk_two:FIRST", "second": "sk_two:SECOND"}}, {"sk_two.py": text})
    tracker = __import__("sk_two").Tracker
    ports = InstalledPorts((replace(ROBOTS[0], adapters=(("left", ("first",)), ("right", ("second",)))),))

    assert ports.port(tracker, "left") is not ports.port(tracker, "right")
    assert ports.find(tracker) is None


def test_a_device_may_name_the_built_in_adapter(install: Any) -> None:
    install("sk-left", left="LEFT")
    ports = InstalledPorts(named("left", "arm-planner"))
    try:
        assert type(ports.port(ArmPlanner, "left")).__module__ == "skiros_py.motion.adapters"
    finally:
        ports.close()


def test_an_adapter_by_name_serves_only_devices_that_name_it(install: Any) -> None:
    module = install("sk-shy", shy="SHY")
    ports = InstalledPorts(named("left", "shy"))

    assert isinstance(ports.port(module.Tracker, "left"), module.Made)
    assert ports.find(module.Tracker, "right") is None


def test_an_adapter_that_is_not_installed_is_refused_with_those_that_are(install: Any) -> None:
    install("sk-left", left="LEFT")

    with pytest.raises(UnknownName, match=r"unknown adapter 'lefty' of left .*Did you mean 'left'.* arm-planner, "):
        InstalledPorts(named("left", "lefty"))


def test_an_adapter_that_does_not_serve_the_device_that_names_it_is_refused_with_those_that_do(install: Any) -> None:
    install("sk-left", left="LEFT")

    with pytest.raises(UsageError, match=r"right names adapter 'left' .* does not serve it; .*arm-planner, "):
        InstalledPorts(named("right", "left"))


def test_an_adapter_named_by_a_robot_must_serve_at_least_one_of_its_devices(install: Any) -> None:
    module = install("sk-left", left="LEFT")
    one, two = (replace(robot, adapters=((robot.id, ("left",)),)) for robot in ROBOTS)

    assert isinstance(InstalledPorts((one,)).port(ArmPlanner, "left"), module.Made)
    with pytest.raises(UsageError, match=r"two names adapter 'left' .* does not serve it"):
        InstalledPorts((two,))


def test_two_named_adapters_for_one_port_are_refused(install: Any) -> None:
    install("sk-left", left="LEFT")

    with pytest.raises(UsageError, match=r"ArmPlanner of left: arm-planner of skiros-py .* and left of sk-left 0.3"):
        InstalledPorts(named("left", "left", "arm-planner"))


def test_an_adapter_that_raises_is_named_with_its_distribution(install: Any) -> None:
    module = install("sk-broken", broken="BROKEN")

    with pytest.raises(DeviceError, match=r"'broken' of sk-broken 0.3 breaks: ValueError: no camera"):
        InstalledPorts(ROBOTS).port(module.Tracker)


def test_a_cell_without_physics_has_only_adapters_that_need_no_physics(install: Any) -> None:
    physical, fake = install("sk-cell", tracker="CELL"), install("sk-fake", tracker2="FAKE")
    ports = InstalledPorts(ROBOTS, physics=False)

    assert ports.find(physical.Tracker) is None
    assert ports.find(ArmPlanner, "left") is None
    assert ports.find(fake.Tracker) is not None


def test_an_object_that_is_not_an_adapter_is_left_out_with_a_warning(
    site: Any, caplog: pytest.LogCaptureFixture
) -> None:
    site.install("sk-number", {"adapters": {"seven": "sk_number:SEVEN"}}, {"sk_number.py": "SEVEN = 7"})

    assert InstalledPorts(ROBOTS).find(int) is None
    assert "it is a int, nothing for adapters: name an Adapter" in caplog.text


def test_an_adapter_that_raises_when_asked_what_it_serves_is_not_used_and_named(
    install: Any, caplog: pytest.LogCaptureFixture
) -> None:
    module = install("sk-rude", rude="RUDE")
    ports = InstalledPorts(ROBOTS)
    try:
        assert not isinstance(ports.find(ArmPlanner, "right"), module.Made)
    finally:
        ports.close()
    assert "adapter 'rude' of sk-rude 0.3 is not used for right: its serves raised AttributeError" in caplog.text


def test_an_adapter_that_hangs_when_it_is_made_is_interrupted_and_named(
    install: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("skiros_py.ports.adapters._LONGEST", 0.2)
    module = install("sk-stuck", stuck="STUCK")

    with pytest.raises(DeviceError, match=r"'stuck' of sk-stuck 0.3 breaks: .* make did not end within 0.2 s"):
        InstalledPorts(ROBOTS).port(module.Tracker)

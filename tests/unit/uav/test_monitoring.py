"""The monitor of a battery runs beside what else runs, and says when the battery has to be charged."""

from __future__ import annotations

from pathlib import Path

import pytest

import skiros_uav
from skiros_py.skills.outcome import Failure
from skiros_py.station.session import Options, Session

SCENE = Path(skiros_uav.__file__).parent / "scenes" / "delivery_uav.ttl"
MONITOR = {"battery": "battery_1", "robot": "robot_1"}


@pytest.fixture
def low_scene(tmp_path: Path) -> str:
    """A scene whose battery is a little above the low level, and is charged nowhere near."""
    own = 'scene:battery_1 uav:chargeLevel 0.3001 ; uav:chargers "5 5"^^sk:vectorLiteral'
    text = SCENE.read_text().replace('scene:battery_1 uav:chargers "-2.5 0"^^sk:vectorLiteral', own)
    assert own in text
    path = tmp_path / "low.ttl"
    path.write_text(text)
    return str(path)


def test_it_runs_on_beside_all_else_and_writes_once_when_the_charge_is_low(
    low_scene: str, caplog: pytest.LogCaptureFixture
) -> None:
    changes = []
    with Session(low_scene, Options(fake=True)) as session:
        base, world = session.managers["base_1"], session.world
        world.subscribe(lambda change: changes.append(change.author))
        base.launch("monitor_battery", MONITOR)
        session.cycle.step()
        assert world.value("robot_1", "uav:batteryLow") is False

        for _ in range(3):
            base.launch("monitor_battery", MONITOR)
            for _ in range(5000):
                session.cycle.step()

        assert world.value("robot_1", "uav:batteryLow") is True
    assert changes.count("monitor_battery") == 1
    assert "progress" not in caplog.text


def test_where_it_is_not_charged_charging_says_so(low_scene: str) -> None:
    with Session(low_scene, Options(fake=True)) as session:
        charging = session.managers["base_1"].start("recharge", MONITOR)
        session.runtime.finish(charging.task)

    assert charging.task.result == Failure("battery_1 is not being charged here")

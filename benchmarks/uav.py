"""Robots that fly: deliveries, and batteries that fall in flight; judged by the simulator's truth."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from table import Figure, finish

from skiros_py.station.session import Options, Session
from skiros_uav.aerial_base import AerialState
from skiros_uav.battery import SimulatedBattery

_SCENE = "delivery_uav"
_DELIVERIES, _FALLS = 20, 10
_LOW = 0.29
_FLOWN = (6.0, 60.0)  # when the battery falls, of a delivery that takes about 80 s [s]


@dataclass
class Flight:
    """One delivery.

    Attributes:
        delivered: Whether the part is where it should be, by the simulator's truth.
        seconds: How long it took [s].
        steps: What was done.
        fell: When the battery fell in flight [s]; None where it did not.
        landed: Where and when it landed then: x, y, z [m], time [s]; None where it did not.
        met: What it touched besides the ground, by then.
        reason: Why the goal was not reached.
    """

    delivered: bool = False
    seconds: float = 0.0
    steps: tuple[str, ...] = ()
    fell: float | None = None
    landed: tuple[float, float, float, float] | None = None
    met: tuple[str, ...] = ()
    reason: str = ""

    @property
    def is_safe(self) -> bool:
        """Whether it landed at the charger, on its skids, and touched nothing but the part on the way."""
        return self.landed is not None and self.landed[2] < 0.02 and not self.met


def fly(seed: int, engine: str, falls: float | None = None) -> Flight:
    """Flies one delivery.

    Args:
        seed: Of the run.
        engine: Name of the engine.
        falls: From when on the battery falls low in flight [s]; None for never.
    """
    flight = Flight()
    with Session(_SCENE, Options(seed=seed, simulation=engine)) as session:
        if falls is not None:
            session.cycle.observe(_falling(session, flight, falls))
        report = session.run()
        flight.delivered = report.reached and all(one.true for one in report.conditions)
        flight.seconds = report.simulated
        flight.reason = "; ".join((*report.no_plan, *(one.reason for one in report.conditions if one.reason)))
        flight.steps = tuple(step.skill for step in report.steps)
    return flight


def _falling(session: Session, flight: Flight, falls: float) -> Callable[[], None]:
    """Returns what lets the battery fall once in flight, and notes where the robot lands then."""
    robot = session.simulation.scene.robots[0]
    battery = robot.devices["battery_1"]
    assert isinstance(battery, SimulatedBattery)

    def look() -> None:
        snapshot = session.cycle.board.snapshot
        state = snapshot.state("base_1", AerialState)
        if flight.fell is None:
            if snapshot.time >= falls and not state.landed:
                battery.level, flight.fell = _LOW, snapshot.time
        elif flight.landed is None:
            touched = {one.other for one in robot.model.engine.contacts(robot.model.name, "base_link")} - {"floor"}
            flight.met = tuple(sorted({*flight.met, *touched}))
            if state.landed:
                flight.landed = (*state.pose.position, snapshot.time)

    return look


def main() -> int:
    """Flies all deliveries; prints the table."""
    engine = sys.argv[1] if len(sys.argv) > 1 else "pybullet"
    count = int(sys.argv[2]) if len(sys.argv) > 2 else _DELIVERIES
    falls = int(sys.argv[3]) if len(sys.argv) > 3 else _FALLS
    rng = np.random.default_rng(18)
    flights = [_told(f"delivery {seed}", fly(seed, engine)) for seed in range(count)]
    fallen = [
        _told(f"fall {seed}", fly(100 + seed, engine, float(when)))
        for seed, when in enumerate(rng.uniform(*_FLOWN, falls))
    ]
    delivered, safe = sum(one.delivered for one in flights), sum(one.is_safe for one in fallen)
    on = sum(one.delivered for one in fallen)
    figures = []
    if flights:
        middle = float(np.median([one.seconds for one in flights]))
        said = f"{delivered} of {count} (median {middle:.0f} s simulated)"
        figures.append(Figure(f"deliveries by air, {engine}", said, f"{count} of {count}", delivered == count))
    if fallen:
        said = f"{safe} of {falls}; {on} of them delivered after charging"
        figures.append(
            Figure(f"battery falls in flight: lands safely, {engine}", said, f"{falls} of {falls}", safe == falls)
        )
    return finish("uav", figures)


def _told(name: str, flight: Flight) -> Flight:
    print(f"{name}: {flight}", flush=True)
    return flight


if __name__ == "__main__":
    sys.exit(main())

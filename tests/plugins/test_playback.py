from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_primitives.playback import Playback
from skiros_py.devices.arm import ArmTarget
from skiros_py.execution.task import RunClock
from skiros_py.ports.motion import Trajectory

PERIOD = 0.005
TIMES = np.linspace(0.0, 1.0, 201)
SWING = Trajectory(
    np.column_stack([1.0 - np.cos(np.pi * TIMES), TIMES]), np.column_stack([np.pi * np.sin(np.pi * TIMES), TIMES**0])
)


class Run:
    """The time of a run."""

    def __init__(self, now: float = 0.0) -> None:
        self.now = now


def played(cycles: int, *, pause: int = -1, resume: int = -1, first: int = 0) -> list[ArmTarget]:
    """The targets of so many cycles; the clock is paused and resumed at given ones."""
    run = Run(first * PERIOD)
    clock = RunClock(run)
    targets: list[ArmTarget] = []
    playback: Playback | None = None
    for cycle in range(cycles):
        if cycle == pause:
            clock.slow_down()
        if cycle == resume:
            clock.speed_up()
        run.now = (first + cycle) * PERIOD
        if not clock.steady:
            clock.advance()
        if clock.stands:
            continue
        playback = playback or Playback(SWING, PERIOD, clock.now)
        if not playback.ended:
            targets.append(playback.target(clock.now))
    return targets


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10**6))
def test_a_regular_clock_plays_each_sample_exactly_once(first: int) -> None:
    targets = played(300, first=first)

    assert [t.positions for t in targets] == [tuple(row) for row in SWING.positions[1:].tolist()]
    assert [t.velocities for t in targets] == [tuple(row) for row in SWING.velocities[1:].tolist()]


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 199), st.integers(70, 400))
def test_a_paused_trajectory_keeps_its_path_and_end(pause: int, length: int) -> None:
    targets = played(1000, pause=pause, resume=pause + length)

    done = np.array([t.positions for t in targets])
    assert done[-1] == pytest.approx(SWING.positions[-1])
    assert (np.diff(done[:, 1]) >= 0.0).all()
    assert np.abs(done[:, 0] - (1.0 - np.cos(np.pi * done[:, 1]))).max() < 1e-4


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 130))
def test_a_pause_brakes_smoothly_to_almost_zero_speed(pause: int) -> None:
    targets = played(pause + 100, pause=pause)

    steps = np.diff([t.positions[1] for t in targets]) / PERIOD
    speeds = np.array([t.velocities[1] for t in targets])
    assert np.abs(np.diff(steps)).max() < 0.05
    assert speeds[-1] < 0.05
    assert np.abs(steps - speeds[1:]).max() < 0.05


def test_a_trajectory_of_one_sample_has_no_targets() -> None:
    assert Playback(Trajectory(SWING.positions[:1], SWING.velocities[:1] * 0.0), PERIOD, 3.0).ended

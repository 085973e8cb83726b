"""Stopping one module in physics: its commands cease at once, and it has ended only when it stands."""

from __future__ import annotations

import itertools

import pytest

from skiros_py.devices.mobile_base import BaseState
from skiros_py.execution.monitor import Status
from skiros_py.skills.outcome import Failure

pytestmark = pytest.mark.physics


def test_a_stopped_drive_brakes_within_the_braking_time_and_counts_as_ended_only_when_it_stands(open_session):
    session = open_session("kitting_carried")
    board, events = session.cycle.board, []
    session.monitor.subscribe(lambda event: events.append((event.module, event.status, board.still)))
    running = session.start_module("drive", {"Location": "pallet_a"})
    while board.snapshot.state("base_1", BaseState).linear < 0.2:
        session.cycle.step()
    stopped_at, speeds = board.snapshot.time, []
    running.stop()

    assert running.status == "stopping"
    while not running.done:
        session.cycle.step()
        speeds.append(board.snapshot.state("base_1", BaseState).linear)
    assert max(after - before for before, after in itertools.pairwise(speeds)) < 0.02, "somebody still drives it"
    assert 0.05 < board.snapshot.time - stopped_at <= board.braking_time
    assert running.result == Failure("drive was stopped")
    assert events[-1] == ("drive", Status.PREEMPTED, True)
    assert session.managers.claims.request("the test", ["base_1"]).granted

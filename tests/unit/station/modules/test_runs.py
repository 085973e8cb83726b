"""How a module that is done many times over ends when everything is stopped meanwhile."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import skiros_py
from skiros_py.station.modules.runs import ModuleRun, ModuleRuns, Wish
from skiros_py.station.session import Session


@pytest.fixture
def session() -> Iterator[Session]:
    with skiros_py.open("kitting", fake=True) as session:
        yield session


def run_until_over(session: Session, run: ModuleRun) -> None:
    for _ in range(2000):
        if run.over:
            return
        session.cycle.step()
    raise AssertionError(f"still {run.status}")


def test_a_halt_between_two_rounds_stops_the_run_without_a_failed_round(session: Session) -> None:
    runs, started = ModuleRuns("run"), list[ModuleRun]()

    def halt_after_the_first() -> None:
        if started and started[0].running is not None and started[0].running.done:
            session.cycle.halt("somebody pressed the button")

    session.cycle.observe(halt_after_the_first)  # before the runs look whether a round is over
    runs.open(session)
    started.append(runs.start(session, Wish("base_1", "drive", {"Location": "pallet_a"}, "anna", repeat=3)))
    run_until_over(session, started[0])

    run = started[0]
    assert (run.status, run.done, run.succeeded, run.cut_off) == ("stopped", 1, 1, False)


def test_a_round_ended_by_a_halt_is_reported_as_such(session: Session) -> None:
    runs = ModuleRuns("run")
    runs.open(session)
    run = runs.start(session, Wish("base_1", "drive", {"Location": "pallet_a"}, "anna", repeat=3))
    session.cycle.step()
    session.cycle.step()
    assert not run.done
    session.cycle.halt("somebody pressed the button")
    run_until_over(session, run)

    assert (run.status, run.done, run.succeeded, run.cut_off) == ("stopped", 1, 0, True)

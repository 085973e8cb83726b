"""A cell without a base does kitting with the skills of the mobile robots; its plans have no drive."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from skiros_py.station.session import Session

pytestmark = pytest.mark.physics


@pytest.mark.parametrize("engine", ["pybullet", "mujoco"])
def test_a_cell_puts_a_part_into_its_kit_without_driving(open_session: Callable[..., Session], engine: str) -> None:
    session = open_session("kitting_cell", seed=3, simulation=engine)

    report = session.run(["ObjectAtLocation(Alternator, kit_1_b)"])

    assert report.reached
    assert [(c.believed, c.true) for c in report.conditions] == [(True, True)]
    assert [step.skill for step in report.steps if not step.reason] == ["pick", "place"]

"""A person builds the scene while nothing runs, then orders a goal with it: the robot finds things as they were put."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from support.serving import serving

from skiros_py.station.judgement import judge
from skiros_py.station.session import Options, Session
from skiros_py.tasks.jobs.job import JobOrder
from skiros_py.world.change import Writer
from skiros_py.world.element import Placement

pytestmark = pytest.mark.physics

GOAL = "ObjectAtLocation(starter_9, kit_1_a)"


def test_a_part_added_by_a_person_is_put_into_the_requested_place(tmp_path: Path) -> None:
    def truth(session: Session) -> tuple[bool | None, ...]:
        return judge(session.simulation, session.spec, session.world, session.parse([GOAL]))

    with serving("kitting", tmp_path / "data", Options(seed=1)) as served:
        services = served.services
        with services.station.session.world.transaction("ann", "one more", writer=Writer.PERSON) as tx:
            tx.add("kitting:Starter", id="starter_9", placement=Placement("sk:in", "pallet_b"))
            tx.remove("starter_1")
        before = services.station.control.call(truth)
        services.station.session.jobs.submit(JobOrder(id="job", goal=(GOAL,)))
        while services.station.session.jobs.job("job").state.is_open:
            time.sleep(0.1)

        assert before == (False,)
        assert services.station.control.call(truth) == (True,)
        assert services.station.session.jobs.job("job").outcome == "succeeded"

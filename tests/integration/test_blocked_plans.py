"""What blocks a target only while it lies in one place makes plans that move it first."""

from __future__ import annotations

from dataclasses import replace

from skiros_py.planning.plan import Plan
from skiros_py.planning.requests import RuledOut
from skiros_py.station.session import Options, Session

GOAL = ("ObjectAtLocation(starter_1, kit_1_a)", "ObjectAtLocation(alternator_1, kit_1_b)")


def picked(session: Session, *ruled_out: RuledOut) -> list[str]:
    """Returns which parts a plan picks, in its order; none where there is no plan."""
    request = session.tasks.plan_request(session._conditions(GOAL))
    outcome = session.planning.ask(replace(request, ruled_out=ruled_out)).result().value.outcome
    steps = outcome.steps if isinstance(outcome, Plan) else ()
    return [step.arguments["Object"] for step in steps if step.skill == "pick"]


def blocked(part: str, by: str) -> RuledOut:
    return RuledOut("pick", "arm_1", part, None, "fingers would touch what is beside it", (by, "pallet_a"))


def test_what_is_in_the_way_is_taken_first_whichever_it_is() -> None:
    with Session("kitting", Options(fake=True)) as session:
        starter_last = picked(session, blocked("starter_1", "alternator_1"))
        alternator_last = picked(session, blocked("alternator_1", "starter_1"))
        none = picked(session, blocked("starter_1", "alternator_1"), blocked("alternator_1", "starter_1"))

    with Session("kitting", Options(fake=True)) as session:
        kit = RuledOut("place", "arm_1", "kit_1_a", None, "no room", ("alternator_1", "kit_1_b"))
        both = picked(session, blocked("alternator_1", "starter_1"), kit)

    assert both == ["starter_1", "alternator_1"]
    assert starter_last == ["alternator_1", "starter_1"]
    assert alternator_last == ["starter_1", "alternator_1"]
    assert none == []

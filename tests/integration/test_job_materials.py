"""What a kitting job says of the parts it moved (fake): also where the program was killed in between."""

from pathlib import Path

from skiros_py.station.session import Options, Session
from skiros_py.tasks.jobs.job import JobOrder, Outcome


def materials(session: Session, job: str) -> list[tuple[str, str, str]]:
    return [(part.class_, part.origin, part.place) for part in session.jobs.job(job).materials]


def until(session: Session, skill: str, cycles: int = 40_000) -> None:
    """Runs jobs until a step of the job "a" has ended well."""
    for _ in range(cycles):
        if any(step.skill == skill and step.ended == "done" for step in session.jobs.intents("a")):
            return
        session.cycle.step()
    raise AssertionError("it was never reached")


def order(id_: str, goal: str) -> JobOrder:
    return JobOrder(id=id_, goal=(goal,))


def test_each_part_is_reported_with_its_origin_and_its_final_place(tmp_path: Path) -> None:
    with Session("kitting", Options(fake=True, data=tmp_path / "data")) as session:
        session.jobs.submit(order("a", "InKit(Starter, kit_1) and InKit(Alternator, kit_1)"))
        session.run_jobs()
        told = materials(session, "a")
        places = [session.world.placement(part.element).place for part in session.jobs.job("a").materials]
    assert [(class_, origin) for class_, origin, _ in told] == [
        ("kitting:Alternator", "pallet_a"),
        ("kitting:Starter", "pallet_a"),
    ]
    assert [place for *_, place in told] == places


def test_a_part_picked_before_a_restart_is_reported_with_its_original_place(tmp_path: Path) -> None:
    with Session("kitting", Options(fake=True, data=tmp_path / "data")) as session:
        session.jobs.submit(order("a", "InKit(Starter, kit_1)"))
        until(session, "pick")
    with Session("kitting", Options(fake=True, data=tmp_path / "data")) as session:
        assert materials(session, "a") == [("kitting:Starter", "pallet_a", "gripper_1")]
        session.jobs.answer("a", "retry", by="ann")
        session.run_jobs()
        ((_, origin, place),) = materials(session, "a")
        assert session.jobs.job("a").outcome is Outcome.SUCCEEDED
        assert (origin, place) == ("pallet_a", session.world.placement("starter_1").place)


def test_parts_moved_by_another_job_are_not_reported_for_a_halted_job(tmp_path: Path) -> None:
    with Session("kitting", Options(fake=True, data=tmp_path / "data")) as session:
        session.jobs.submit(order("a", "InKit(Starter, kit_1)"))
        until(session, "drive")
        session.cycle.stop_all("button")
        session.cycle.step()
        session.reset()
        session.jobs.submit(order("b", "InKit(Starter, kit_1)"))
        session.jobs.answer("a", "abort", by="ann")
        session.run_jobs()
        assert [class_ for class_, *_ in materials(session, "b")] == ["kitting:Starter"]
        assert materials(session, "a") == []
        assert session.jobs.job("a").outcome is not None

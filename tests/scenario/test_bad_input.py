"""What cannot be done, in physics: its own outcome with a reason, the robot left safe, the rest done; truth judges."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from skiros_py.devices.arm import ArmState
from skiros_py.devices.gripper import GripperState
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.cell import BodySpec
from skiros_py.simulation.truth import Truth
from skiros_py.skills.outcome import Failure, Success
from skiros_py.station.session import Session
from skiros_py.tasks.report import GoalReport
from skiros_py.world import vocabulary as v

pytestmark = pytest.mark.physics

Open = Callable[..., Session]
When = Callable[[Session, Callable[[], bool], Callable[[], None]], None]

SCENE = Path(__file__).parents[2] / "scenes" / "kitting_carried.ttl"
STARTER, COMPRESSOR = "ObjectAtLocation(Starter, kit_1_a)", "ObjectAtLocation(Compressor, kit_1_c)"
DEEP = """scene:pallet_a a kitting:Pallet ;
    sk:solid '[{"kind": "box", "size": [2.4, 2.0, 0.45], "at": [0.9, 0, 0.225]}]'^^<http://www.w3.org/1999/02/22-rdf-syntax-ns#JSON> ;
    sk:supportHalfExtents "1.1 0.9"^^sk:vectorLiteral ; sk:supportOffset "0.9 0 0.45"^^sk:vectorLiteral ;"""  # noqa: E501 - one literal
WALLED_IN = """scene:rack_1 a kitting:Rack ;
    sk:solid '[{"kind": "box", "size": [2.4, 0.1, 1.0], "at": [0, 1.2, 0.5]}, {"kind": "box", "size": [2.4, 0.1, 1.0], "at": [0, -1.2, 0.5]}, {"kind": "box", "size": [0.1, 2.5, 1.0], "at": [1.2, 0, 0.5]}, {"kind": "box", "size": [0.1, 2.5, 1.0], "at": [-1.2, 0, 0.5]}]'^^<http://www.w3.org/1999/02/22-rdf-syntax-ns#JSON> ;"""  # noqa: E501 - one literal
FALLS = 0.5
"""Speed downwards from which a part falls: one that is let go some millimetres over its place is slower [m/s]."""


def changed(folder: Path, *changes: tuple[str, str]) -> str:
    """The scene with some texts replaced."""
    text = SCENE.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / "changed.ttl"
    path.write_text(text, encoding="utf-8")
    return str(path)


def announced(session: Session, text: str, by: str = "grasp") -> Callable[[], bool]:
    """Whether a module has reported something since now."""
    heard: list[str] = []
    session.monitor.subscribe(lambda event: heard.append(event.text) if event.module == by else None)
    return lambda: text in heard


def heights(session: Session, part: str) -> list[float]:
    """Collects how high a part is, cycle by cycle [m]."""
    found: list[float] = []
    truth = Truth(session.simulation)
    session.cycle.observe(lambda: found.append(truth.pose(part).position[2]))
    return found


def fastest_fall(session: Session, found: Sequence[float]) -> float:
    return max((before - after) / session.cell.period for before, after in pairwise(found))


def silence(session: Session, monkeypatch: pytest.MonkeyPatch, since: Callable[[], bool], seconds: float) -> None:
    """Lets the camera answer nothing for a while, from the first picture on for which something holds."""
    capture, start = session.simulation.capture, list[float]()

    def asked(camera: str) -> Any:
        now = session.cycle.board.snapshot.time
        if not start and since():
            start.append(now)
        if start and now < start[0] + seconds:
            raise DeviceError(f"camera '{camera}' does not answer")
        return capture(camera)

    monkeypatch.setattr(session.simulation, "capture", asked)


def is_honest(report: GoalReport) -> bool:
    return [one.believed for one in report.conditions] == [one.true for one in report.conditions]


def where(session: Session, part: str) -> tuple[str, str]:
    """Where a part is by the truth, and where it is believed to be."""
    placement = session.world.placement(part)
    return Truth(session.simulation).placements()[part], placement.place if placement is not None else ""


def test_a_part_beyond_the_reach_of_the_arm_is_left_alone_with_that_reason(open_session: Open, tmp_path: Path) -> None:
    there = '"5.9 1.6 0.45 0 0 0"^^sk:poseLiteral'
    far = ("scene:starter_1 a kitting:Starter ;", f"scene:starter_1 a kitting:Starter ; sk:pose {there} ;")
    session = open_session(changed(tmp_path, ("scene:pallet_a a kitting:Pallet ;", DEEP), far), seed=2)
    session.cycle.observe(Truth(session.simulation).watch)

    report = session.run(["Holding(gripper_1, starter_1)"])

    assert not report.reached
    assert is_honest(report)
    assert [(step.skill, step.reason) for step in report.steps] == [
        ("drive", "starter_1 is out of reach of robot_1 from every side of pallet_a")
    ]
    assert report.steps[0].reason in report.conditions[0].reason
    assert where(session, "starter_1") == ("pallet_a", "pallet_a")
    assert session.cycle.board.still


def test_a_place_within_walls_is_given_up_with_its_name_and_what_is_elsewhere_is_done(
    open_session: Open, tmp_path: Path
) -> None:
    around_pallet_a = ("1.5 0 0 0 0 0", "5.0 1.6 0 0 0 0"), ("scene:rack_1 a kitting:Rack ;", WALLED_IN)
    session = open_session(changed(tmp_path, *around_pallet_a), seed=2)

    report = session.run([STARTER, COMPRESSOR])

    starter, compressor = report.conditions
    assert [step.arguments["Location"] for step in report.steps if step.reason] == ["pallet_a"] * 3
    assert (starter.believed, starter.true) == (False, False)
    assert "no way to pallet_a: at its goal the base would touch rack_1" in starter.reason
    assert (compressor.believed, compressor.true) == (True, True)


def test_into_a_covered_compartment_nothing_is_put_and_the_part_goes_into_another(
    open_session: Open, when: When
) -> None:
    session = open_session("kitting_carried", seed=2)
    truth, fell = Truth(session.simulation), heights(session, "starter_1")

    def cover() -> None:
        on_walls, lid = truth.pose("kit_1_a") @ Pose((0.0, 0.0, 0.034)), Solid.box(0.152, 0.152, 0.006)
        session.simulation.add_body(BodySpec("lid", "test:Lid", lid, pose=on_walls, mass=0.2))

    when(session, lambda: session.world.related("starter_1", v.HELD_BY, "gripper_1"), cover)
    refused = session.run([STARTER])
    held = where(session, "starter_1")
    report = session.run(["InKit(starter_1, kit_1)"])

    assert is_honest(refused)
    assert [step.reason for step in refused.steps if step.skill == "place"] == [
        "kit_1_a is taken: something of unknown shape is seen there"
    ]
    assert "kit_1_a is taken" in refused.conditions[0].reason
    assert held == ("gripper_1", "gripper_1")
    assert report.reached
    assert where(session, "starter_1")[0] != "kit_1_a"
    assert fastest_fall(session, fell) < FALLS


def test_fingers_that_close_on_nothing_say_so_open_and_the_arm_goes_up_again(open_session: Open, when: When) -> None:
    session = open_session("kitting_carried", seed=2)
    away = Pose((2.0, 2.6, 0.0))
    when(session, announced(session, "closing"), lambda: session.simulation.move_body("starter_1", away))

    report = session.run(["Holding(gripper_1, starter_1)"])

    first, second = (step.reason for step in report.steps if step.skill == "pick")
    assert "not in the gripper after the lift: gap 0 mm, force 0 N" in first
    assert "not seen in 2 clear looks" in second
    assert is_honest(report)
    assert where(session, "starter_1") == ("floor", "unknown_location")
    assert session.cycle.board.snapshot.state("gripper_1", GripperState).gap > 0.075


@pytest.mark.parametrize(("since", "seconds"), [("", 1.0), ("lifting", 8.0)])
def test_a_camera_that_is_silent_for_a_while_costs_nothing_but_time(
    open_session: Open, monkeypatch: pytest.MonkeyPatch, since: str, seconds: float
) -> None:
    session = open_session("kitting_carried", seed=2)
    fell = heights(session, "starter_1")
    silence(session, monkeypatch, announced(session, since) if since else lambda: True, seconds)

    report = session.run([STARTER])

    assert report.reached
    assert is_honest(report)
    assert not any(step.reason for step in report.steps)
    assert fastest_fall(session, fell) < FALLS


def test_a_camera_that_stays_silent_is_named_and_nothing_is_touched(
    open_session: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = open_session("kitting_carried", seed=2)
    silence(session, monkeypatch, lambda: True, 1e9)

    report = session.run(["Holding(gripper_1, starter_1)"])

    picks = [step for step in report.steps if step.skill == "pick"]
    assert is_honest(report)
    assert len(picks) == 1
    assert "camera 'camera_1' does not answer" in report.conditions[0].reason
    assert where(session, "starter_1") == ("pallet_a", "pallet_a")
    assert session.cycle.board.still


@pytest.mark.parametrize("after", [0.3, 0.95])
def test_a_part_in_the_hand_at_a_stop_is_known_to_be_there_and_is_carried_on(
    open_session: Open, when: When, after: float
) -> None:
    session = open_session("kitting_carried", seed=2)
    fell, lifts, since = heights(session, "starter_1"), announced(session, "lifting"), list[float]()

    def lifted() -> bool:
        now = session.cycle.board.snapshot.time
        if lifts() and not since:
            since.append(now)
        return bool(since) and now >= since[0] + after

    when(session, lifted, session.stop)
    stopped = session.run([STARTER])
    held = where(session, "starter_1")
    report = session.run([STARTER])

    assert stopped.stopped
    assert held == ("gripper_1", "gripper_1")
    assert report.reached
    assert "pick" not in [step.skill for step in report.steps]
    assert fastest_fall(session, fell) < FALLS


def test_joints_and_lines_end_at_their_limits_with_the_reason_and_the_robot_goes_on(open_session: Open) -> None:
    session = open_session("kitting_carried", seed=2)

    def jog(module: str, **arguments: Any) -> list[str]:
        """Jogs until it is refused; returns the messages."""
        said: list[str] = []
        while len(said) < 20:
            outcome = session.run_module(module, {"arm": "arm_1", **arguments}, "arm_1")
            said.append(outcome.message if isinstance(outcome, Success) else outcome.reason)
            if isinstance(outcome, Failure):
                break
        return said

    joint = jog("jog_joints", deltas=[0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.0])
    before = session.cycle.board.snapshot.state("arm_1", ArmState).positions
    again = jog("jog_joints", deltas=[0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.0])
    after = session.cycle.board.snapshot.state("arm_1", ArmState).positions
    home = session.run_module("home", {"robot": "robot_1"}, "arm_1")
    up = [step for length in (0.1, 0.02, 0.01) for step in jog("jog_tool", frame="base", translation=[0, 0, length])]
    back = jog("jog_tool", frame="base", translation=[-0.1, 0.0, 0.0])
    report = session.run(["RobotAtLocation(robot_1, pallet_a)"])

    assert len(joint) > 5
    assert "panda_joint6 at" in joint[-1]
    assert "outside its limits of -0.087 to 3.822 rad" in joint[-1]
    assert len(again) == 1
    assert after == pytest.approx(before, abs=0.002)
    assert isinstance(home, Success)
    assert "the arm reaches no further" in up[-1]
    assert "nearly stretched or folded" in back[-1]
    assert report.reached

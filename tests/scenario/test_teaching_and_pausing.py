"""What a person does beside the plan: pausing a motion, sending a robot home, showing it what nobody wrote down."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_primitives.postures import Home
from skiros_primitives.teaching import TeachDrivingPose, TeachGrasp
from skiros_py.catalogue import load_catalogue
from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.devices.gripper import GripperState
from skiros_py.geometry import Array, Pose
from skiros_py.planning.plan import NoPlan
from skiros_py.ports.motion import JointMove, LineMove, PoseMove
from skiros_py.simulation.truth import Truth
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.station.session import Options, Session

pytestmark = pytest.mark.physics

SCENES = Path(__file__).parents[2] / "scenes"
START = 'scene:base_1 sk:pose "0 0 0 0 0 0"'
BARS = """
@prefix sk: <https://w3id.org/skiros-py/core#> . @prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> . @prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix bars: <https://example.org/bars#> .
<https://example.org/bars> a owl:Ontology ; owl:imports <https://w3id.org/skiros-py/core> .
bars:Bar a owl:Class ; rdfs:subClassOf sk:Manipulatable ; rdfs:label "bar" ;
    rdfs:comment "Nobody says how to take it." ; sk:mass 0.2 ;
    sk:solid '[{"kind": "box", "size": [0.10, 0.04, 0.05], "at": [0, 0, 0.025]}]'^^rdf:JSON .
"""
BAR = """
@prefix bars: <https://example.org/bars#> .
<https://w3id.org/skiros-py/scenes/kitting_carried> owl:imports <https://example.org/bars> .
scene:bar_1 a bars:Bar ; rdfs:label "bar" ; sk:in scene:pallet_a ; sk:pose "4.93 1.6 0.45 0 0 0.3"^^sk:poseLiteral .
"""
ABOVE = Pose((0.0, 0.0, 0.12))


class Guide(ArmPrimitive):
    """Stands in for the hand of a person that leads the arm."""

    name: ClassVar[str] = "guide"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param("sk:Arm", "The arm.", kind=Kind.HARDWARE)
        joints: tuple[float, ...] | None = param(
            "number", "Where to.", kind=Kind.OPTIONAL, default=None, length=7, unit="rad"
        )
        tip: Pose | None = param("pose", "Where to.", kind=Kind.OPTIONAL, default=None)
        straight: bool = param("boolean", "On a line, up to the bar.", kind=Kind.OFFLINE, default=False)

    def execute(self) -> Execution[Outcome]:
        """Moves."""
        move: JointMove | LineMove | PoseMove = JointMove(self.params.joints or ())
        if self.params.tip is not None:
            move = PoseMove(self.params.tip)
            if self.params.straight:
                move = LineMove(self.params.tip, touching=frozenset({"bar_1", "pallet_a"}))
        refusal = yield from self.go([(move,)])
        return Success() if refusal is None else Failure(refusal.reason)


@pytest.fixture
def open_guided() -> Iterator[Callable[..., Session]]:
    """Opens a session in which a person may lead the arm."""
    catalogue = load_catalogue()
    more = {primitive.name: primitive for primitive in (Guide, Home, TeachDrivingPose, TeachGrasp)}
    guided = replace(catalogue, primitives={**catalogue.primitives, **more})
    with ExitStack() as stack:

        def open_(scene: Path | str, **options: Any) -> Session:
            return stack.enter_context(Session(str(scene), Options(**options), catalogue=guided))

        yield open_


def run(session: Session, module: str, *, agent: str = "arm_1", **arguments: Any) -> Outcome:
    """Runs one module to its end."""
    running = session.managers[agent].start(module, arguments)
    while not running.done:
        session.cycle.step()
    return running.result


def joints(session: Session) -> Array:
    return np.array(session.cycle.board.snapshot.state("arm_1", ArmState).positions)


def swing(session: Session, *, pause: int | None = None) -> list[Array]:
    """Leads the arm far away and notes its joints in each cycle; it may be paused in one, for three seconds."""
    home = session.spec.robots[0].of(ArmSpec)[0].home
    away = tuple(angle + by for angle, by in zip(home, (1.2, 0.3, 0.2, 0.4, 0.2, 0.3, 0.5), strict=True))
    running = session.managers["arm_1"].start("guide", {"joints": away})
    seen = []
    while not running.done:
        if len(seen) == pause:
            running.pause()
            session.cycle.step()
            seen += [joints(session) for _ in range(600) if session.cycle.step() is None]
            running.resume()
        session.cycle.step()
        seen.append(joints(session))
    assert running.result == Success()
    return seen


def test_a_paused_arm_brakes_along_its_path_stands_and_goes_on_where_it_stopped(open_guided):
    with open_guided("kitting", seed=1) as session:
        straight_through = np.array(swing(session))
    speeds = np.abs(np.diff(straight_through, axis=0)).max(axis=1) / 0.005
    middle = int(speeds.argmax())
    with open_guided("kitting", seed=1) as session:
        paused = np.array(swing(session, pause=middle))

    standing = paused[middle + 200 : middle + 600]
    assert speeds[middle] > 0.5
    assert np.abs(standing - standing[-1]).max() < 0.002
    assert np.abs(standing[-1] - straight_through[-1]).max() > 0.1
    assert paused[-1] == pytest.approx(straight_through[-1], abs=0.005)
    aside = [np.abs(straight_through - here).max(axis=1).min() for here in paused]
    assert max(aside) < math.radians(0.5)
    assert len(paused) - len(straight_through) == pytest.approx(600, abs=70)


def test_home_moves_the_arm_home_and_opens_empty_fingers(open_guided):
    session = open_guided("kitting", seed=1)
    swing(session)
    run(session, "gripper_control", gap=0.0)
    assert session.cycle.board.snapshot.state("gripper_1", GripperState).gap < 0.01

    outcome = run(session, "home")

    assert outcome == Success("home")
    assert np.abs(joints(session) - session.spec.robots[0].of(ArmSpec)[0].home).max() < 0.02
    assert session.cycle.board.snapshot.state("gripper_1", GripperState).gap > 0.075


def test_a_goal_at_a_kit_is_reached_once_its_docking_pose_is_taught(open_guided, tmp_path):
    scene = tmp_path / "untaught.ttl"
    text = (SCENES / "kitting.ttl").read_text(encoding="utf-8")
    text = text.replace('    sk:drivingPose "-0.73 0 -0.5 0 0 0"^^sk:poseLiteral ;\n', "")
    # The kit is at x = -1.55 m and turned round: 0.73 m before it is x = -0.82 m.
    scene.write_text(text.replace(START, 'scene:base_1 sk:pose "-0.82 0 0 0 0 3.141592653589793"'), encoding="utf-8")
    session = open_guided(scene, seed=4)
    before = session.plan("ObjectAtLocation(Starter, kit_1_a)").outcome

    outcome = run(session, "teach_driving_pose", agent="base_1", location="kit_1", type="kitting:Kit")
    report = session.run("ObjectAtLocation(Starter, kit_1_a)")

    assert isinstance(before, NoPlan)
    assert "needs that kit_1 has a driving pose" in before.reasons[0]
    assert isinstance(outcome, Success), outcome
    assert [(c.believed, c.true) for c in report.conditions] == [(True, True)]
    assert [step.arguments["Location"] for step in report.steps if step.skill == "drive"] == ["pallet_a", "kit_1"]


def test_a_part_with_a_taught_grasp_is_picked_and_placed_as_taught(open_guided, tmp_path, monkeypatch):
    (tmp_path / "bars.ttl").write_text(BARS, encoding="utf-8")
    monkeypatch.setenv("SKIROS_ONTOLOGIES", str(tmp_path / "bars.ttl"))
    scene = tmp_path / "bars_carried.ttl"
    text = (SCENES / "kitting_carried.ttl").read_text(encoding="utf-8") + BAR
    scene.write_text(text.replace(START, 'scene:base_1 sk:pose "4.22 1.6 0 0 0 0"'), encoding="utf-8")
    session = open_guided(scene, seed=4)
    truth = Truth(session.simulation)
    with session.world.transaction("camera", "stands in for a look") as tx:
        tx.set("bar_1", "sk:pose", truth.pose("bar_1"))
    untaught = run(session, "grasp", part="bar_1")
    off_middle = truth.pose("bar_1") @ Pose.of(0.01, 0.0, 0.03, roll=math.pi)

    show = [
        run(session, "guide", tip=ABOVE @ off_middle),
        run(session, "guide", tip=off_middle, straight=True),
        run(session, "gripper_control", gap=0.0),
        run(session, "teach_grasp", part="bar_1"),
        run(session, "gripper_control"),
        run(session, "guide", tip=ABOVE @ off_middle, straight=True),
    ]
    taken = run(session, "grasp", part="bar_1")
    homed = run(session, "home")

    assert isinstance(untaught, Failure)
    assert "teach a grasp" in untaught.reason
    assert all(isinstance(outcome, Success) for outcome in show), show
    assert isinstance(taken, Success), taken
    assert homed == Success("home; gripper_1 stays closed")
    assert truth.placements()["bar_1"] == "gripper_1"
    learned = session.world.value("bar_1", "sk:graspPose")
    assert isinstance(learned, Pose)
    assert learned.position == pytest.approx((0.01, 0.0, 0.03), abs=0.003)

    placing = Pose.of(0.01, -0.03, 0.006, yaw=0.2)
    with session.world.transaction("person", "shows where") as tx:
        about = {"sk:appliesTo": "kitting:Compartment", "sk:placingPose": placing}
        tx.add("sk:TaughtPlacingPose", properties=about, learned=True)
    put = run(session, "put_down", part="bar_1", compartment="kit_1_a")
    session.cycle.board.exchange()

    assert isinstance(put, Success), put
    lies = truth.pose("kit_1_a").inverse() @ truth.pose("bar_1")
    assert lies.position == pytest.approx((0.01, -0.03, 0.0), abs=0.012)
    assert abs(lies.yaw - 0.2) < 0.15

"""A rehearsal says what would fail in physics, and finds another plan; nothing of it is left behind."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from skiros_py.config import find_scene
from skiros_py.errors import DeviceError
from skiros_py.station.rehearsals.order import RehearsalOrder, order_from
from skiros_py.station.rehearsals.rehearsal import RunningRehearsal, rehearsed
from skiros_py.station.session import Options, Session
from skiros_py.station.worlds import open_world
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.rehearsal import StepState
from skiros_py.tasks.trace import TraceEntry, TraceEventKind

pytestmark = pytest.mark.physics

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "rehearsal.md"


@pytest.fixture
def trapped(tmp_path: Path) -> Path:
    """The scene of the page about rehearsals: a block from 14 cm above the kit, over its compartment B."""
    file = tmp_path / "trapped.ttl"
    beam = PAGE.read_text(encoding="utf-8").partition("```turtle\n")[2].partition("```")[0]
    file.write_text(find_scene("kitting_cell").read_text() + beam)
    return file


def order(scene: str, *goal: str, rounds: int = 3) -> RehearsalOrder:
    return order_from(open_world(scene), Options(seed=3), goal, rounds=rounds)


def test_a_plan_that_works_is_said_to_work_with_its_time() -> None:
    result = rehearsed(order("kitting_cell", "ObjectAtLocation(Alternator, kit_1_b)"))

    assert result.passed
    assert not result.first_fails
    assert len(result.rounds) == 1
    (play,) = result.rounds[0].plays
    assert [(step.skill, step.state) for step in play.steps] == [("pick", StepState.DONE), ("place", StepState.DONE)]
    assert result.seconds == pytest.approx(play.seconds)


def test_what_geometry_forbids_is_said_with_its_reason_and_avoided_by_the_next_plan(
    trapped: Path, open_session: Callable[..., Session]
) -> None:
    only = rehearsed(order(str(trapped), "ObjectAtLocation(Alternator, kit_1_b)"))

    assert not only.passed
    failed = only.rounds[0].plays[0].steps[-1]
    assert (failed.skill, failed.state) == ("place", StepState.FAILED)
    assert failed.cause in ("collision", "not found", "reach")
    assert [one.target for one in only.ruled_out] == ["kit_1_b"]
    assert only.rounds[-1].no_plan
    assert "kit_1_b" in only.reason

    session = open_session(str(trapped), seed=3)
    report = session.run(["InKit(Alternator, kit_1)"], ruled_out=only.ruled_out)

    assert report.reached
    assert not [step for step in report.steps if step.arguments.get("Compartment") == "kit_1_b"]


def test_a_task_is_rehearsed_without_a_change_to_its_own_world(open_session: Callable[..., Session]) -> None:
    session = open_session("kitting_cell", seed=3)
    seen: dict[TraceEventKind, tuple[int, bytes]] = {}

    def look(entry: TraceEntry) -> None:
        seen[entry.what] = session.world.version, session.simulation.state_bytes()

    def follow(task: TaskHandle) -> None:
        task.trace.subscribe(look)

    session.tasks.on_begin(follow)
    report = session.run("ObjectAtLocation(Alternator, kit_1_b)", Policy(rehearse=True))

    assert report.reached
    assert seen[TraceEventKind.REHEARSED] == seen[TraceEventKind.REHEARSES]
    assert seen[TraceEventKind.FINISHED] != seen[TraceEventKind.REHEARSED]


def test_a_cancelled_rehearsal_leaves_no_process_behind() -> None:
    running = RunningRehearsal(order("kitting_cell"))
    mark = vars(running)["_mark"]
    deadline = time.monotonic() + 60.0
    while not marked(mark) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert marked(mark), "it has started programs"

    running.close()

    with pytest.raises(DeviceError, match="stopped"):
        running.result()
    assert marked(mark) == []
    assert not Path(f"/proc/{running.pid}").exists()


def marked(mark: str) -> list[int]:
    """Returns the processes that were started in a rehearsal."""
    found = []
    for file in Path("/proc").glob("[0-9]*/environ"):
        with suppress(OSError):
            if f"={mark}".encode() in file.read_bytes():
                found.append(int(file.parent.name))
    return found

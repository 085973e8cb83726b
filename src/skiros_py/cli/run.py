"""``skiros run``: plan, do it with a live display, and end with a table."""

from __future__ import annotations

import dataclasses
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.asking import answering, ask_option
from skiros_py.cli.ending import end_unless
from skiros_py.cli.exit_status import NO_PLAN, NOT_REACHED, REACHED, STOPPED
from skiros_py.cli.options import GUI, SKILLS, cell_options, data_option, planner_options
from skiros_py.cli.output import answer
from skiros_py.cli.stops import STOPS, heard_at_once, ignore_stops, raise_interrupt
from skiros_py.errors import UsageError

if TYPE_CHECKING:
    from skiros_py.station.session import Session
    from skiros_py.tasks.report import GoalReport


@click.command("run", epilog="Example: skiros run kitting --seed 3 --goal 'InKit(Starter, kit_1)' --record run.png")
@click.argument("scene")
@click.option(
    "--goal",
    multiple=True,
    metavar="TEXT",
    help="Goal instead of the scene's, as text such as 'InKit(Starter, kit_1) and not (A(x) or B(x))', 'for all k: Kit "
    "(InKit(Starter, k))', 'exists k: Kit (…)', or as PDDL, '(in_kit starter kit_1)'; may be repeated.",
)
@click.option("--robot", metavar="NAME", help="Robot to use; needed where the scene has several.")
@cell_options("max")
@GUI
@click.option(
    "--record",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Contact sheet of the key moments (.png) or animation (.gif, .webp).",
)
@data_option(required=False)
@SKILLS
@planner_options
@ask_option
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout, all else on stderr.")
def command(scene: str, record: Path | None, ask: bool | None, as_json: bool, **options: Any) -> int:
    """Plans and does the goal of SCENE (a name, or a path to a .ttl file)."""
    from skiros_py.recording.pictures import check_pictures
    from skiros_py.system import check_display

    if record is not None:
        check_pictures(record, fake=options["fake"])
    if options["gui"]:
        check_display(os.environ.get("DISPLAY"))
    from skiros_py.station.session import Options, Session

    with Session(scene, Options(**options)) as session:
        status = _run(session, record, ask=ask, as_json=as_json)
        ignore_stops()  # closing is quick and must not be torn apart
        return status


def _run(session: Session, record: Path | None, *, ask: bool | None, as_json: bool) -> int:
    from skiros_py.cli.display import RunDisplay
    from skiros_py.recording.pictures import RunPictures
    from skiros_py.station.recordings.runs import run_recorder
    from skiros_py.station.recordings.sources import camera_of

    camera = camera_of(session)
    if record is not None and camera is None:
        raise UsageError("--record needs the simulation: nothing else can be seen from outside")
    pictures = RunPictures(session.runtime, camera, record) if record is not None and camera is not None else None
    data = session.options.data
    kept = run_recorder(session, data) if data is not None else None
    with (
        kept or nullcontext(),
        RunDisplay(session, to_stderr=as_json) as display,
        stopping(session, as_json=as_json),
        answering(session.questions, ask=ask),
    ):
        report = session.run()
        if kept is not None:
            kept.conclude(report)
    display.show_report(report)
    if kept is not None:
        fault = kept.writer.fault
        display.say(f"warning not recorded: {fault}" if fault else f"recording  {kept.writer.path}")
    if pictures is not None:
        try:
            pictures.write()
            display.say(f"recorded to {record}")
        except UsageError as error:  # the run is what counts: its report must not be lost for a picture
            display.say(f"warning {error}")
    if as_json:
        answer(_as_json(session, report))
    return _status(report)


@contextmanager
def stopping(session: Session, *, as_json: bool) -> Iterator[None]:
    """Ctrl-C and a polite kill halt the robot in the next cycle; a second one does not wait for standstill.

    Where code of others holds the control thread, and does not come back although the watchdog has interrupted it or
    the user wants a stop, the command ends without it.
    """
    pulse, left = session.cycle.pulse, threading.Event()

    def stop(number: int, _frame: object) -> None:
        signal.signal(number, raise_interrupt)
        session.stop()

    def end_if_stuck(name: str, status: int) -> None:
        beat = pulse.beat
        end_unless(
            lambda: left.is_set() or pulse.task is None or pulse.waits > 0 or pulse.beat != beat,
            f"{name} does not come back: the command ends without it",
            status,
            as_json=as_json,
        )

    session.runtime.watchdog.on_lost(lambda task: end_if_stuck(task.name, NOT_REACHED))
    before = {number: signal.signal(number, stop) for number in STOPS}
    try:
        with heard_at_once(lambda: end_if_stuck(getattr(pulse.task, "name", "the control thread"), STOPPED)):
            yield
    finally:
        left.set()
        for number, handler in before.items():
            signal.signal(number, handler)


def _status(report: GoalReport) -> int:
    if report.stopped:
        return STOPPED
    if report.no_plan:
        return NO_PLAN
    return REACHED if report.reached else NOT_REACHED


def _as_json(session: Session, report: GoalReport) -> dict[str, Any]:
    return {
        "scene": session.scene,
        "seed": session.options.seed,
        "status": _status(report),
        "reached": report.reached,
        **dataclasses.asdict(report),
    }

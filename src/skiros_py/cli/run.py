"""``skiros run``: plan, do it with a live display, ask on the terminal, and end with a table."""

from __future__ import annotations

import dataclasses
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import click
from rich.live import Live
from rich.text import Text

from skiros_py.cli.ending import STOPS, end_unless, heard_at_once, ignore_stops, raise_interrupt
from skiros_py.cli.options import ASK, GUI, PLANNER, SKILLS, cell_options, data_option
from skiros_py.cli.output import NO_PLAN, NOT_REACHED, REACHED, STOPPED, answer, console, table_lines
from skiros_py.errors import UsageError, escaped
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.planning.plan import NoPlan
from skiros_py.planning.service import Planned
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import TraceEntry, TraceEventKind, short_step

if TYPE_CHECKING:
    from skiros_py.skills.context import Question, Questions
    from skiros_py.station.session import Session


@contextmanager
def answering(questions: Questions, *, ask: bool | None) -> Iterator[None]:
    """Lets a person answer the questions of a run.

    Args:
        questions: The run's questions.
        ask: False to answer none; None for where input is a terminal.
    """
    if not (sys.stdin.isatty() if ask is None else ask):
        yield
        return
    came = threading.Event()

    def show(question: Question) -> None:
        click.echo(f"? {question.asker} asks: {question.text} [{'/'.join(question.options)}]", err=True)
        came.set()

    unsubscribe = questions.subscribe(show)
    threading.Thread(target=_read, args=(questions, came), name="skiros-answers", daemon=True).start()
    try:
        yield
    finally:
        unsubscribe()


def _read(questions: Questions, came: threading.Event) -> None:
    """Passes each line of input as the answer to the oldest question."""
    while True:
        came.wait()
        line = sys.stdin.readline()
        if not line:
            return  # end of input: who asks more waits for its own timeout, or for a stop
        open_ = questions.open
        if not open_:
            continue
        try:
            questions.answer(open_[0].id, line.strip(), by="terminal")
        except UsageError as error:
            click.echo(f"? {error}", err=True)


class RunDisplay:
    """Follows one session: a line for each finished step, and a live line on a terminal."""

    def __init__(self, session: Session, *, to_stderr: bool) -> None:
        self._session = session
        self._console = console(stderr=to_stderr, soft_wrap=True)
        self._live = Live(console=self._console, refresh_per_second=8, transient=True)
        self._skill = self._primitive = ""
        self._plans = 0
        session.monitor.subscribe(self._on_event)
        session.on_plan(self._on_plan)
        session.tasks.on_begin(self._on_begin)

    def __enter__(self) -> Self:
        session = self._session
        about = [*(robot.id for robot in session.spec.robots), f"seed {session.options.seed}"]
        self.say(f"scene   {session.scene}: {', '.join(about)}")
        for agent, manager in sorted(session.managers.items()):
            for name, skill in sorted(manager.descriptions.items()):
                self.say(f"skill   {name:8} by {agent}: {skill.help}")
        for condition in session.goal:
            self.say(f"goal    {condition}")
        if self._console.is_terminal:
            self._live.start()
            self._session.cycle.observe(self._refresh)
        return self

    def __exit__(self, *_: object) -> None:
        self._live.stop()

    def say(self, text: str) -> None:
        """Prints one line."""
        self._console.print(text, markup=False)

    def _on_plan(self, planned: Planned) -> None:
        self._plans += 1
        for note in planned.notes:
            self.say(f"warning {note}")
        if isinstance(planned.outcome, NoPlan):
            for reason in planned.outcome.reasons:
                self.say(f"no plan {reason}")
            for repair in planned.outcome.repairs:
                self.say(f"        to make it work: {repair.text}")
            if elsewhere := self._session.catalogue.elsewhere:
                self.say(f"no plan {self._session.catalogue.why_elsewhere(*sorted(elsewhere))}")
            return
        self.say(f"plan    {'made' if self._plans == 1 else 'made again'} in {planned.wall * 1e3:.0f} ms")
        skills = {c.skill.name: c.skill for c in self._session.tasks.capabilities}
        for number, step in enumerate(planned.outcome.steps, start=1):
            self.say(f"  {number:2}. {short_step(step, skills[step.skill])}")

    def _on_begin(self, task: TaskHandle) -> None:
        task.trace.subscribe(self._on_trace)

    def _on_trace(self, entry: TraceEntry) -> None:
        if entry.what in (TraceEventKind.REHEARSES, TraceEventKind.REHEARSED):
            self.say(f"rehearsal  {entry.text}")

    def _on_event(self, event: ModuleEvent) -> None:
        if event.status is Status.EVENT:
            return
        if event.kind == "primitive":
            self._primitive = f"{event.module}: {event.text}" if event.status is not Status.STARTED else event.module
            if event.status is Status.ERROR:
                self.say(f"{event.time:8.1f} s    {event.module} failed: {event.text}")
            return
        self._primitive = event.text if event.status is Status.RUNNING else ""
        if event.status in (Status.STARTED, Status.RUNNING):
            self._skill = f"{event.module} {event.target}"
        else:
            mark = {Status.TERMINATED: "done", Status.ERROR: "failed", Status.PREEMPTED: "stopped"}[event.status]
            what = f"{event.module} {event.target}"
            self.say(f"{event.time:8.1f} s  {what} {mark}{': ' + event.text if event.text else ''}")

    def _refresh(self) -> None:
        snapshot = self._session.cycle.board.snapshot
        if snapshot.cycle % 20 == 0:
            line = f"{snapshot.time:8.1f} s  {self._skill}  {self._primitive}"
            self._live.update(Text(line[: self._console.width], style="cyan"))

    def show_report(self, report: GoalReport) -> None:
        """Prints the table: each goal condition, belief, truth, tries; then times."""
        if not report.steps and not report.no_plan and report.reached:
            self.say("the goal already holds: nothing to do")
        columns = ("goal condition", "believed", "truth", "tries", "simulated", "wall", "why not")
        rows = (
            (
                c.condition,
                _YES[c.believed],
                _YES[c.true],
                str(c.tries),
                _seconds(c.simulated),
                _seconds(c.wall),
                c.reason,
            )
            for c in report.conditions
        )
        for line in table_lines(columns, rows, right=("tries", "simulated", "wall")):
            self.say(line)
        verdict = "stopped" if report.stopped else "goal reached" if report.reached else "goal not reached"
        self.say(f"{verdict}: {report.simulated:.1f} s simulated, {report.wall:.1f} s wall, digest {report.digest}")


_YES = {True: "yes", False: "no", None: "-"}


def _seconds(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f} s"


@click.command("run", epilog="Example: skiros run kitting --seed 3 --goal 'InKit(Starter, kit_1)' --record run.png")
@click.argument("scene")
@click.option(
    "--goal",
    multiple=True,
    metavar="TEXT",
    help="Goal instead of the scene's, as text such as 'InKit(Starter, kit_1) and not (A(x) or B(x))', 'for all k: Kit "
    "(InKit(Starter, k))', 'exists k: Kit (…)', or as PDDL, '(in_kit starter kit_1)'; may be repeated.",
)
@click.option("--robot", metavar="NAME", help="Robot to use.  [default: all robots of the scene]")
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
@PLANNER
@ASK
@click.option("--rehearse", is_flag=True, help="Try the plan in a second physics world first; stop if it fails there.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout, all else on stderr.")
def command(scene: str, record: Path | None, ask: bool | None, rehearse: bool, as_json: bool, **options: Any) -> int:
    """Plans and executes the goal of SCENE (a name, or a path to a .ttl file)."""
    from skiros_py.recording.pictures import check_pictures
    from skiros_py.system import check_display

    if record is not None:
        if options["fake"]:
            raise UsageError("--record needs physics: a fake run has nothing to see")
        check_pictures(record, "--record")
    if options["gui"]:
        check_display(os.environ.get("DISPLAY"))
    from skiros_py.station.session import Options, Session
    from skiros_py.station.worlds import why_not_loaded

    with Session(scene, Options(**options)) as session:
        if session.options.data is not None and (why := why_not_loaded(session.options.data, session.world, scene)):
            click.echo(f"world   {escaped(why)}; choose another --data to begin it", err=True)
        status = _run(session, record, ask=ask, rehearse=rehearse, as_json=as_json)
        ignore_stops()  # closing is quick and must not be torn apart
        return status


def _run(session: Session, record: Path | None, *, ask: bool | None, rehearse: bool, as_json: bool) -> int:
    from skiros_py.recording.pictures import RunPictures
    from skiros_py.station.recordings.runs import run_recorder
    from skiros_py.station.recordings.topics import camera_of

    camera, pictures = camera_of(session), None
    if record is not None:
        if camera is None:
            raise UsageError("--record needs the simulation: nothing else can be seen from outside")
        pictures = RunPictures(session.runtime, camera, record)
    data = session.options.data
    kept = run_recorder(session, data) if data is not None else None
    with (
        kept or nullcontext(),
        RunDisplay(session, to_stderr=as_json) as display,
        stopping(session, as_json=as_json),
        answering(session.questions, ask=ask),
    ):
        report = session.run(policy=Policy(rehearse=rehearse))
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
    status = NO_PLAN if report.no_plan else REACHED if report.reached else NOT_REACHED
    status = STOPPED if report.stopped else status
    if as_json:
        head = {"scene": session.scene, "seed": session.options.seed, "status": status, "reached": report.reached}
        answer({**head, **dataclasses.asdict(report)})
    return status


@contextmanager
def stopping(session: Session, *, as_json: bool) -> Iterator[None]:
    """Ctrl-C and SIGTERM halt the robot in the next cycle; a second one does not wait for standstill.

    Where code of others holds the control thread, and does not come back although the watchdog has interrupted it or
    the user wants a stop, the command ends without it.
    """
    activity, left = session.cycle.activity, threading.Event()

    def stop(number: int, _frame: object) -> None:
        signal.signal(number, raise_interrupt)
        session.stop()

    def end_if_stuck(name: str, status: int) -> None:
        tick = activity.tick
        end_unless(
            lambda: left.is_set() or activity.task is None or activity.waits > 0 or activity.tick != tick,
            f"{name} does not come back: the command ends without it",
            status,
            as_json=as_json,
        )

    session.runtime.watchdog.on_lost(lambda task: end_if_stuck(task.name, NOT_REACHED))
    before = {number: signal.signal(number, stop) for number in STOPS}
    try:
        with heard_at_once(lambda: end_if_stuck(getattr(activity.task, "name", "the control thread"), STOPPED)):
            yield
    finally:
        left.set()
        for number, handler in before.items():
            signal.signal(number, handler)

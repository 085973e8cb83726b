"""``skiros rehearse``: whether the plan for a goal would work, tried in a second physics world made from beliefs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.options import CONFIG, IMPERFECTIONS, IMPORTS, PLANNER, SEED, SIMULATION, SKILLS
from skiros_py.cli.output import NO_PLAN, NOT_REACHED, REACHED, progress
from skiros_py.errors import UsageError
from skiros_py.tasks.rehearsal import Play, Rehearsal, RehearsedStep, Round, StepState


@reports("rehearse kitting 'InKit(Starter, kit_1)'")
@click.argument("scene")
@click.argument("goal", nargs=-1)
@click.option("--robot", metavar="NAME", help="Robot to use.  [default: all robots of the scene]")
@SEED
@SIMULATION
@IMPERFECTIONS
@CONFIG
@IMPORTS
@SKILLS
@PLANNER
@click.option(
    "--draws",
    type=click.IntRange(1, 100),
    default=1,
    show_default=True,
    help="Worlds in which each plan is tried; what no belief says is drawn for each.",
)
@click.option("--rounds", type=click.IntRange(1, 20), default=5, show_default=True, help="Most plans that are tried.")
@click.option(
    "--pictures",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Write a picture of each failure into DIR.",
)
def command(scene: str, goal: tuple[str, ...], draws: int, rounds: int, pictures: Path | None, **options: Any) -> Found:
    """Plays the plan for the goal of SCENE in a second physics world, and says which steps would fail.

    That world is made from what is believed: where nothing is known, such as where in its place a part lies, it is
    drawn from the seed. What geometry forbids is not planned again: the next plan avoids it, and is tried as well.
    Exit status: 0 if a plan works, 1 if it will fail, 3 if there is no plan.
    """
    from skiros_py.station.rehearsals.order import order_from
    from skiros_py.station.rehearsals.rehearsal import rehearsed
    from skiros_py.station.session import Options
    from skiros_py.station.worlds import open_world
    from skiros_py.system import require_extra

    require_extra("physics", "a rehearsal")
    if pictures is not None:
        try:
            pictures.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"--pictures {pictures}: {error.strerror}") from error
    folder = None if pictures is None else pictures.resolve()
    order = order_from(open_world(scene), Options(**options), goal, draws=draws, rounds=rounds, pictures=folder)
    with progress("opens a second world") as say:
        result = rehearsed(order, lambda event: say(event.text) if isinstance(event, RehearsedStep) else None)
    return {"scene": scene, "seed": order.options.seed, **result.as_json()}, lines_of(result), status_of(result)


def status_of(result: Rehearsal) -> int:
    """Returns the exit status: 3 only where no plan was found in the first place."""
    if result.passed:
        return REACHED
    return NO_PLAN if len(result.rounds) == 1 and result.rounds[0].no_plan else NOT_REACHED


def lines_of(result: Rehearsal) -> Iterator[str]:
    """Yields the result for people: each plan with its steps, what was ruled out, and the verdict."""
    for assumption in result.assumptions:
        yield f"assumed {assumption}"
    for number, round_ in enumerate(result.rounds, start=1):
        yield from _round_lines(number, round_)
    if result.passed and result.seconds is not None:
        how = "works" if len(result.rounds) == 1 else f"plan {len(result.rounds)} works"
        yield f"{how}: expected to take {result.seconds:.1f} s (rehearsed in {result.wall:.1f} s)"
    else:
        yield f"will fail: {result.reason}"


def _round_lines(number: int, round_: Round) -> Iterator[str]:
    yield from (f"no plan {reason}" for reason in round_.no_plan)
    for play in round_.plays:
        draw = f", draw {play.draw + 1}" if len(round_.plays) > 1 else ""
        yield f"plan {number}{draw}: {'reached' if play.reached else 'fails'} after {play.seconds:.1f} s"
        yield from _step_lines(play)
        yield from (f"ruled out {one.reason}" for one in play.ruled_out)


_MARKS = {StepState.DONE: "ok", StepState.FAILED: "fails", StepState.NOT_TRIED: "-"}


def _step_lines(play: Play) -> Iterator[str]:
    for number, step in enumerate(play.steps, start=1):
        tries = f" ({step.tries} tries)" if step.tries > 1 else ""
        line = f"  {number:2}. {_MARKS[step.state]:5} {step.text}{tries}"
        yield f"{line}: {step.reason}" if step.reason else line

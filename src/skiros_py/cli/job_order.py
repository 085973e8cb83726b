"""``skiros job submit`` and ``skiros job preview``: goals for a server."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from typing import TYPE_CHECKING, Any

import click
from pydantic import ValidationError

from skiros_py.api.jobs import JobOrder, order_from
from skiros_py.api.previews import Preview, PreviewState
from skiros_py.api.wire import fault_field, fault_words
from skiros_py.cli.commands import Found, served
from skiros_py.cli.job_text import follow_job, state_line
from skiros_py.cli.options import key_values
from skiros_py.cli.output import NO_PLAN, NOT_REACHED, REACHED
from skiros_py.errors import UsageError

if TYPE_CHECKING:
    from skiros_py.client import Client

_LOOK = 10.0
"""Maximum time that one request waits for a plan [s]."""


def _time(text: str) -> datetime:
    """Parses a time; without a zone, in the zone of this machine."""
    try:
        return datetime.fromisoformat(text).astimezone()
    except (ValueError, OverflowError):
        form = "2026-11-21T14:30 or 2026-11-21T14:30:00+01:00"
        raise click.BadParameter(f"'{text}' is no time such as {form}") from None


@served(
    "job submit",
    name="submit",
    epilog="""\b
Examples:
  skiros job submit 'InKit(Starter, kit_1)' --data cell --watch
  skiros job submit --template 'fill kit' --param kit=kit_1 --material 2*Starter --url http://cell-3:8000
""",
)
@click.argument("goals", nargs=-1, metavar="[GOAL]...")
@click.option("--id", metavar="ID", help="Id of the job; repeating the same order returns the same job.")
@click.option("--description", default="", metavar="TEXT", help="For people.")
@click.option("--priority", type=click.IntRange(-(2**15), 2**15 - 1), default=0, help="Higher values come first.")
@click.option("--not-before", type=_time, metavar="TIME", help="Earliest start.")
@click.option("--deadline", type=_time, metavar="TIME", help="When it should be done.")
@click.option("--expires", is_flag=True, help="It must not be started after its deadline.")
@click.option("--hold", is_flag=True, help="Hold it until 'skiros job start'.")
@click.option("--template", default="", metavar="NAME", help="Goal template of the server, instead of goals.")
@click.option("--param", "params", multiple=True, metavar="NAME=VALUE", help="A template argument; may be repeated.")
@click.option(
    "--material",
    "materials",
    multiple=True,
    metavar="[N*]CLASS[=ID][@PLACE]",
    help="Required material; repeatable.",
)
@click.option("--watch", is_flag=True, help="Follow it until it is over, as 'skiros job watch' does.")
def submit(client: Client, hold: bool, watch: bool, **order: Any) -> Found:
    """Orders a job: all GOALs must hold together, such as 'InKit(Starter, kit_1)'.

    It is stored when this returns. Exit status: 0 accepted; with --watch that of 'skiros job watch'.
    """
    job = client.jobs.order(_order(**order), start=not hold)
    if watch:
        return follow_job(client, job.id)
    return job, [state_line(job)]


@served("job preview 'InKit(Starter, kit_1)' --data cell", name="preview")
@click.argument("goals", nargs=-1, required=True, metavar="GOAL...")
def preview(client: Client, goals: tuple[str, ...]) -> Found:
    """Plans for GOALs from the current beliefs and shows the plan, or why there is none; nothing moves.

    Exit status: 0 there is a plan or nothing to be done, 1 planning failed, 3 there is no plan.
    """
    found = client.previews.ask(_order(goals))
    while found.state is PreviewState.PLANNING:
        found = client.previews.get(found.id, wait=_LOOK)
    status = {PreviewState.PLANNED: REACHED, PreviewState.NO_PLAN: NO_PLAN}.get(found.state, NOT_REACHED)
    return found, _preview_lines(found), status


def _preview_lines(found: Preview) -> Iterator[str]:
    if found.state is PreviewState.PLANNED and not found.steps:
        yield "the goal already holds: nothing to do"
    for number, step in enumerate(found.steps, start=1):
        yield f"{number:3}. {step.text}"
    yield from (f"{found.state}: {reason}" for reason in found.reasons)
    yield from (f"  to make it work: {repair.text}" for repair in found.repairs)


def _order(
    goals: tuple[str, ...],
    template: str = "",
    params: tuple[str, ...] = (),
    materials: tuple[str, ...] = (),
    **fields: Any,
) -> JobOrder:
    if bool(goals) == bool(template):
        raise click.UsageError("say what is wanted: either GOALs or --template NAME")
    try:
        parameters = key_values("--param", params, "kit=kit_1")
        return order_from(goals, template=template, parameters=parameters, materials=materials, **fields)
    except ValidationError as error:
        first = error.errors()[0]
        raise UsageError(f"that is no order: {fault_field(first)}: {fault_words(first)}") from None

"""``skiros plugins``: what is installed, from where, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.output import NOT_REACHED, REACHED, answer, escaped
from skiros_py.errors import UnknownName

if TYPE_CHECKING:
    from skiros_py.catalogue import Surveyed
    from skiros_py.plugins.plugin import PluginFault

_FILE_WIDTH = 200
"""Width of the table if it is not shown on a terminal."""


@click.command("plugins", epilog="Examples: skiros plugins --group skills; skiros plugins drive")
@click.argument("name", required=False)
@click.option("--group", metavar="GROUP", help="Only this group, such as skills or primitives.")
@click.option("--tracebacks", is_flag=True, help="Show the tracebacks of plug-ins that do not load.")
@click.option("--strict", is_flag=True, help="Exit with 1 if one is broken.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(name: str | None, group: str | None, tracebacks: bool, strict: bool, as_json: bool) -> int:
    """Loads every plug-in and lists it: group, name, distribution, object, and whether it works.

    With NAME, shows what is called so in full. What is hidden behind a name that stands twice is listed, too.
    """
    from skiros_py.catalogue import survey

    wanted = _group(group)
    everything, strays = survey()
    listed = [one for one in everything if wanted in (None, one.entry.group) and name in (None, one.entry.name)]
    if name is not None and not listed:
        raise UnknownName("plug-in", name, {one.entry.name for one in everything if wanted in (None, one.entry.group)})
    others = [fault for fault in strays if name is None and wanted is None]
    if as_json:
        answer(_as_json(listed, others))
    elif name is None:
        _print(listed, others, tracebacks=tracebacks)
    else:
        for one in listed:
            _print_in_full(one)
    broken = any(not one.works for one in listed) or bool(others)
    return NOT_REACHED if strict and broken else REACHED


def _group(given: str | None) -> str | None:
    """Returns the group in full ("skiros.skills"); its first part may be left out."""
    from skiros_py.plugins.installation import GROUPS

    if given is None:
        return None
    short = given.removeprefix("skiros.")
    if f"skiros.{short}" not in GROUPS:
        raise UnknownName("group", short, [group.removeprefix("skiros.") for group in GROUPS])
    return f"skiros.{short}"


def _print(listed: Sequence[Surveyed], others: Sequence[PluginFault], *, tracebacks: bool) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for column in ("group", "name", "distribution", "object", "state"):
        table.add_column(column, no_wrap=column != "state")
    for one in listed:
        entry, state = one.entry, "works" if one.works else "; ".join(fault.reason for fault in one.faults)
        short = entry.group.removeprefix("skiros.")
        row = short, entry.name, str(entry.distribution), entry.value, state
        table.add_row(*(Text(escaped(cell), style="" if one.works else "red") for cell in row))
    console = Console(highlight=False, soft_wrap=True)
    if not console.is_terminal:  # a file or a pipe has no width to fit
        console.width = _FILE_WIDTH
    console.print(table)
    for fault in others:
        click.echo(escaped(f"{fault.distribution}: {fault.reason} ({fault.origin})"))
    for fault in (fault for one in listed for fault in one.faults) if tracebacks else ():
        click.echo(f"\n{escaped(str(fault))}\n{_lines(fault.traceback)}")


def _print_in_full(one: Surveyed) -> None:
    from skiros_py.catalogue import KINDS
    from skiros_py.plugins.plugin import origin_of

    entry = one.entry
    kind = KINDS.get(entry.group)
    said = {
        "plug-in": f"{entry.name} ({entry.group})",
        "must be": kind.names if kind else "unknown: there is no such group",
        "object": entry.value,
        "from": str(entry.distribution),
        "requires": ", ".join(entry.distribution.requires) or "nothing",
        "metadata": entry.distribution.folder,
        "file": origin_of(entry.module) or "not found",
        "state": "works" if one.works else "broken",
    }
    for title, text in said.items():
        click.echo(escaped(f"{title:9} {text}"))
    for fault in one.faults:
        click.echo(escaped(f"{'reason':9} {fault.reason}"))
        click.echo(_lines(fault.traceback), nl=bool(fault.traceback))


def _lines(text: str) -> str:
    return "\n".join(escaped(line) for line in text.splitlines())


def _as_json(listed: Sequence[Surveyed], others: Sequence[PluginFault]) -> dict[str, Any]:
    plugins = [
        {
            "group": one.entry.group,
            "name": one.entry.name,
            "distribution": one.entry.distribution.name,
            "version": one.entry.distribution.version,
            "object": one.entry.value,
            "works": one.works,
            "faults": [_fault(fault) for fault in one.faults],
        }
        for one in listed
    ]
    return {"plugins": plugins, "others": [{"from": fault.distribution, **_fault(fault)} for fault in others]}


def _fault(fault: PluginFault) -> dict[str, str]:
    return {"reason": fault.reason, "origin": fault.origin, "traceback": fault.traceback}

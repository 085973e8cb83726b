"""``skiros plugins``: what is installed, from where, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import click

from skiros_py.api.modules import PluginFaultInfo
from skiros_py.catalogue import KINDS, Surveyed, survey
from skiros_py.cli.commands import Found, reports
from skiros_py.cli.output import NOT_REACHED, REACHED, table_lines
from skiros_py.errors import UnknownName
from skiros_py.plugins.installation import GROUPS
from skiros_py.plugins.plugin import PluginFault, origin_of
from skiros_py.station.modules import views


@reports("plugins --group skills", epilog="Examples: skiros plugins --group skills; skiros plugins drive")
@click.argument("name", required=False)
@click.option("--group", metavar="GROUP", help="Only this group, such as skills or primitives.")
@click.option("--tracebacks", is_flag=True, help="Show the tracebacks of plug-ins that do not load.")
def command(name: str | None, group: str | None, tracebacks: bool) -> Found:
    """Loads every plug-in and lists it: group, name, distribution, object, and whether it works.

    With NAME, shows what is called so in full. A name that several distributions use is qualified ("lab.pick"), except
    for the built-in plug-in. Exit status 1 if one of those listed is broken.
    """
    wanted = _group(group)
    everything, strays = survey()
    listed = [
        one
        for one in everything
        if wanted in (None, one.entry.group) and name in (None, one.entry.name, one.entry.own_name)
    ]
    if name is not None and not listed:
        raise UnknownName("plug-in", name, {one.entry.name for one in everything if wanted in (None, one.entry.group)})
    others = [fault for fault in strays if name is None and wanted is None]
    broken = any(not one.works for one in listed) or bool(others)
    found = {"plugins": list(map(views.plugin, listed)), "others": list(map(PluginFaultInfo.view_of, others))}
    lines = _table(listed, others, tracebacks=tracebacks) if name is None else _in_full(listed)
    return found, lines, NOT_REACHED if broken else REACHED


def _group(given: str | None) -> str | None:
    """Returns the group in full ("skiros.skills"); its first part may be left out."""
    if given is None:
        return None
    short = given.removeprefix("skiros.")
    if f"skiros.{short}" not in GROUPS:
        raise UnknownName("group", short, [group.removeprefix("skiros.") for group in GROUPS])
    return f"skiros.{short}"


def _table(listed: Sequence[Surveyed], others: Sequence[PluginFault], *, tracebacks: bool) -> Iterator[str]:
    rows = [(*_row(one), "works" if one.works else "; ".join(f.reason_and_place for f in one.faults)) for one in listed]
    yield from table_lines(("group", "name", "distribution", "object", "state"), rows)
    for fault in others:
        yield f"{fault.distribution}: {fault.reason} ({fault.origin})"
    for fault in (fault for one in listed for fault in one.faults) if tracebacks else ():
        yield from ("", str(fault), *fault.traceback.splitlines())


def _row(one: Surveyed) -> tuple[str, str, str, str]:
    entry = one.entry
    return entry.group.removeprefix("skiros."), entry.name, str(entry.distribution), entry.value


def _in_full(listed: Sequence[Surveyed]) -> Iterator[str]:
    for one in listed:
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
        yield from (f"{title:9} {text}" for title, text in said.items())
        for fault in one.faults:
            yield from (f"{'reason':9} {fault.reason_and_place}", *fault.traceback.splitlines())

"""``skiros module``: skills and primitives on their own, with what holds and what does not (paper Fig. 6)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.options import ASK, GUI, JSON, WITHOUT, cell_options, combined, given_params
from skiros_py.cli.output import NOT_REACHED, REACHED, STOPPED, tell
from skiros_py.cli.run import answering, stopping
from skiros_py.errors import UnknownName

if TYPE_CHECKING:
    from skiros_py.execution.monitor import ModuleEvent
    from skiros_py.execution.panel import Panel
    from skiros_py.execution.skill_manager import SkillManager
    from skiros_py.station.session import Session


@click.group("module")
def command() -> None:
    """Lists, shows and runs single skills and primitives, in simulation or on the fake."""


_SCENE = combined(
    click.option("--scene", default="kitting", show_default=True, metavar="SCENE", help="A name, or a .ttl file."),
    WITHOUT,
)
_CHOICE = combined(
    click.option(
        "--param",
        "params",
        multiple=True,
        metavar="KEY=VALUE",
        help="A parameter; may be repeated; others are inferred.",
    ),
    click.option("--agent", metavar="ID", help="Subsystem that runs it.  [default: the first that can]"),
    _SCENE,
)


@reports("module list --scene kitting", command)
@_SCENE
def list_(scene: str) -> Found:
    """Lists what each skill manager of a scene can run."""
    with _fake(scene) as session:
        found = [(agent, m.info(name)) for agent, m in sorted(session.managers.items()) for name in m.modules]
    width = max((len(info.name) for _, info in found), default=0)
    lines = (f"{agent:10} {info.kind:9} {info.name:{width}}  {info.help}" for agent, info in found)
    return [{"agent": agent, **info.as_json()} for agent, info in found], lines


@reports("module show pick --param Object=starter_1", command)
@click.argument("name")
@_CHOICE
def show(name: str, params: tuple[str, ...], agent: str | None, scene: str) -> Found:
    """Shows a module: its parameters with their current values, its conditions and whether they hold, and its body."""
    with _fake(scene) as session:
        manager = _manager(session, name, agent)
        panel = manager.panel(name, given_params(params))
        info = manager.info(name)
    body = _body(name) if info.kind == "skill" else []
    head = f"{info.kind} {name} {info.version} of {manager.agent}: {info.help}"
    units = {output.name: f" [{output.unit}]" if output.unit else "" for output in info.outputs}
    outputs = [f"  Out({o.name})  ({o.param.type_name}{units[o.name]}: {o.help})" for o in info.outputs]
    found = {"agent": manager.agent, **info.as_json(), **panel.as_json(), "body": body}
    return found, [head, *_panel_lines(panel), *outputs, *(f"  {line}" for line in body)]


@command.command("run", epilog="Example: skiros module run drive --param Location=pallet_a --fake")
@click.argument("name")
@_CHOICE
@cell_options("max")
@GUI
@click.option("--repeat", type=click.IntRange(1), default=1, help="Number of runs.  [default: 1]")
@ASK
@JSON
def run(
    name: str,
    params: tuple[str, ...],
    agent: str | None,
    scene: str,
    repeat: int,
    ask: bool | None,
    as_json: bool,
    **options: Any,
) -> int:
    """Runs a single module, and shows its conditions before and after."""
    from skiros_py.skills.outcome import Success
    from skiros_py.station.session import Options, Session

    with Session(scene, Options(**options)) as session:
        given, manager = given_params(params), _manager(session, name, agent)
        before = manager.panel(name, given)
        if not as_json:
            tell(None, _panel_lines(before), as_json=False)
            session.monitor.subscribe(_print_event)
        outcomes = []
        with stopping(session, as_json=as_json), answering(session.questions, ask=ask):
            for _ in range(repeat):
                outcomes.append(session.run_module(name, given, manager.agent))
                if session.stopped or session.cycle.halted:
                    break
        after = manager.panel(name, given)
    good = sum(isinstance(outcome, Success) for outcome in outcomes)
    runs = [_as_json(outcome) for outcome in outcomes]
    lines = [f"{good} of {len(outcomes)} runs succeeded"] if repeat > 1 else []
    tell({"runs": runs, "before": before.as_json(), "after": after.as_json()}, lines, as_json=as_json)
    if session.stopped:
        return STOPPED
    return REACHED if good == repeat else NOT_REACHED


def _fake(scene: str) -> Session:
    from skiros_py.station.session import Options, Session

    return Session(scene, Options(fake=True))


def _manager(session: Session, name: str, agent: str | None) -> SkillManager:
    if agent is None:
        return session.who_runs(name)
    if agent not in session.managers:
        raise UnknownName("skill manager", agent, session.managers)
    return session.managers[agent]


def _body(name: str) -> list[str]:
    """Returns the bodies of all implementations, including those for other drivers."""
    from skiros_py.catalogue import load_catalogue
    from skiros_py.skills.behaviour import lines

    found = []
    for skill in load_catalogue().skills.values():
        if skill.description.name == name:
            title = ", ".join(word for word in (skill.label, f"driver {skill.driver}" if skill.driver else "") if word)
            found.append(f"does{' (' + title + ')' if title else ''}:")
            found += [f"  {line}" for node in skill.nodes for line in lines(node)]
    return found


def _panel_lines(panel: Panel) -> Iterator[str]:
    from skiros_py.skills.parameters import Kind
    from skiros_py.skills.parameters.values import as_text

    for param in panel.params:
        if param.kind is Kind.PLANNING:
            continue
        value, unit = panel.values.get(param.key), f" {param.unit}" if param.unit else ""
        shown = "-" if value is None else f"{as_text(param, value)}{unit}"
        why = panel.missing.get(param.key) or panel.reasons.get(param.key) or param.help
        yield f"  {param.key} = {shown}  ({param.kind.value} {param.type_name}: {why})"
    for row in panel.rows:
        mark = "?" if row.verdict is None else "yes" if row.verdict else "no"
        yield f"  {row.kind:4} {mark:3} {row.condition}"
        if row.verdict is not None and not row.verdict:
            yield from (f"           {line}" for line in row.verdict.lines()[1:])


def _print_event(event: ModuleEvent) -> None:
    indent = "  " if event.caller else ""
    click.echo(f"{event.time:8.1f} s  {indent}{event.module} {event.status.value} {event.code}  {event.text}")


def _as_json(outcome: Any) -> dict[str, object]:
    from skiros_py.skills.outcome import Failure

    if isinstance(outcome, Failure):
        return {"success": False, "code": outcome.code, "text": outcome.reason}
    return {"success": True, "code": 1, "text": outcome.message}

"""``skiros plan``: what would be done, and the PDDL behind it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.options import GOAL, SKILLS, planner_options
from skiros_py.cli.output import NO_PLAN, REACHED, answer
from skiros_py.errors import UsageError

if TYPE_CHECKING:
    from skiros_py.planning.domain.model import SkillAccount
    from skiros_py.planning.domain.pddl import PddlTexts
    from skiros_py.skills.skill import SkillDescription


@click.command("plan", epilog="Example: skiros plan kitting --write out && ls out")
@click.argument("scene")
@GOAL
@click.option("--robot", metavar="NAME", help="Robot to plan for.  [default: all robots of the scene]")
@click.option(
    "--write",
    "folder",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Write domain.pddl, problem.pddl and plan into DIR.",
)
@click.option("--explain-domain", "explain", is_flag=True, help="Show what was added to the skills, and why.")
@SKILLS
@planner_options
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout, all else on stderr.")
def command(scene: str, folder: Path | None, explain: bool, as_json: bool, **options: Any) -> int:
    """Shows domain, problem and plan for the goal of SCENE; nothing moves."""
    from skiros_py.planning.plan import NoPlan
    from skiros_py.station.session import Options, Session

    with Session(scene, Options(fake=True, **options)) as session:
        planned = session.plan()
        descriptions = [skill.description for _, skill in sorted(session.catalogue.skills.items())]
    outcome, texts = planned.outcome, planned.texts
    assert texts is not None  # every element of a goal just read is there
    steps = [] if isinstance(outcome, NoPlan) else [str(step) for step in outcome.steps]
    reasons = list(outcome.reasons) if isinstance(outcome, NoPlan) else []
    if reasons and (elsewhere := session.catalogue.elsewhere):
        reasons.append(session.catalogue.why_elsewhere(*sorted(elsewhere)))
    causes = outcome.causes if isinstance(outcome, NoPlan) else ()
    repairs = outcome.repairs if isinstance(outcome, NoPlan) else ()
    files = {"domain.pddl": texts.domain, "problem.pddl": texts.problem}
    if not isinstance(outcome, NoPlan):
        files["plan"] = "".join(f"{texts.line(step)}\n" for step in outcome.groundings)
    account = _account(descriptions, texts) if explain else None
    if folder is not None:
        _write(folder, files)
    if as_json:
        found: dict[str, Any] = {
            "steps": steps,
            "reasons": reasons,
            "causes": [cause.as_json() for cause in causes],
            "repairs": [repair.as_json() for repair in repairs],
            "domain": files["domain.pddl"],
            "problem": files["problem.pddl"],
            "plan": files.get("plan", "").splitlines(),
        }
        if account is not None:
            found["skills"] = [entry.as_json() for entry in account]
        answer(found)
    elif account is not None:
        _print_account(account)
    else:
        _print(files, steps, reasons, [repair.text for repair in repairs])
    return NO_PLAN if reasons else REACHED


def _account(skills: Sequence[SkillDescription], texts: PddlTexts) -> tuple[SkillAccount, ...]:
    from skiros_py.planning.domain.model import account_of

    by_name = {skill.name: skill for skill in skills}
    return account_of(by_name.values(), list(texts.actions.items()))


def _print_account(account: Sequence[SkillAccount]) -> None:
    from rich.console import Console
    from rich.markup import escape
    from rich.tree import Tree

    console = Console(highlight=False)
    for entry in account:
        tree = Tree(f"[bold]{escape(entry.skill)}[/]" if entry.skill else "[bold]bookkeeping of the goal[/]")
        written = tree.add("written") if entry.skill else tree
        for title, conditions in (("pre", entry.pre), ("hold", entry.hold), ("post", entry.post)):
            for condition in conditions:
                written.add(f"[dim]{title:4}[/] {escape(condition)}")
        for action in entry.actions:
            made = tree.add(f"action [cyan]{escape(action.name)}[/]({escape(', '.join(action.parameters))})")
            for note in action.notes:
                made.add(escape(note))
        if not entry.actions:
            tree.add("no action: this goal cannot need it")
        console.print(tree)


def _write(folder: Path, files: dict[str, str]) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "plan").unlink(missing_ok=True)  # where there is no plan, none of an earlier goal shall be found
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"--write {folder}: {error.strerror}") from error
    click.echo(f"wrote {', '.join(files)} to {folder}", err=True)


def _print(files: dict[str, str], steps: list[str], reasons: list[str], repairs: list[str]) -> None:
    click.echo(files["domain.pddl"])
    click.echo(files["problem.pddl"])
    if reasons:
        click.echo("; no plan")
        for reason in reasons:
            click.echo(f";   {reason}")
        for repair in repairs:
            click.echo(f";   to make it work: {repair}")
    elif not steps:
        click.echo("; the goal already holds: nothing to do")
    for number, step in enumerate(steps, start=1):
        click.echo(f"{number:2}. {step}")

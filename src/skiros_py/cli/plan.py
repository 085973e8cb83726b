"""``skiros plan``: what would be done, and the PDDL behind it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.options import GOAL, PLANNER, SKILLS
from skiros_py.cli.output import NO_PLAN, REACHED, rendered
from skiros_py.errors import UsageError

if TYPE_CHECKING:
    from skiros_py.planning.domain.model import SkillAccount


@reports("plan kitting --write out && ls out")
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
@PLANNER
def command(scene: str, folder: Path | None, explain: bool, **options: Any) -> Found:
    """Shows domain, problem and plan for the goal of SCENE; nothing moves."""
    from skiros_py.planning.domain.model import account_of
    from skiros_py.planning.plan import NoPlan
    from skiros_py.station.session import Options, Session

    with Session(scene, Options(fake=True, **options)) as session:
        planned = session.plan()
        by_name = {skill.description.name: skill.description for _, skill in sorted(session.catalogue.skills.items())}
    outcome, texts = planned.outcome, planned.texts
    assert texts is not None  # every element of a goal just read is there
    none = outcome if isinstance(outcome, NoPlan) else NoPlan(())
    steps = [] if isinstance(outcome, NoPlan) else [str(step) for step in outcome.steps]
    reasons = list(none.reasons)
    if reasons and (elsewhere := session.catalogue.elsewhere):
        reasons.append(session.catalogue.why_elsewhere(*sorted(elsewhere)))
    files = {"domain.pddl": texts.domain, "problem.pddl": texts.problem}
    if not isinstance(outcome, NoPlan):
        files["plan"] = "".join(f"{texts.line(step)}\n" for step in outcome.groundings)
    if folder is not None:
        _write(folder, files)
    found: dict[str, Any] = {
        "steps": steps,
        "reasons": reasons,
        "causes": [cause.as_json() for cause in none.causes],
        "repairs": [repair.as_json() for repair in none.repairs],
        "domain": files["domain.pddl"],
        "problem": files["problem.pddl"],
        "plan": files.get("plan", "").splitlines(),
        "seconds": None if isinstance(outcome, NoPlan) else outcome.seconds,
        "chance": None if isinstance(outcome, NoPlan) else outcome.chance,
    }
    status = NO_PLAN if reasons else REACHED
    if not explain:
        repairs = [repair.text for repair in none.repairs]
        return found, _lines(files, steps, reasons, repairs, found["seconds"], found["chance"]), status
    account = account_of(by_name.values(), list(texts.actions.items()))
    return {**found, "skills": [asdict(entry) for entry in account]}, _account_lines(account), status


def _account_lines(account: Sequence[SkillAccount]) -> Iterator[str]:
    from rich.markup import escape
    from rich.tree import Tree

    for entry in account:
        tree = Tree(escape(entry.skill) if entry.skill else "bookkeeping of the goal")
        written = tree.add("written") if entry.skill else tree
        for title, conditions in (("pre", entry.pre), ("hold", entry.hold), ("post", entry.post)):
            for condition in conditions:
                written.add(f"{title:4} {escape(condition)}")
        for action in entry.actions:
            made = tree.add(f"action {escape(action.name)}({escape(', '.join(action.parameters))})")
            for note in action.notes:
                made.add(escape(note))
        if not entry.actions:
            tree.add("no action: this goal cannot need it")
        yield from rendered(tree)


def _write(folder: Path, files: dict[str, str]) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "plan").unlink(missing_ok=True)  # where there is no plan, none of an earlier goal shall be found
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"--write {folder}: {error.strerror}") from error
    click.echo(f"wrote {', '.join(files)} to {folder}", err=True)


def _lines(
    files: dict[str, str],
    steps: list[str],
    reasons: list[str],
    repairs: list[str],
    seconds: float | None,
    chance: float | None,
) -> Iterator[str]:
    for name in ("domain.pddl", "problem.pddl"):
        yield from (*files[name].split("\n"),)
    if reasons:
        yield "; no plan"
        yield from (f";   {reason}" for reason in reasons)
        yield from (f";   to make it work: {repair}" for repair in repairs)
    elif not steps:
        yield "; the goal already holds: nothing to do"
    yield from (f"{number:2}. {step}" for number, step in enumerate(steps, start=1))
    if seconds is not None and steps:
        yield f"; expected to take {seconds:.0f} s" + ("" if chance is None else f", first-try chance {chance:.0%}")

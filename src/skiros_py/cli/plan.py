"""``skiros plan``: what would be done, and the PDDL behind it."""

from __future__ import annotations

from pathlib import Path

import click

from skiros_py.cli.exit_status import NO_PLAN, REACHED
from skiros_py.cli.output import answer
from skiros_py.errors import UsageError

__all__ = ["command"]


@click.command("plan", epilog="Example: skiros plan kitting --write out && ls out")
@click.argument("scene")
@click.option("--goal", "goals", multiple=True, metavar="TEXT", help="Goal instead of the scene's; may be repeated.")
@click.option("--robot", metavar="NAME", help="Robot to plan for; all robots of the scene where left out.")
@click.option(
    "--write",
    "folder",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Write domain.pddl, problem.pddl and plan into DIR.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout, all else on stderr.")
def command(scene: str, goals: tuple[str, ...], robot: str | None, folder: Path | None, as_json: bool) -> int:
    """Shows domain, problem and plan for the goal of SCENE; nothing moves."""
    from skiros_py.planning.plan import NoPlan
    from skiros_py.runtime import Options, Session

    with Session(scene, Options(robot=robot, fake=True, goal=goals)) as session:
        planned = session.plan()
    outcome, texts = planned.outcome, planned.texts
    assert texts is not None  # every element of a goal just read is there
    steps = [] if isinstance(outcome, NoPlan) else [str(step) for step in outcome.steps]
    reasons = list(outcome.reasons) if isinstance(outcome, NoPlan) else []
    files = {"domain.pddl": texts.domain, "problem.pddl": texts.problem}
    if not isinstance(outcome, NoPlan):
        files["plan"] = "".join(f"{line}\n" for line in outcome.pddl)
    if folder is not None:
        _write(folder, files)
    if as_json:
        found = {
            "steps": steps,
            "reasons": reasons,
            "domain": files["domain.pddl"],
            "problem": files["problem.pddl"],
            "plan": files.get("plan", "").splitlines(),
        }
        answer(found)
    else:
        _print(files, steps, reasons)
    return NO_PLAN if reasons else REACHED


def _write(folder: Path, files: dict[str, str]) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "plan").unlink(missing_ok=True)  # where there is no plan, none of an earlier goal shall be found
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"--write {folder}: {error.strerror}") from error
    click.echo(f"wrote {', '.join(files)} to {folder}", err=True)


def _print(files: dict[str, str], steps: list[str], reasons: list[str]) -> None:
    click.echo(files["domain.pddl"])
    click.echo(files["problem.pddl"])
    if reasons:
        click.echo("; no plan")
        for reason in reasons:
            click.echo(f";   {reason}")
    elif not steps:
        click.echo("; the goal already holds: nothing to do")
    for number, step in enumerate(steps, start=1):
        click.echo(f"{number:2}. {step}")

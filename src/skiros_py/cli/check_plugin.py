"""``skiros check-plugin``: asks the rules about plug-ins, and runs their skills on a fake robot."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.commands import Found, reports
from skiros_py.cli.output import NOT_REACHED, REACHED, counted, progress
from skiros_py.errors import UsageError

if TYPE_CHECKING:
    from skiros_py.checking.plugin_check import PluginReport

_NEEDS_ROBOT = "it needs a real or simulated robot (--simulate SCENE)"


@reports("check-plugin . --rule unknown-word --rule missing-unit")
@click.argument("what", required=False, metavar="[DISTRIBUTION|FOLDER]")
@click.option("--rule", "rules", multiple=True, metavar="RULE", help="Check this rule only; may be repeated.")
@click.option("--explain", metavar="RULE", help="Show the page about a rule, and check nothing.")
@click.option("--rules", "listed", is_flag=True, help="List the rules, and check nothing.")
@click.option("--no-run", is_flag=True, help="Run no skills.")
@click.option("--simulate", metavar="SCENE", help="Also run skills that need physics, in a simulation of this scene.")
@click.option("--strict", is_flag=True, help="End with 1 for warnings, too.")
def command(
    what: str | None,
    rules: tuple[str, ...],
    explain: str | None,
    listed: bool,
    no_run: bool,
    simulate: str | None,
    strict: bool,
) -> Found:
    """Checks the plug-ins of an installed distribution, or of the package in a folder; without either, all installed.

    Skills for fakes are also run, where their preconditions hold, and the world is compared before and after with what
    they declare. The others are run with --simulate, and their effects are held against what the simulator says; else
    they are listed as not run.

    Exit status: 0 no errors (there may be warnings), 1 errors, 2 wrong usage.
    """
    from skiros_py.skills.lint.checking import RULES, rule

    if explain is not None:
        page = rule(explain).page
        return {"page": page}, page.splitlines()
    if listed:
        found = [{"name": r.name, "severity": r.severity.value, "summary": r.summary} for r in RULES.values()]
        return {"rules": found}, [f"{r['name']:24} {r['severity']:8} {r['summary']}" for r in found]
    from skiros_py.checking.plugin_check import as_installed, check_plugins

    if no_run and simulate is not None:
        raise UsageError("--no-run and --simulate contradict each other: leave out one of them")
    with ExitStack() as stack:
        shown = stack.enter_context(progress("loading"))
        if what is not None and ("/" in what or what in (".", "..") or Path(what, "pyproject.toml").is_file()):
            what = stack.enter_context(as_installed(Path(what)))
        report = check_plugins(what, rules, run=not no_run, simulate=simulate, progress=shown)
    return _as_json(report), _lines(report), NOT_REACHED if report.errors or (strict and report.findings) else REACHED


def _lines(report: PluginReport) -> Iterator[str]:
    from skiros_py.skills.lint.rule import title

    for finding in report.findings:
        yield f"{'warning: ' if finding.severity == 'warning' else ''}{finding}"
    numbers = counted(part=report.parts, error=report.errors, warning=len(report.findings) - report.errors)
    yield f"{', '.join(report.distributions)}: {numbers}"
    for contract in report.contracts:
        name = title(contract.skill)
        yield f"  ran {name} in {contract.where}" if contract.where else f"  never ran {name}"
    yield from (f"  not run: {title(skill)}: {_NEEDS_ROBOT}" for skill in report.not_run)


def _as_json(report: PluginReport) -> dict[str, Any]:
    from skiros_py.skills.lint.rule import title

    ran = [
        {
            "skill": contract.skill.description.name,
            "driver": contract.skill.driver,
            "where": contract.where or None,
            "ended": str(contract.outcome) if contract.outcome else None,
        }
        for contract in report.contracts
    ]
    return {
        "status": NOT_REACHED if report.errors else REACHED,
        "distributions": report.distributions,
        "errors": report.errors,
        "warnings": len(report.findings) - report.errors,
        "findings": [finding.as_json() for finding in report.findings],
        "ran": ran,
        "not_run": [{"skill": title(skill), "why": _NEEDS_ROBOT} for skill in report.not_run],
    }

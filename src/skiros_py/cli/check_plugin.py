"""``skiros check-plugin``: asks the rules about plug-ins, and runs their skills on a fake robot."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skiros_py.cli.options import JSON
from skiros_py.cli.output import NOT_REACHED, REACHED, answer, progress
from skiros_py.errors import UsageError

if TYPE_CHECKING:
    from skiros_py.checking import Contract, PluginReport

_NEEDS_ROBOT = "it needs a real or simulated robot (--simulate SCENE)"


@click.command("check-plugin", epilog="Example: skiros check-plugin . --rule unknown-word --rule missing-unit")
@click.argument("what", required=False, metavar="[DISTRIBUTION|FOLDER]")
@click.option("--rule", "rules", multiple=True, metavar="RULE", help="Check this rule only; may be repeated.")
@click.option("--explain", metavar="RULE", help="Show the page about a rule, and check nothing.")
@click.option("--rules", "listed", is_flag=True, help="List the rules, and check nothing.")
@click.option("--no-run", is_flag=True, help="Run no skills.")
@click.option("--simulate", metavar="SCENE", help="Also run skills that need physics, in a simulation of this scene.")
@click.option("--strict", is_flag=True, help="End with 1 for warnings, too.")
@JSON
def command(
    what: str | None,
    rules: tuple[str, ...],
    explain: str | None,
    listed: bool,
    no_run: bool,
    simulate: str | None,
    strict: bool,
    as_json: bool,
) -> int:
    """Checks the plug-ins of an installed distribution, or of the package in a folder; without either, all installed.

    Skills for fakes are also run, where their preconditions hold, and the world is compared before and after with what
    they declare. The others are run with --simulate, and their effects are held against what the simulator says; else
    they are listed as not run.

    Exit status: 0 no errors (there may be warnings), 1 errors, 2 wrong usage.
    """
    if explain is not None:
        return _explain(explain)
    if listed:
        return _list(as_json=as_json)
    if no_run and simulate is not None:
        raise UsageError("--no-run and --simulate contradict each other: leave out one of them")
    report = _checked(what, rules, run=not no_run, simulate=simulate)
    if as_json:
        answer(_as_json(report))
    else:
        _print(report)
    return NOT_REACHED if report.errors or (strict and report.findings) else REACHED


def _explain(name: str) -> int:
    from skiros_py.skills.lint.checking import rule

    click.echo(rule(name).page, nl=False)
    return REACHED


def _list(*, as_json: bool) -> int:
    from skiros_py.skills.lint.checking import RULES

    if as_json:
        rules = [{"name": r.name, "severity": r.severity.value, "summary": r.summary} for r in RULES.values()]
        answer({"rules": rules})
        return REACHED
    for rule in RULES.values():
        click.echo(f"{rule.name:24} {rule.severity.value:8} {rule.summary}")
    return REACHED


def _checked(what: str | None, rules: tuple[str, ...], *, run: bool, simulate: str | None) -> PluginReport:
    from skiros_py.checking import as_installed, check_plugins

    with ExitStack() as stack:
        shown = stack.enter_context(progress("loading"))
        name = stack.enter_context(as_installed(Path(what))) if what is not None and _is_path(what) else what
        return check_plugins(name, rules, run=run, simulate=simulate, progress=shown)


def _is_path(what: str) -> bool:
    return "/" in what or what in (".", "..") or Path(what, "pyproject.toml").is_file()


def _print(report: PluginReport) -> None:
    from skiros_py.skills.lint.rule import title

    for finding in report.findings:
        mark = "warning: " if finding.severity == "warning" else ""
        click.echo(f"{mark}{finding}")
    warnings = len(report.findings) - report.errors
    counted = ((report.parts, "part"), (report.errors, "error"), (warnings, "warning"))
    numbers = ", ".join(f"{number} {name}{'' if number == 1 else 's'}" for number, name in counted)
    click.echo(f"{', '.join(report.distributions)}: {numbers}")
    for contract in report.contracts:
        click.echo(f"  {_ran(contract)}")
    for skill in report.not_run:
        click.echo(f"  not run: {title(skill)}: {_NEEDS_ROBOT}")


def _ran(contract: Contract) -> str:
    from skiros_py.skills.lint.rule import title

    name = title(contract.skill)
    return f"ran {name} in {contract.where}" if contract.where else f"never ran {name}"


def _as_json(report: PluginReport) -> dict[str, Any]:
    from skiros_py.skills.lint.rule import title

    return {
        "status": NOT_REACHED if report.errors else REACHED,
        "distributions": list(report.distributions),
        "errors": report.errors,
        "warnings": len(report.findings) - report.errors,
        "findings": [finding.as_json() for finding in report.findings],
        "ran": [_contract_as_json(contract) for contract in report.contracts],
        "not_run": [{"skill": title(skill), "why": _NEEDS_ROBOT} for skill in report.not_run],
    }


def _contract_as_json(contract: Contract) -> dict[str, Any]:
    return {
        "skill": contract.skill.description.name,
        "driver": contract.skill.driver,
        "where": contract.where or None,
        "ended": str(contract.outcome) if contract.outcome else None,
    }

"""``skiros world query``: queries a world in SPARQL."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from decimal import Decimal
from pathlib import Path
from typing import TYPE_CHECKING

import click

from skiros_py.cli.options import JSON, key_values, time_limit_option
from skiros_py.cli.output import REACHED, answer, counted, table_lines
from skiros_py.cli.server_choice import present_world
from skiros_py.errors import FileError

if TYPE_CHECKING:
    from skiros_py.cli.world_open import OpenWorld
    from skiros_py.cli.world_server import ServedWorld
    from skiros_py.world.queries.answering import Binding, Result

_ON_THE_WAY = 30.0
"""Maximum time of a response beside the query itself [s]."""
_NUMBERS: Mapping[Callable[[str], Binding], re.Pattern[str]] = {  # as SPARQL tells them apart
    int: re.compile(r"[+-]?[0-9]{1,4000}"),
    Decimal: re.compile(r"[+-]?[0-9]*\.[0-9]+"),
    float: re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)[eE][+-]?[0-9]+"),
}


@click.command(
    "query",
    epilog="""\b
Examples:
  skiros world query kitting 'SELECT ?part { ?part sk:in scene:pallet_a }'
  skiros world query kitting 'SELECT ?a ?b { ?a sk:near ?b . ?b sk:in $place }' --bind place=pallet_a
  skiros world query kitting 'ASK { scene:starter_1 sk:placement ?somewhere }' --entailed
  skiros world query 'SELECT ?robot { ?robot a sk:Robot }' --data run/data --json
""",
)
@click.argument("words", nargs=-1, metavar="[SCENE] [SPARQL]")
@click.option("--data", metavar="DIR", type=click.Path(path_type=Path), help="Query the world of a data directory.")
@click.option("--file", metavar="FILE", type=click.Path(path_type=Path), help="Read the query from FILE.")
@click.option("--bind", "bindings", multiple=True, metavar="NAME=VALUE", help="Value of $NAME; may be repeated.")
@click.option("--entailed", is_flag=True, help="Include OWL entailments: inverses, sub-relations, …")
@JSON
@click.option("--csv", "as_csv", is_flag=True, help="Comma-separated values on stdout (for SELECT).")
@time_limit_option(5.0, "Time limit")
def command(
    words: tuple[str, ...],
    data: Path | None,
    file: Path | None,
    bindings: tuple[str, ...],
    entailed: bool,
    as_json: bool,
    as_csv: bool,
    time_limit: float,
) -> int:
    """Queries a scene, or with --data the world of a data directory, in SPARQL: SELECT, ASK or CONSTRUCT.

    A query covers ontology, scene, learned concepts and computed relations; all prefixes are declared. SPARQL
    "-" is read from stdin. In --bind a value is a number, true or false, a text in double quotes, or else a name
    (pallet_a, kitting:Starter).
    """
    from skiros_py.cli.world_open import OpenWorld
    from skiros_py.station.worlds import open_world
    from skiros_py.world.queries.replica import Limits

    if as_json and as_csv:
        raise click.UsageError("--json and --csv are two ways to show one answer: give one of them")
    scene, sparql = _scene_and_query(words, data, file, Limits().text)
    texts = key_values("--bind", bindings, "place=pallet_a", is_name=str.isidentifier)
    bound = {name: _value(value) for name, value in texts.items()}
    opened: AbstractContextManager[OpenWorld | ServedWorld]
    if data is not None:
        opened = present_world(data, timeout=time_limit + _ON_THE_WAY)
    else:
        opened = nullcontext(OpenWorld(open_world(str(scene))))
    with opened as world:
        result = world.query(sparql, bound, entailed=entailed, time_limit=time_limit)
    if as_json:
        from skiros_py.station.world.ontology import Answer

        answer(Answer(result).data())
    else:
        _show(result, as_csv=as_csv)
    return REACHED


def _scene_and_query(
    words: tuple[str, ...], data: Path | None, file: Path | None, longest: int
) -> tuple[str | None, str]:
    wanted = [name for name, needed in (("SCENE", data is None), ("SPARQL", file is None)) if needed]
    if len(words) != len(wanted):
        given = (
            "--data says which world, --file which query" if data or file else "as in: skiros world query kitting '…'"
        )
        raise click.UsageError(f"needs {' and '.join(wanted) or 'no more words'} ({given}); got {len(words)} words")
    found = dict(zip(wanted, words, strict=True))
    source = str(file) if file is not None else "-" if found["SPARQL"] == "-" else None
    return found.get("SCENE"), found["SPARQL"] if source is None else _read(source, longest)


def _read(source: str, longest: int) -> str:
    """Reads a query from a file, or from stdin for "-"; of one that is too long (or never ends) no more than shows it.

    Raises:
        FileError: It cannot be read, is no UTF-8 text, or is too long.
    """
    path = Path("stdin" if source == "-" else source)
    try:
        with click.open_file(source, encoding="utf-8") as file:
            text: str = file.read(longest + 1)
    except UnicodeError as error:
        raise FileError(path, f"cannot be read as UTF-8 text: {getattr(error, 'reason', error)}") from None
    except (OSError, ValueError) as error:
        raise FileError(path, f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(text) > longest:
        raise FileError(path, f"is no query: it has more than {longest} characters, and those are the most")
    return text


def _value(text: str) -> Binding:
    from skiros_py.world.queries.answering import Text

    if len(text) >= 2 and text[0] == text[-1] == '"':
        return Text(text[1:-1])
    if text in ("true", "false"):
        return text == "true"
    for number, pattern in _NUMBERS.items():
        if pattern.fullmatch(text):
            return number(text)
    return text


# ---------------------------------------------------------------- showing


def _show(result: Result, *, as_csv: bool) -> None:
    from skiros_py.station.world.ontology import Answer, shown_value
    from skiros_py.world.queries.answering import Table

    if as_csv and not isinstance(result, Table):
        raise click.UsageError("--csv shows rows, and only SELECT has rows: leave it out, or give --json")
    if isinstance(result, bool):
        click.echo("yes" if result else "no")
    elif not isinstance(result, Table):
        click.echo(result.turtle, nl=False)
    elif as_csv:  # data for a program, as they are
        click.echo(Answer(result).csv("\n"), nl=False)
    else:
        rows = [[shown_value(row[name]) for name in result.variables] for row in result.rows]
        for line in table_lines(result.variables, rows):
            click.echo(line)
        click.echo(counted(row=len(rows)))

"""Answers to SPARQL queries, as plain data, CSV and Turtle."""

from __future__ import annotations

import csv
import io
from typing import Any

from skiros_py.station.world.values import plain
from skiros_py.world.element import Value
from skiros_py.world.literals import ANY_LITERAL, format_value
from skiros_py.world.queries import Constructed, Result, Table


class Answer:
    """The answer to a query.

    Args:
        result: The result from the world model.
    """

    def __init__(self, result: Result) -> None:
        self.result = result

    def data(self) -> dict[str, Any]:
        """Returns the answer as plain data."""
        result = self.result
        if isinstance(result, bool):
            return {"form": "ASK", "answer": result}
        if isinstance(result, Table):
            rows = [{name: plain(value) for name, value in row.items()} for row in result.rows]
            return {"form": "SELECT", "variables": list(result.variables), "rows": rows}
        statements = [[subject, predicate, plain(value)] for subject, predicate, value in result.statements]
        return {"form": "CONSTRUCT", "statements": statements, "turtle": result.turtle}

    def csv(self, line_end: str = "\r\n") -> str | None:
        """Returns the rows as CSV; None if the query is not SELECT, which alone has rows."""
        if not isinstance(self.result, Table):
            return None
        text = io.StringIO()
        writer = csv.writer(text, lineterminator=line_end)
        writer.writerow(self.result.variables)
        writer.writerows([shown_value(row[name]) for name in self.result.variables] for row in self.result.rows)
        return text.getvalue()

    def turtle(self) -> str | None:
        """Returns the triples as Turtle; None if the query is not CONSTRUCT, which alone has triples."""
        return self.result.turtle if isinstance(self.result, Constructed) else None


def shown_value(value: Value | None) -> str:
    """Returns a value as text; empty for None."""
    if value is None:
        return ""
    return value if isinstance(value, str) else format_value(value, ANY_LITERAL)

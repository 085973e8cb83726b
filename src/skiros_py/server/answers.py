"""Answers to questions in SPARQL, as they are told."""

from __future__ import annotations

import csv
import io
from typing import Any

from fastapi import Response
from fastapi.responses import JSONResponse

from skiros_py.server.problems import Problem
from skiros_py.station.world.values import told
from skiros_py.world.element import Value
from skiros_py.world.literals import ANY_LITERAL, format_value
from skiros_py.world.queries import Constructed, Result, Table

__all__ = ["CSV", "TURTLE", "answer_response"]

CSV, TURTLE = "text/csv", "text/turtle"


def answer_response(result: Result, accept: str) -> Response:
    """Makes the response with an answer.

    Args:
        result: The answer.
        accept: What the client takes; JSON unless it asks for rows as CSV or triples as Turtle.

    Raises:
        Problem: It asks for what this answer has not (406).
    """
    if CSV in accept:
        if not isinstance(result, Table):
            raise Problem(406, "NotAcceptable", "text/csv is for rows, and only SELECT has rows")
        return Response(_csv(result), media_type=f"{CSV}; charset=utf-8")
    if TURTLE in accept:
        if not isinstance(result, Constructed):
            raise Problem(406, "NotAcceptable", "text/turtle is for triples, and only CONSTRUCT has triples")
        return Response(result.turtle, media_type=f"{TURTLE}; charset=utf-8")
    return JSONResponse(_plain(result))  # as it is: checking 10,000 rows against their model takes longer than asking


def _plain(result: Result) -> dict[str, Any]:
    if isinstance(result, bool):
        return {"form": "ASK", "answer": result}
    if isinstance(result, Table):
        rows = [{name: told(value) for name, value in row.items()} for row in result.rows]
        return {"form": "SELECT", "variables": list(result.variables), "rows": rows}
    statements = [[subject, predicate, told(value)] for subject, predicate, value in result.statements]
    return {"form": "CONSTRUCT", "statements": statements, "turtle": result.turtle}


def _csv(table: Table) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\r\n")
    writer.writerow(table.variables)
    writer.writerows([_shown(row[name]) for name in table.variables] for row in table.rows)
    return text.getvalue()


def _shown(value: Value | None) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else format_value(value, ANY_LITERAL)

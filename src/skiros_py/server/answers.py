"""Answers to SPARQL queries, in the form that the client accepts."""

from __future__ import annotations

from fastapi import Response
from fastapi.responses import JSONResponse

from skiros_py.server.problems import Problem
from skiros_py.station.world.answers import Answer

CSV, TURTLE = "text/csv", "text/turtle"


def answer_response(answer: Answer, accept: str) -> Response:
    """Makes the response with an answer.

    Args:
        answer: The answer.
        accept: What the client takes; JSON unless it asks for rows as CSV or triples as Turtle.

    Raises:
        Problem: It asks for what this answer has not (406).
    """
    if CSV in accept:
        rows = answer.csv()
        if rows is None:
            raise Problem(406, "NotAcceptable", "text/csv is for rows, and only SELECT has rows")
        return Response(rows, media_type=f"{CSV}; charset=utf-8")
    if TURTLE in accept:
        turtle = answer.turtle()
        if turtle is None:
            raise Problem(406, "NotAcceptable", "text/turtle is for triples, and only CONSTRUCT has triples")
        return Response(turtle, media_type=f"{TURTLE}; charset=utf-8")
    return JSONResponse(answer.data())  # as it is: checking 10,000 rows against their model takes longer than asking

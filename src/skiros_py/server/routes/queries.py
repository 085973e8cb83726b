"""Routes: queries."""

from __future__ import annotations

from fastapi import Response
from fastapi.responses import JSONResponse

from skiros_py.api.queries import Query, QueryAnswer
from skiros_py.server.access.roles import Engineer
from skiros_py.server.problems import Problem, also_refused, topic_router
from skiros_py.station.world.ontology import Answer

router = topic_router("queries")

CSV, TURTLE = "text/csv", "text/turtle"
_TEXT = {"schema": {"type": "string"}}


@router.post(
    "/queries",
    response_model=QueryAnswer,
    responses={
        200: {"content": {CSV: _TEXT, TURTLE: _TEXT}},
        **also_refused(406, "The answer has no rows (text/csv), or no triples (text/turtle)."),
    },
)
def ask_question(act: Engineer, question: Query) -> Response:
    """Run a SPARQL query.

    Runs a SELECT, ASK or CONSTRUCT query over the ontology, the scene, learned concepts and computed relations.

    A query cannot change anything. It runs in a process of its own, with the limits `time_limit`, 1 GiB of memory,
    10,000 rows and 16 MiB of results; at most four run at once, further ones get 503. `Accept: text/csv` returns the
    rows of a SELECT as CSV, `Accept: text/turtle` the triples of a CONSTRUCT as Turtle.
    """
    return answer_response(act.station.ontology.query(question), act.request.headers.get("accept", ""))


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

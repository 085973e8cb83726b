"""Whatever a stranger asks, there is an answer or an error in time, and everything else goes on."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import psutil
import pytest

from skiros_py.errors import DeviceError, SkirosError, UnknownName, UsageError
from skiros_py.world.element import Value
from skiros_py.world.ontology import Ontology
from skiros_py.world.queries.answering import Binding, Constructed, Table, Text
from skiros_py.world.queries.outside import OutsideQueries
from skiros_py.world.queries.replica import Limits
from skiros_py.world.scene.files import load_scene
from skiros_py.world.world import World

ROOT = Path(__file__).parents[4]
MIB = 1 << 20
LIMITS = Limits(time=1.0, memory=256 * MIB, rows=5_000, bytes=4 * MIB, at_once=3)
SLACK = 2.5
"""How much later than its limit an error may come on a busy machine [s]."""
AGES = 60.0
"""A limit that no test reaches [s]."""

FOR_EVER = "SELECT (COUNT(*) AS ?n) { ?a ?b ?c . ?d ?e ?f . ?g ?h ?i . ?j ?k ?l }"
PARTS = "SELECT ?part { ?part sk:in $place } ORDER BY ?part"
IN_PALLET_A = [{"part": "alternator_1"}, {"part": "relay_box_1"}, {"part": "starter_1"}]


def a_world() -> World:
    return load_scene(Ontology.load([ROOT / "ontologies"]), ROOT / "scenes" / "kitting.ttl")


@pytest.fixture(scope="module")
def live() -> World:
    return a_world()


@pytest.fixture(scope="module")
def others() -> set[psutil.Process]:
    """Children that this process had before: a resource tracker, say, that an earlier test made Python start."""
    return set(psutil.Process().children(recursive=True))


@pytest.fixture(scope="module")
def outside(live: World, others: set[psutil.Process]) -> Iterator[OutsideQueries]:
    with OutsideQueries(live, LIMITS) as queries:
        queries.start()
        yield queries


def refusal(outside: OutsideQueries, sparql: str, time_limit: float = LIMITS.time) -> str:
    """The text of the error that comes within the limit; afterwards all is as it was."""
    began = time.monotonic()
    with pytest.raises(UsageError) as refused:
        outside.query(sparql, time_limit=time_limit)
    assert time.monotonic() - began < time_limit + SLACK
    assert outside.query("ASK { ?robot a sk:Robot }")
    return str(refused.value)


def rows(
    outside: OutsideQueries, sparql: str, bindings: Mapping[str, Binding] | None = None
) -> list[dict[str, Value | None]]:
    table = outside.query(sparql, bindings or {})
    assert isinstance(table, Table)
    return table.rows


def doubled(times: int) -> str:
    """Binds ``?z`` to a text of ten to the power of ``times`` characters, in very few words."""
    steps = (f"BIND(CONCAT({', '.join([f'?t{n}'] * 10)}) AS ?t{n + 1})" for n in range(times))
    return f'BIND("x" AS ?t0) {" ".join(steps)} BIND(?t{times} AS ?z)'


# ---------------------------------------------------------------- answers


def test_each_form_is_answered_with_typed_values(outside: OutsideQueries) -> None:
    made = outside.query("CONSTRUCT { ?p sk:in $place } WHERE { ?p sk:in $place }", {"place": "pallet_a"})

    assert rows(outside, PARTS, {"place": "pallet_a"}) == IN_PALLET_A
    assert rows(outside, "SELECT ?w { scene:camera_1 sk:width ?w }") == [{"w": 320}]
    assert outside.query("ASK { ?s rdfs:label $label }", {"label": Text("rack")})
    assert not outside.query("ASK { ?s rdfs:label $label }", {"label": Text("} DROP ALL #")})
    assert isinstance(made, Constructed)
    assert ("starter_1", "sk:in", "pallet_a") in made.statements


def test_errors_come_as_the_kind_they_are(outside: OutsideQueries) -> None:
    with pytest.raises(UnknownName, match="prefix"):
        outside.query("ASK { ?s a nowhere:Thing }")
    with pytest.raises(UsageError, match="does not parse"):
        outside.query("ASK { ?s ?p }")


def test_a_query_sees_the_latest_committed_change(live: World, outside: OutsideQueries) -> None:
    for mass in (1.5, 2.5, 3.5):
        with live.transaction("scale", "weighed") as tx:
            tx.set("compressor_1", "sk:mass", mass)

        assert rows(outside, "SELECT ?m { scene:compressor_1 sk:mass ?m }") == [{"m": mass}]


def test_owl_entailments_are_included_on_request(outside: OutsideQueries) -> None:
    asked = "ASK { scene:starter_1 sk:placement scene:pallet_a }"

    assert not outside.query(asked)
    assert outside.query(asked, entailed=True, time_limit=20.0)


# ---------------------------------------------------------------- what is too much


@pytest.mark.parametrize(
    "sparql",
    [
        "ASK " + "{" * 5_000 + "}" * 5_000,
        "{" * 5_000,
        "ASK { FILTER" + "(" * 5_000 + "true" + ")" * 5_000 + " }",
        "ASK { ?a " + "(" * 5_000 + "sk:in" + ")" * 5_000 + " ?b }",
        "ASK { " + "[ sk:in " * 5_000 + "scene:floor" + " ]" * 5_000 + " sk:in ?x }",
        "ASK { FILTER(" + "!" * 5_000 + "true) }",
        "ASK { FILTER(" + "! \n" * 5_000 + "true) }",
        "ASK { FILTER(0 = " + "- # minus\n" * 5_000 + "1) }",
        "ASK { ?a " + "^" * 5_000 + "sk:in ?b }",
        "ASK { " + "OPTIONAL { ?a ?b ?c " * 3_000 + "}" * 3_000 + " }",
    ],
    ids=["braces", "open", "brackets", "path", "blanks", "not", "not_apart", "minus", "inverse", "optional"],
)
def test_a_query_nested_thousands_deep_is_refused(outside: OutsideQueries, sparql: str) -> None:
    assert "nested too deep" in refusal(outside, sparql)


def test_a_query_that_is_long_but_not_deep_is_answered_or_refused(outside: OutsideQueries) -> None:
    for sparql in (
        "ASK { FILTER(" + " || ".join(["false"] * 5_000) + ") }",
        "ASK { " + " UNION ".join(["{ ?a sk:in ?b }"] * 2_000) + " }",
        "ASK { ?a " + "/".join(["sk:in"] * 5_000) + " ?b }",
    ):
        try:
            assert outside.query(sparql) in (True, False)
        except UsageError as error:
            assert str(error)  # noqa: PT017  either is right, a death is not
        assert outside.query("ASK { ?robot a sk:Robot }")


@pytest.mark.parametrize("limit", [float("nan"), float("inf"), 1e308, 0.0, -1.0])
def test_an_invalid_time_limit_is_refused(outside: OutsideQueries, limit: float) -> None:
    with pytest.raises(UsageError, match="a time limit is more than 0 and at most 3600 s"):
        outside.query("ASK {}", time_limit=limit)


def test_a_query_text_over_the_length_limit_is_refused_before_parsing(outside: OutsideQueries) -> None:
    said = refusal(outside, "ASK {}" + " " * LIMITS.text)

    assert said == f"the query has {LIMITS.text + 6} characters, and {LIMITS.text} are the most"


@pytest.mark.parametrize(
    "sparql",
    [FOR_EVER, "SELECT (COUNT(*) AS ?n) { ?a (!sk:x)* ?b . ?c (!sk:y)* ?d . ?e (!sk:z)* ?f }"],
    ids=["cross_product", "path"],
)
def test_an_endless_query_is_ended_at_its_time_limit(outside: OutsideQueries, sparql: str) -> None:
    assert "took longer than 1 s" in refusal(outside, sparql)


@pytest.mark.parametrize(
    "sparql",
    [
        f"SELECT (STRLEN(?z) AS ?n) {{ {doubled(9)} }}",
        "SELECT (STRLEN(GROUP_CONCAT(?z)) AS ?n) { ?a ?b ?c " + doubled(6) + " }",
    ],
    ids=["concat", "group_concat"],
)
def test_a_query_is_ended_when_it_exceeds_its_memory_limit(outside: OutsideQueries, sparql: str) -> None:
    # On a busy machine it takes more than the usual second to fill the memory.
    assert "needs more than 256 MiB of memory" in refusal(outside, sparql, time_limit=60.0)


@pytest.mark.parametrize(
    ("sparql", "says"),
    [
        ("SELECT * { ?a ?b ?c . ?d ?e ?f . ?g ?h ?i }", "more than 5000 rows"),
        ("CONSTRUCT { ?a ?e ?f } WHERE { ?a ?b ?c . ?d ?e ?f }", "more than 5000 rows"),
        (f"SELECT ?z {{ {doubled(7)} }}", f"more than {4 * MIB} bytes"),
        (f"SELECT ?z {{ ?a ?b ?c {doubled(5)} }}", f"more than {4 * MIB} bytes"),
    ],
    ids=["rows", "triples", "one_row", "large_rows"],
)
def test_an_answer_that_is_too_large_is_refused(outside: OutsideQueries, sparql: str, says: str) -> None:
    assert says in refusal(outside, sparql)


# ---------------------------------------------------------------- what is not allowed


@pytest.mark.parametrize(
    ("sparql", "says"),
    [
        ("SELECT * { SERVICE <http://a.example/> { ?a ?b ?c } }", "SERVICE"),
        ("SELECT*{service<http://a.example/>{?a ?b ?c}}", "SERVICE"),
        ("SELECT * { ?a ?b ?c SeRvIcE SILENT ?x { ?a ?b ?c } }", "SERVICE"),
        ("SELECT * { ?a sk:in 1SERVICE<http://a.example/>{ } }", "SERVICE"),
        ("SELECT * { SERVICE # of whom\n <http://a.example/> { } }", "SERVICE"),
        ("SELECT * FROM <http://a.example/> { ?a ?b ?c }", "FROM"),
        ("SELECT *from<http://a.example/>{ ?a ?b ?c }", "FROM"),
        ("SELECT(1 AS ?x)FROM NAMED<http://a.example/>{ }", "FROM"),
        ("SELECT * From Named <http://a.example/> { }", "FROM"),
        ("ASK FROM <http://a.example/> { }", "FROM"),
        ("LOAD <http://a.example/>", "LOAD"),
        ("load silent <file:///etc/passwd> INTO GRAPH <http://a.example/>", "LOAD"),
        ("INSERT DATA { scene:a a sk:Thing }", "INSERT changes triples"),
        ("insert{ ?a ?b 1 }where{ ?a ?b ?c }", "INSERT changes triples"),
        ("PREFIX x: <http://x.example/>\nInSeRt DATA { x:a a x:b }", "INSERT changes triples"),
        ("WITH <http://x.example/> DELETE { ?a ?b ?c } WHERE { ?a ?b ?c }", "WITH changes triples"),
        ("DELETE WHERE { ?a ?b ?c }", "DELETE changes triples"),
        ("DROP ALL", "DROP changes triples"),
        ("CLEAR DEFAULT", "CLEAR changes triples"),
    ],
)
def test_federated_queries_and_updates_are_refused_by_keyword(outside: OutsideQueries, sparql: str, says: str) -> None:
    assert says in refusal(outside, sparql)


@pytest.mark.parametrize("after", ["; DROP ALL", "; INSERT DATA { <a:b> <a:c> 1 }", ". ASK {}", "LOAD <a:b>"])
def test_text_after_the_end_of_a_query_is_refused(live: World, outside: OutsideQueries, after: str) -> None:
    version = live.version

    refusal(outside, f"ASK {{ }} {after}")

    assert live.version == version
    assert rows(outside, PARTS, {"place": "pallet_a"}) == IN_PALLET_A


@pytest.mark.parametrize(
    "sparql",
    [
        "ASK { ?a rdfs:label 'SERVICE <http://a.example/> FROM LOAD INSERT' }",
        'ASK { ?a rdfs:label """SERVICE\n"FROM" LOAD""" }',
        "ASK { ?a ?b ?c } # SERVICE FROM NAMED LOAD INSERT",
        "# INSERT DATA LOAD\nASK { ?a ?b ?c }",
        "ASK { ?a <http://a.example/SERVICE/FROM/LOAD/INSERT> ?c }",
        "ASK { ?service ?from ?load . ?insert ?delete ?drop }",
        "PREFIX SERVICE: <http://a.example/> ASK { SERVICE:FROM ?b SERVICE:LOAD }",
    ],
    ids=["text", "long_text", "comment", "first_comment", "iri", "variables", "prefix"],
)
def test_update_keywords_are_allowed_in_strings_comments_and_names(outside: OutsideQueries, sparql: str) -> None:
    assert outside.query(sparql) in (True, False)


# ---------------------------------------------------------------- everything else goes on


def in_thread(
    outside: OutsideQueries, sparql: str, said: list[str], time_limit: float | None = None
) -> threading.Thread:
    def asked() -> None:
        try:
            said.append(str(outside.query(sparql, time_limit=time_limit)))
        except SkirosError as error:
            said.append(str(error))

    thread = threading.Thread(target=asked)
    thread.start()
    return thread


def queries_running(others: set[psutil.Process]) -> int:
    return len(set(psutil.Process().children(recursive=True)) - others) - 1  # the replica itself


def end(slow: list[threading.Thread], others: set[psutil.Process]) -> None:
    """Ends queries that run for long, whatever a busy machine takes to do meanwhile."""
    for process in replica_of(others).children():
        process.kill()
    for thread in slow:
        thread.join()


def replica_of(others: set[psutil.Process]) -> psutil.Process:
    (replica,) = set(psutil.Process().children()) - others
    return replica


def wait_until(holds: Callable[[], bool], seconds: float = 5.0) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_endless_queries_do_not_delay_other_queries(
    live: World, outside: OutsideQueries, others: set[psutil.Process]
) -> None:
    said: list[str] = []
    slow = [in_thread(outside, FOR_EVER, [], AGES) for _ in range(2)]
    wait_until(lambda: queries_running(others) == 2, AGES)

    with live.transaction("scale", "weighed") as tx:
        tx.set("relay_box_2", "sk:mass", 0.125)
    answers = [rows(outside, "SELECT ?m { scene:relay_box_2 sk:mass ?m }") for _ in range(5)]
    in_thread(outside, FOR_EVER, said).join()

    assert answers == [[{"m": 0.125}]] * 5
    assert all("took longer" in text for text in said)
    assert all(thread.is_alive() for thread in slow)
    end(slow, others)


def test_a_login_without_a_free_place_in_time_is_refused(outside: OutsideQueries, others: set[psutil.Process]) -> None:
    slow = [in_thread(outside, FOR_EVER, [], AGES) for _ in range(LIMITS.at_once)]
    wait_until(lambda: queries_running(others) == LIMITS.at_once, AGES)

    with pytest.raises(UsageError, match="3 queries are running already"):
        outside.query("ASK {}", time_limit=0.05)
    end(slow, others)


def test_the_death_of_the_replica_is_survived(
    live: World, outside: OutsideQueries, others: set[psutil.Process]
) -> None:
    outside.query("ASK {}")
    replica = replica_of(others)
    with live.transaction("scale", "weighed") as tx:
        tx.set("relay_box_1", "sk:mass", 0.5)

    os.kill(replica.pid, signal.SIGKILL)

    assert rows(outside, "SELECT ?m { scene:relay_box_1 sk:mass ?m }") == [{"m": 0.5}]
    assert replica_of(others) != replica


def test_the_death_of_the_replica_while_it_answers_is_survived(
    outside: OutsideQueries, others: set[psutil.Process]
) -> None:
    said: list[str] = []
    slow = in_thread(outside, FOR_EVER, said, 2.0 * SLACK)
    wait_until(lambda: queries_running(others) == 1)

    replica_of(others).kill()
    slow.join(30.0)

    assert not slow.is_alive()
    assert len(said) == 1
    assert rows(outside, PARTS, {"place": "pallet_a"}) == IN_PALLET_A


def test_queries_leave_no_process_and_no_open_file_behind(outside: OutsideQueries, others: set[psutil.Process]) -> None:
    def asked() -> None:
        outside.query("ASK {}")
        for sparql in ("ASK { ?a }", "SELECT * { ?a ?b ?c . ?d ?e ?f }"):
            with pytest.raises(UsageError):
                outside.query(sparql)

    asked()
    wait_until(lambda: queries_running(others) == 0)
    before = psutil.Process().num_fds()
    asked()
    wait_until(lambda: queries_running(others) == 0)

    assert psutil.Process().num_fds() == before


def test_closing_ends_the_replica_and_its_running_queries() -> None:
    here = psutil.Process()
    others = set(here.children(recursive=True))
    said: list[str] = []
    with OutsideQueries(a_world(), Limits(time=30.0)) as queries:
        queries.start()
        waiting = in_thread(queries, FOR_EVER, said)
        wait_until(lambda: len(set(here.children(recursive=True)) - others) == 2)
        started = set(here.children(recursive=True)) - others
    waiting.join(10.0)

    _, alive = psutil.wait_procs(started, timeout=5.0)

    assert (alive, waiting.is_alive()) == ([], False)
    assert "was closed" in said[0]
    assert not set(here.children(recursive=True)) - others
    with pytest.raises(DeviceError, match="was closed"):
        queries.query("ASK {}")


def test_a_query_parameter_may_have_any_name(outside: OutsideQueries) -> None:
    assert outside.query("ASK { ?part sk:in $sparql }", {"sparql": "pallet_a"}) is True

"""What every store of triples does, and that the fast one answers as the naive one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable

import pyoxigraph as ox
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import UsageError
from skiros_py.world.store.store import Answer, AnswerLimits, QuadStore, Rows, Term

from ..rdflib_store import RdflibStore  # noqa: TID252  the tests are no installed package

EX = "http://example.org/"
XSD = "http://www.w3.org/2001/XMLSchema#"


def node(name: str) -> ox.NamedNode:
    return ox.NamedNode(EX + name)


ONE, TWO = node("one"), node("two")


def quad(subject: str, predicate: str, object_: str | ox.Literal, graph: ox.NamedNode = ONE) -> ox.Quad:
    return ox.Quad(node(subject), node(predicate), node(object_) if isinstance(object_, str) else object_, graph)


FAMILY = [
    quad("ann", "knows", "bob"),
    quad("bob", "knows", "cid"),
    quad("ann", "age", ox.Literal(41), TWO),
    quad("bob", "age", ox.Literal(7), TWO),
    quad("ann", "name", ox.Literal("Ann"), TWO),
]


@pytest.fixture(params=[QuadStore, RdflibStore])
def empty(request: pytest.FixtureRequest) -> QuadStore:
    store: QuadStore = request.param()
    return store


@pytest.fixture
def store(empty: QuadStore) -> QuadStore:
    empty.extend(FAMILY)
    return empty


def rows(store: QuadStore, text: str) -> list[tuple[Term | None, ...]]:
    answer = store.query(text)
    assert isinstance(answer, Rows)
    return list(answer.rows)


def literal(text: str, datatype: str) -> ox.Literal:
    return ox.Literal(text, datatype=ox.NamedNode(XSD + datatype))


# ---------------------------------------------------------------- what is in it


def test_a_new_store_holds_nothing(empty: QuadStore) -> None:
    assert (len(empty), empty.graphs(), empty.quads()) == (0, (), [])
    assert empty.query("ASK { ?s ?p ?o }") is False


@pytest.mark.parametrize("way", ["add", "extend", "bulk_load"])
def test_an_added_element_exists_once(empty: QuadStore, way: str) -> None:
    for _ in range(2):
        if way == "add":
            for one in FAMILY:
                empty.add(one)
        else:
            getattr(empty, way)(iter(FAMILY))

    assert len(empty) == len(FAMILY)
    assert set(empty.quads()) == set(FAMILY)
    assert empty.graphs() == (ONE.value, TWO.value)


def test_each_graph_holds_its_own(store: QuadStore) -> None:
    assert set(store.quads(ONE)) == set(FAMILY[:2])
    assert set(store.quads(TWO)) == set(FAMILY[2:])
    assert store.quads(node("three")) == []


def test_removing_quads_leaves_all_other_quads(store: QuadStore) -> None:
    store.remove([FAMILY[0], FAMILY[3], quad("nobody", "knows", "ann"), quad("bob", "knows", "cid", TWO)])
    store.remove([])

    assert set(store.quads()) == {FAMILY[1], FAMILY[2], FAMILY[4]}


def test_an_empty_graph_is_not_listed(store: QuadStore) -> None:
    store.remove(FAMILY[:2])

    assert store.graphs() == (TWO.value,)


def test_a_cleared_graph_is_empty_and_may_be_filled_again(store: QuadStore) -> None:
    store.clear(TWO)
    store.clear(node("three"))

    assert (set(store.quads()), store.graphs()) == (set(FAMILY[:2]), (ONE.value,))
    store.add(FAMILY[2])
    assert store.quads(TWO) == [FAMILY[2]]


@pytest.mark.parametrize(
    "term",
    [
        ox.Literal(""),
        ox.Literal('a "quoted" \\ text\nof two lines'),
        ox.Literal("naïve", language="fr"),
        literal("1.5", "decimal"),
        literal("7", "integer"),
        literal("0.1", "double"),
        literal("true", "boolean"),
        literal("no number", "integer"),
        ox.Literal("0 0 0", datatype=node("vector")),
    ],
    ids=str,
)
def test_a_literal_comes_back_as_it_was_written(empty: QuadStore, term: ox.Literal) -> None:
    empty.add(quad("a", "is", term))

    assert empty.quads() == [quad("a", "is", term)]
    assert rows(empty, "SELECT ?o { ?s ?p ?o }") == [(term,)]
    empty.remove([quad("a", "is", term)])
    assert len(empty) == 0


@pytest.mark.parametrize(("text", "datatype"), [("1.50", "decimal"), ("007", "integer"), ("1e0", "double")])
def test_a_number_keeps_its_value_and_type_however_it_was_written(empty: QuadStore, text: str, datatype: str) -> None:
    empty.add(quad("a", "is", literal(text, datatype)))

    ((found,),) = rows(empty, "SELECT ?o { ?s ?p ?o }")

    assert isinstance(found, ox.Literal)
    assert (float(found.value), found.datatype) == (float(text), ox.NamedNode(XSD + datatype))
    empty.remove([quad("a", "is", literal(text, datatype))])
    assert len(empty) == 0


# ---------------------------------------------------------------- queries


def test_a_select_gives_columns_in_order_and_typed_terms(store: QuadStore) -> None:
    answer = store.query(f"SELECT ?age ?who {{ ?who <{EX}age> ?age }} ORDER BY ?age")

    assert answer == Rows(("age", "who"), ((ox.Literal(7), node("bob")), (ox.Literal(41), node("ann"))))


def test_an_unbound_variable_is_none(store: QuadStore) -> None:
    text = f"SELECT ?who ?name {{ ?who <{EX}age> ?age OPTIONAL {{ ?who <{EX}name> ?name }} }} ORDER BY ?age"

    assert rows(store, text) == [(node("bob"), None), (node("ann"), ox.Literal("Ann"))]


def test_a_select_without_a_row_still_has_its_columns(store: QuadStore) -> None:
    assert store.query(f"SELECT ?a ?b {{ ?a <{EX}hates> ?b }}") == Rows(("a", "b"), ())


def test_an_ask_gives_true_or_false(store: QuadStore) -> None:
    assert store.query(f"ASK {{ <{EX}ann> <{EX}knows>+ <{EX}cid> }}") is True
    assert store.query(f"ASK {{ <{EX}cid> <{EX}knows>+ <{EX}ann> }}") is False


def test_a_construct_gives_triples(store: QuadStore) -> None:
    answer = store.query(f"CONSTRUCT {{ ?b <{EX}knownBy> ?a }} WHERE {{ ?a <{EX}knows> ?b }}")

    assert isinstance(answer, tuple)
    assert set(answer) == {
        ox.Triple(node("bob"), node("knownBy"), node("ann")),
        ox.Triple(node("cid"), node("knownBy"), node("bob")),
    }


def test_a_query_reads_the_union_of_all_graphs_or_one_named_graph(store: QuadStore) -> None:
    joined = f"SELECT ?age {{ ?a <{EX}knows> ?b . ?b <{EX}age> ?age }}"

    assert rows(store, joined) == [(ox.Literal(7),)]
    of_two = rows(store, f"SELECT ?o {{ GRAPH <{EX}two> {{ <{EX}ann> ?p ?o }} }}")
    assert Counter(of_two) == {(ox.Literal(41),): 1, (ox.Literal("Ann"),): 1}
    assert Counter(rows(store, "SELECT ?g { GRAPH ?g { ?s ?p ?o } }")) == {(ONE,): 2, (TWO,): 3}


def test_a_query_changes_nothing_and_sees_every_change(store: QuadStore) -> None:
    count = "SELECT (COUNT(*) AS ?n) { ?s ?p ?o }"
    assert rows(store, count) == [(ox.Literal(5),)]

    store.add(quad("cid", "age", ox.Literal(3), TWO))
    assert rows(store, count) == [(ox.Literal(6),)]

    store.clear(ONE)
    assert rows(store, count) == [(ox.Literal(4),)]
    assert len(store) == 4


# ---------------------------------------------------------------- limits and errors


def test_an_answer_may_have_as_many_rows_as_allowed_and_no_more(store: QuadStore) -> None:
    text = "SELECT * { ?s ?p ?o }"

    answer = store.query(text, limits=AnswerLimits(rows=5))
    assert isinstance(answer, Rows)
    assert len(answer.rows) == 5
    with pytest.raises(UsageError, match="more than 4 rows: ask for less, or end with LIMIT"):
        store.query(text, limits=AnswerLimits(rows=4))
    with pytest.raises(UsageError, match="more than 1 rows"):
        store.query("CONSTRUCT WHERE { ?s ?p ?o }", limits=AnswerLimits(rows=1))


def test_an_answer_may_be_as_long_as_allowed_and_no_longer(store: QuadStore) -> None:
    text = f"SELECT ?name {{ <{EX}ann> <{EX}name> ?name }}"

    assert store.query(text, limits=AnswerLimits(bytes=100)) == Rows(("name",), ((ox.Literal("Ann"),),))
    with pytest.raises(UsageError, match="more than 2 bytes"):
        store.query(text, limits=AnswerLimits(bytes=2))
    with pytest.raises(UsageError, match="more than 20 bytes"):
        store.query("CONSTRUCT WHERE { ?s ?p ?o }", limits=AnswerLimits(bytes=20))


def test_an_ask_is_not_limited_in_size(store: QuadStore) -> None:
    assert store.query("ASK { ?s ?p ?o }", limits=AnswerLimits(rows=0, bytes=0)) is True


@pytest.mark.parametrize(
    "text", ["", "SELECT", "SELECT * { ?s ?p }", "ASK { ?s ?p ?o ", "ASK { ?s nowhere:p ?o }", "INSERT DATA {}", "{{{{"]
)
def test_an_invalid_query_is_refused_and_the_store_stays_usable(store: QuadStore, text: str) -> None:
    with pytest.raises(UsageError, match=r"the query (does not parse|cannot be answered)"):
        store.query(text)

    assert store.query("ASK { ?s ?p ?o }") is True


# ---------------------------------------------------------------- functions


def length(term: Term) -> Term | None:
    return ox.Literal(len(term.value)) if isinstance(term, ox.Literal) else None


FUNCTIONS = {EX + "length": length}


def test_a_query_calls_a_function_for_each_row(store: QuadStore) -> None:
    text = f"SELECT ?o ?n {{ <{EX}ann> ?p ?o BIND(<{EX}length>(?o) AS ?n) }}"

    answer = store.query(text, functions=FUNCTIONS)

    assert isinstance(answer, Rows)
    assert set(answer.rows) == {
        (ox.Literal("Ann"), ox.Literal(3)),
        (ox.Literal(41), ox.Literal(2)),
        (node("bob"), None),  # no answer leaves the variable without a value
    }


def test_a_function_can_filter_and_a_missing_result_counts_as_false(store: QuadStore) -> None:
    text = f"SELECT ?o {{ ?s ?p ?o FILTER(<{EX}length>(?o) > 2) }}"

    answer = store.query(text, functions=FUNCTIONS)

    assert answer == Rows(("o",), ((ox.Literal("Ann"),),))


def test_a_function_is_known_to_its_query_only(store: QuadStore) -> None:
    text = f"SELECT ?n {{ BIND(<{EX}length>('four') AS ?n) }}"
    assert store.query(text, functions=FUNCTIONS) == Rows(("n",), ((ox.Literal(4),),))

    try:
        after = rows(store, text)
    except UsageError:
        after = []

    assert all(row == (None,) for row in after)


# ---------------------------------------------------------------- both answer alike

names = st.sampled_from(["a", "b", "c", "d"])
predicates = st.sampled_from(["p", "q"])
literals = st.one_of(st.integers(-3, 3).map(ox.Literal), st.sampled_from(["", "x", 'y"\\'])).map(
    lambda value: value if isinstance(value, ox.Literal) else ox.Literal(value)
)
triples = st.builds(lambda s, p, o: (s, p, o), names, predicates, st.one_of(names, literals))


def in_graphs(found: Iterable[tuple[str, str, str | ox.Literal]]) -> list[ox.Quad]:
    """Each triple in one graph, as a store may expect."""
    return [quad(s, p, o, ONE if s in "ab" else TWO) for s, p, o in found]


datasets = st.lists(triples, max_size=15).map(in_graphs)
changes = st.lists(st.tuples(st.sampled_from(["extend", "remove"]), datasets), max_size=4)

P, Q = f"<{EX}p>", f"<{EX}q>"
QUERIES = [
    "SELECT * { ?s ?p ?o }",
    f"SELECT ?a ?b ?c {{ ?a {P} ?b . ?b {Q} ?c }}",
    f"SELECT ?a ?b {{ ?a {P}+ ?b }}",
    f"SELECT DISTINCT ?a ?b {{ ?a ({P}|^{Q}) ?b }}",
    f"SELECT ?a ?b ?c {{ ?a {P} ?b OPTIONAL {{ ?a {Q} ?c }} }}",
    f"SELECT ?a {{ ?a {P} ?b FILTER NOT EXISTS {{ ?a {Q} ?b }} }}",
    f"SELECT ?a {{ ?a {P} ?b MINUS {{ ?a {Q} ?b }} }}",
    f"SELECT ?a (COUNT(?b) AS ?n) {{ ?a {P} ?b }} GROUP BY ?a",
    f"SELECT ?a ?b {{ {{ ?a {P} ?b }} UNION {{ ?b {Q} ?a }} }}",
    f"SELECT ?a ?n {{ ?a {P} ?n FILTER(isNumeric(?n) && ?n > 0) }}",
    "SELECT ?g ?s { GRAPH ?g { ?s ?p ?o } }",
    f"ASK {{ ?a {P} ?a }}",
    f"CONSTRUCT {{ ?b {Q} ?a }} WHERE {{ ?a {P} ?b FILTER(isIRI(?b)) }}",
]


def comparable(answer: Answer) -> object:
    if isinstance(answer, Rows):
        return set(answer.variables), counted(answer)
    return answer if isinstance(answer, bool) else frozenset(answer)


def counted(answer: Rows) -> Counter[frozenset[tuple[str, str]]]:
    return Counter(
        frozenset((name, str(term)) for name, term in zip(answer.variables, row, strict=True)) for row in answer.rows
    )


def filled(make: Callable[[], QuadStore], first: list[ox.Quad], then: list[tuple[str, list[ox.Quad]]]) -> QuadStore:
    store = make()
    store.bulk_load(first)
    for what, quads in then:
        getattr(store, what)(quads)
    return store


@settings(max_examples=25, deadline=None)
@given(datasets, changes)
def test_both_stores_hold_and_answer_the_same(first: list[ox.Quad], then: list[tuple[str, list[ox.Quad]]]) -> None:
    fast, naive = filled(QuadStore, first, then), filled(RdflibStore, first, then)

    assert set(fast.quads()) == set(naive.quads())
    assert (len(fast), fast.graphs()) == (len(naive), naive.graphs())
    for text in QUERIES:
        assert comparable(fast.query(text)) == comparable(naive.query(text)), text

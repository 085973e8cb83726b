"""The world model compared with rdflib on the same work in the same run.

    uv run python benchmarks/world.py [--threads-seconds 60]

Times are the best of five measurements; the last rows run in a separate process, whose memory counts.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import rdflib
from table import Figure, duration, finish, in_steps
from world_threads import run as run_threads
from world_workload import (
    KITTING,
    ROOT,
    add_part,
    best,
    furnished,
    part_triples,
    seconds_of,
    seconds_per_call,
    write_scene,
)

from skiros_py.world.element import Placement
from skiros_py.world.journal.data_directory import DataDirectory
from skiros_py.world.names import CORE, SCENE
from skiros_py.world.ontology import Ontology
from skiros_py.world.queries.answering import select
from skiros_py.world.scene.files import load_scene, save_scene
from skiros_py.world.world import World

_PARTS, _PLACES = 10_000, 20
_QUERY_PARTS, _QUERY_PLACES = 16_700, 200
_QUERY = """SELECT ?part ?mass WHERE {
  ?part a/rdfs:subClassOf* sk:Manipulatable ; sk:in scene:store_7 ; sk:mass ?mass }"""


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads-seconds", type=float, default=60.0, help="how long 8 threads read and write")
    parser.add_argument("--big", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.big:
        return _big()
    ontology = Ontology.load([ROOT / "ontologies"])
    figures = [*_writing(ontology), *_reading(ontology), *_querying(ontology), *_files(ontology)]
    figures += [*_million(), *_threads(arguments.threads_seconds)]
    return finish("world", figures)


def _rdflib_world(parts: int, places: int) -> rdflib.Graph:
    graph = rdflib.Graph()
    for path in sorted((ROOT / "ontologies").glob("*.ttl")):
        graph.parse(path)
    for number in range(parts):
        for triple in part_triples(number, places):
            graph.add(triple)
    return graph


# ---------------------------------------------------------------- writing


def _writing(ontology: Ontology) -> Iterator[Figure]:
    def all_at_once() -> float:
        world = furnished(ontology, _PLACES)
        return seconds_of(lambda: _add_all(world, _PARTS))

    bare = best(lambda: seconds_of(lambda: _rdflib_world(_PARTS, _PLACES)), 2)
    yield in_steps(
        "add 10,000 elements, one transaction", best(all_at_once), 5.6e6, f"rdflib unchecked {duration(bare)}"
    )
    alone = best(lambda: _one_by_one(furnished(ontology, _PLACES)))
    yield in_steps("add one element, no journal", alone, 560)
    with tempfile.TemporaryDirectory() as folder:
        runs = iter(range(5))
        kept = best(lambda: _one_by_one_kept(ontology, Path(folder) / str(next(runs))))
    yield in_steps("add one element, with journal", kept, 2_200)
    world = furnished(ontology, _PLACES)
    _add_all(world, _PARTS)
    yield in_steps("move an object", _moving(world), 280, f"rdflib unchecked {duration(_rdflib_moving())}")


def _add_all(world: World, parts: int) -> None:
    with world.transaction("benchmark", "adds all at once") as tx:
        for number in range(parts):
            add_part(tx, number, _PLACES)


def _one_by_one(world: World, parts: int = 2000) -> float:
    def add(number: int) -> None:
        with world.transaction("benchmark", "adds one") as tx:
            add_part(tx, number, _PLACES)

    started = time.perf_counter()
    for number in range(parts):
        add(number)
    return (time.perf_counter() - started) / parts


def _one_by_one_kept(ontology: Ontology, folder: Path) -> float:
    scene = folder.with_suffix(".ttl")
    save_scene(furnished(ontology, _PLACES), scene)
    with DataDirectory.open(folder, ontology, scene=scene) as data:
        return _one_by_one(data.world)


def _moving(world: World) -> float:
    ids = world.instances("kitting:Starter")

    def move(number: int) -> None:
        with world.transaction("benchmark", "moves") as tx:
            tx.place(ids[number], "sk:in", f"store_{(number * 7 + 3) % _PLACES}")

    return best(lambda: seconds_per_call(move, 500))


def _rdflib_moving() -> float:
    graph = _rdflib_world(2000, _PLACES)
    inside = rdflib.URIRef(CORE + "in")

    def move(number: int) -> None:
        graph.set((rdflib.URIRef(f"{SCENE}starter_{number + 1}"), inside, rdflib.URIRef(f"{SCENE}store_{number % 7}")))

    return seconds_per_call(move, 500)


# ---------------------------------------------------------------- reading


def _reading(ontology: Ontology) -> Iterator[Figure]:
    world = furnished(ontology, _PLACES)
    _add_all(world, _PARTS)
    graph = _rdflib_world(_PARTS, _PLACES)
    by_id = best(lambda: seconds_per_call(lambda n: world.element(f"starter_{n + 1}"), 2000))
    theirs = seconds_per_call(lambda n: dict(graph.predicate_objects(rdflib.URIRef(f"{SCENE}starter_{n + 1}"))), 500)
    yield in_steps("element by id", by_id, 28, f"rdflib {duration(theirs)}")

    def instances() -> float:
        fresh = furnished(ontology, _PLACES)  # what was sorted once is remembered: each round asks for the first time
        _add_all(fresh, _PARTS)
        return seconds_of(lambda: fresh.instances("sk:Object"))

    rdflib_instances = seconds_of(lambda: _rdflib_instances(graph))
    compared = f"rdflib {duration(rdflib_instances)}"
    yield in_steps("all 10,000 instances of a superclass, first time", best(instances), 110_000, compared)


def _rdflib_instances(graph: rdflib.Graph) -> list[str]:
    classes = graph.transitive_subjects(rdflib.RDFS.subClassOf, rdflib.URIRef(CORE + "Object"))
    return sorted(str(s) for class_ in classes for s in graph.subjects(rdflib.RDF.type, class_))


# ---------------------------------------------------------------- SPARQL


def _querying(ontology: Ontology) -> Iterator[Figure]:
    world = furnished(ontology, _QUERY_PLACES)
    with world.transaction("benchmark", "100 k triples") as tx:
        for number in range(_QUERY_PARTS):
            add_part(tx, number, _QUERY_PLACES)
    graph = _rdflib_world(_QUERY_PARTS, _QUERY_PLACES)
    prefixes = {"sk": CORE, "scene": SCENE, "kitting": KITTING, "rdfs": str(rdflib.RDFS)}
    rows = len(select(world, _QUERY))
    if rows != len(list(graph.query(_QUERY, initNs=prefixes))):
        raise SystemExit("rdflib answers the query otherwise")
    ours = best(lambda: seconds_per_call(lambda _: select(world, _QUERY), 100))
    text = seconds_per_call(lambda _: list(graph.query(_QUERY, initNs=prefixes)), 3)
    prepared = rdflib.plugins.sparql.prepareQuery(_QUERY, initNs=prefixes)
    ready = seconds_per_call(lambda _: list(graph.query(prepared)), 3)
    bound_query = rdflib.plugins.sparql.prepareQuery(
        _QUERY.replace("scene:store_7", "?store").replace("sk:Manipulatable", "?top"), initNs=prefixes
    )
    bindings = {"store": rdflib.URIRef(f"{SCENE}store_7"), "top": rdflib.URIRef(CORE + "Manipulatable")}
    bound = seconds_per_call(lambda _: list(graph.query(bound_query, initBindings=bindings)), 20)
    what = f"SPARQL, subClassOf* and containment, {len(graph):,} triples, {rows} rows"
    theirs = f"rdflib text {duration(text)}, prepared {duration(ready)}, prepared and bound {duration(bound)}"
    yield in_steps(what, ours, 5_600, theirs)
    yield Figure("the same, rdflib on the same text by ours", f"{text / ours:.0f} x", ">= 50 x", text / ours >= 50)
    yield Figure("SPARQL right after a move", duration(_query_after_move(world)))


def _query_after_move(world: World) -> float:
    def move_and_ask(number: int) -> None:
        with world.transaction("benchmark", "moves") as tx:
            tx.place(f"starter_{number + 1}", "sk:in", f"store_{(number + 5) % _QUERY_PLACES}")
        select(world, _QUERY)

    return best(lambda: seconds_per_call(move_and_ask, 50))


# ---------------------------------------------------------------- files


def _files(ontology: Ontology) -> Iterator[Figure]:
    with tempfile.TemporaryDirectory() as folder:
        path, copy = Path(folder) / "parts.ttl", Path(folder) / "copy.ttl"
        write_scene(path, _PARTS, _PLACES)
        world = load_scene(ontology, path)
        graph = rdflib.Graph()
        parse = seconds_of(lambda: graph.parse(path))
        serialize = seconds_of(lambda: graph.serialize(copy, format="turtle"))
        loads = best(lambda: seconds_of(lambda: load_scene(ontology, path)))
        yield in_steps("load a scene of 10,000 elements", loads, 8.3e6, f"rdflib, parsing alone {duration(parse)}")
        saves = best(lambda: seconds_of(lambda: save_scene(world, copy)))
        yield in_steps("save it", saves, 5.6e6, f"rdflib {duration(serialize)}")


# ---------------------------------------------------------------- a million triples


def _million() -> Iterator[Figure]:
    answer = subprocess.run([sys.executable, __file__, "--big"], stdout=subprocess.PIPE, check=True, text=True)
    seen = json.loads(answer.stdout)
    what = f"load {seen['triples']:,} triples, first query answered"
    yield in_steps(what, seen["load"], 167e6)
    memory = seen["peak_mib"]
    yield Figure("  its memory, greatest", f"{memory:.0f} MiB", "<= 1431 MiB", memory <= 1431)
    yield in_steps("  element by id", seen["by_id"], 28)
    yield in_steps("  the hundred instances of a superclass", seen["instances"], 110_000)
    yield in_steps("  move an object", seen["move"], 280)


def _big() -> int:
    """Runs in a separate process, so that its memory is only that of the platform."""
    ontology = Ontology.load([ROOT / "ontologies"])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "million.ttl"
        triples = write_scene(path, 166_500, 500)
        found: dict[str, object] = {"triples": triples}
        worlds: list[World] = []

        def load() -> None:
            worlds.append(load_scene(ontology, path))
            select(worlds[0], _QUERY)

        found["load"] = seconds_of(load)
    world = worlds[0]
    with world.transaction("benchmark", "a hundred others") as tx:
        for number in range(100):
            class_ = ("kitting:Table", "kitting:Rack")[number % 2]
            tx.add(class_, f"furniture {number}", placement=Placement("sk:on", "floor"))
    found["by_id"] = best(lambda: seconds_per_call(lambda n: world.element(f"starter_{n * 80 + 1}"), 2000))
    found["instances"] = best(lambda: seconds_of(lambda: world.instances("sk:Furniture")))
    found["move"] = _moving(world)
    found["peak_mib"] = _peak_mib()
    sys.stdout.write(json.dumps(found))
    return 0


def _peak_mib() -> float:
    """Peak resident memory of this process alone; getrusage would include the parent's memory before exec."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(next(line for line in status.splitlines() if line.startswith("VmHWM")).split()[1]) / 1024


# ---------------------------------------------------------------- threads


def _threads(seconds: float) -> Iterator[Figure]:
    outcome = run_threads(seconds)
    yield Figure(
        f"8 threads, half writing, {seconds:.0f} s: errors, torn reads, lost writes",
        f"{outcome.faults} in {outcome.reads:,} reads and {outcome.writes:,} writes",
        "0",
        outcome.faults == 0,
    )


if __name__ == "__main__":
    sys.exit(main())

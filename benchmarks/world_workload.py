"""The workload for comparing world models: storage places full of parts, each with three properties and a place."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from pathlib import Path

import rdflib

from skiros_py.world.element import Placement
from skiros_py.world.names import CORE, SCENE
from skiros_py.world.ontology import Ontology
from skiros_py.world.transaction import Transaction
from skiros_py.world.world import World

ROOT = Path(__file__).parents[1]
KITTING = "https://w3id.org/skiros-py/kitting#"
_XSD = rdflib.XSD


def best(measure: Callable[[], float], times: int = 5) -> float:
    """Returns the best of several measurements, since other work on the machine only adds time."""
    return min(measure() for _ in range(times))


def seconds_of(work: Callable[[], object]) -> float:
    """Returns the duration of a call [s]."""
    started = time.perf_counter()
    work()
    return time.perf_counter() - started


def seconds_per_call(work: Callable[[int], object], calls: int) -> float:
    """Returns the median time of one call, over five rounds of calls [s]."""
    rounds = []
    for _ in range(5):
        started = time.perf_counter()
        for number in range(calls):
            work(number)
        rounds.append((time.perf_counter() - started) / calls)
    return statistics.median(rounds)


def furnished(ontology: Ontology, places: int) -> World:
    """Returns a world with a floor and storage places, without parts."""
    world = World(ontology)
    with world.transaction("benchmark", "storage places") as tx:
        tx.add("sk:Floor", id="floor")
        for number in range(places):
            tx.add("kitting:Pallet", id=f"store_{number}", placement=Placement("sk:on", "floor"))
    return world


def add_part(tx: Transaction, number: int, places: int) -> str:
    """Adds one part: three properties and a place."""
    properties = {"sk:mass": 0.5 + number % 7, "sk:missing": False, "sk:missedLooks": number % 3}
    placement = Placement("sk:in", f"store_{number % places}")
    return tx.add("kitting:Starter", f"part {number}", None, properties, placement)


def part_triples(number: int, places: int) -> list[tuple[rdflib.URIRef, rdflib.URIRef, rdflib.term.Node]]:
    """Returns the same part for rdflib."""
    part = rdflib.URIRef(f"{SCENE}starter_{number + 1}")
    literals = {"mass": (0.5 + number % 7, _XSD.decimal), "missing": (False, _XSD.boolean)}
    literals["missedLooks"] = (number % 3, _XSD.integer)
    values = [(part, rdflib.URIRef(CORE + k), rdflib.Literal(v, datatype=t)) for k, (v, t) in literals.items()]
    return [
        (part, rdflib.RDF.type, rdflib.URIRef(KITTING + "Starter")),
        (part, rdflib.RDFS.label, rdflib.Literal(f"part {number}")),
        *values,
        (part, rdflib.URIRef(CORE + "in"), rdflib.URIRef(f"{SCENE}store_{number % places}")),
    ]


def write_scene(path: Path, parts: int, places: int) -> int:
    """Writes a scene file with a number of parts and returns its number of statements."""
    with path.open("w", encoding="utf-8") as file:
        file.write(f"@prefix sk: <{CORE}> .\n@prefix scene: <{SCENE}> .\n@prefix kitting: <{KITTING}> .\n")
        file.write("@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .\n")
        file.write('scene:floor a sk:Floor ; rdfs:label "floor" .\n')
        for number in range(places):
            file.write(f'scene:store_{number} a kitting:Pallet ; rdfs:label "store {number}" ; sk:on scene:floor .\n')
        for number in range(parts):
            file.write(
                f'scene:starter_{number + 1} a kitting:Starter ; rdfs:label "part {number}" ;\n'
                f"    sk:mass {0.5 + number % 7} ; sk:missing false ; sk:missedLooks {number % 3} ;\n"
                f"    sk:in scene:store_{number % places} .\n"
            )
    return 2 + 3 * places + 6 * parts

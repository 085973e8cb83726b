"""The same order again is known as the same, however it is written."""

import pytest

from skiros_py.api.jobs import JobOrder
from skiros_py.errors import UsageError
from skiros_py.station.document_store import DocumentStore
from skiros_py.station.jobs.orders import digest_of, is_same, job_order, texts_of

PLAIN = {"goal": "In(Ball, slot_1)", "deadline": "2030-01-01T12:00:00+02:00", "materials": [{"class": "Ball"}]}


@pytest.fixture
def documents(tmp_path):
    store = DocumentStore(tmp_path / "server.db")
    yield store
    store.close()


def ordered(**fields):
    return JobOrder.model_validate(fields)


def test_an_order_with_another_time_zone_or_field_order_is_equal():
    first = job_order(ordered(**PLAIN), "a", ("In(Ball, slot_1)",))
    again = dict(reversed(PLAIN.items())) | {"deadline": "2030-01-01T10:00:00Z", "priority": 0}
    assert is_same(ordered(**again), first)
    assert digest_of(ordered(**again), start=True) == digest_of(ordered(**PLAIN), start=True)


@pytest.mark.parametrize(
    "change",
    [{"priority": 1}, {"goal": "In(Ball, slot_2)"}, {"materials": []}, {"policy": {"ask": True}}, {"expires": True}],
)
def test_orders_that_differ_in_any_field_are_not_equal(change):
    first = job_order(ordered(**PLAIN), "a", ("In(Ball, slot_1)",))
    assert not is_same(ordered(**PLAIN | change), first)
    assert digest_of(ordered(**PLAIN | change), start=True) != digest_of(ordered(**PLAIN), start=True)


def test_an_order_with_a_template_is_the_same_although_the_template_has_changed(documents):
    for slot in ("slot_1", "slot_2"):
        documents.put("template", "fill", {"goal": [{"condition": "In", "arguments": ["Ball", slot]}]})
        order = ordered(work_master="fill")
        if slot == "slot_1":
            first = job_order(order, "a", texts_of(order, documents))
    assert texts_of(order, documents) == ("In(Ball, slot_2)",)
    assert is_same(order, first)
    assert not is_same(ordered(work_master="other"), first)


@pytest.mark.parametrize("id_", [".", "..", "a b", "a/b", "a\x00b", "a\nb"])
def test_an_id_that_would_not_survive_an_address_is_refused(id_):
    with pytest.raises(UsageError):
        job_order(ordered(**PLAIN), id_, ("In(Ball, slot_1)",))

"""Documents outlive the process, and nobody overwrites what they have not seen."""

from contextlib import closing

import pytest

from skiros_py.errors import FileError, StaleVersion, UnknownName
from skiros_py.station.document_store import DocumentStore


@pytest.fixture
def store(tmp_path):
    kept = DocumentStore(tmp_path / "server.db")
    yield kept
    kept.close()


def test_documents_persist_after_reopening_the_file(store, tmp_path):
    store.put("sequence", 'it\'s "odd"\n', {"steps": [1, None, "ä"]})
    store.close()
    again = DocumentStore(tmp_path / "server.db")
    try:
        assert again.find("sequence", 'it\'s "odd"\n').data == {"steps": [1, None, "ä"]}
    finally:
        again.close()


def test_documents_of_different_kinds_can_have_the_same_name(store):
    store.put("sequence", "a", 1)
    store.put("template", "a", 2)
    assert [document.data for document in store.all("sequence")] == [1]


def test_a_document_is_overwritten_only_with_its_expected_version(store):
    first = store.put("sequence", "a", 1, expects=0)
    with pytest.raises(StaleVersion, match=f"version {first.version} is there, not version 0"):
        store.put("sequence", "a", 2, expects=0)
    second = store.put("sequence", "a", 2, expects=first.version)
    with pytest.raises(StaleVersion):
        store.remove("sequence", "a", expects=first.version)
    assert store.find("sequence", "a") == second


def test_an_unreadable_document_hides_no_others_and_can_be_replaced(store):
    store.put("sequence", "a", 1)
    version = store.put("sequence", "b", 2).version
    with store._database.transaction() as connection:
        connection.execute("UPDATE documents SET data = '{' WHERE name = 'b'")
    assert [document.name for document in store.all("sequence")] == ["a"]
    with pytest.raises(FileError, match="the sequence 'b' cannot be read"):
        store.get("sequence", "b")
    assert store.put("sequence", "b", 3, expects=version).data == 3
    assert [document.name for document in store.all("sequence")] == ["a", "b"]


def test_a_recreated_document_has_a_new_version(store):
    first = store.put("sequence", "a", 1)
    store.remove("sequence", "a")
    assert store.get("sequence", "a") is None
    assert store.put("sequence", "a", 1).version > first.version


def test_a_missing_document_is_refused_with_similar_names(store):
    store.put("sequence", "fill kit", 1)
    with pytest.raises(UnknownName, match="Did you mean 'fill kit'"):
        store.find("sequence", "fil kit")


def test_listeners_receive_written_and_removed_documents(tmp_path):
    heard = []
    told = DocumentStore(tmp_path / "told.db", lambda what, one: heard.append((what, one.name, one.version)))
    with closing(told):
        told.put("sequence", "a", {})
        told.remove("sequence", "a")
        told.remove("sequence", "a")

    assert heard == [("written", "a", 1), ("removed", "a", 1)]

"""Documents outlive the process, and nobody overwrites what they have not seen."""

from contextlib import closing

import pytest

from skiros_py.errors import StaleVersion, UnknownName
from skiros_py.station.document_store import DocumentStore


@pytest.fixture
def store(tmp_path):
    kept = DocumentStore(tmp_path / "server.db")
    yield kept
    kept.close()


def test_written_data_is_there_when_the_file_is_opened_again(store, tmp_path):
    store.put("sequence", 'it\'s "odd"\n', {"steps": [1, None, "ä"]})
    store.close()
    again = DocumentStore(tmp_path / "server.db")
    try:
        assert again.find("sequence", 'it\'s "odd"\n').data == {"steps": [1, None, "ä"]}
    finally:
        again.close()


def test_kinds_have_names_of_their_own(store):
    store.put("sequence", "a", 1)
    store.put("template", "a", 2)
    assert [document.data for document in store.all("sequence")] == [1]


def test_another_version_than_the_expected_one_is_not_overwritten(store):
    first = store.put("sequence", "a", 1, expects=0)
    with pytest.raises(StaleVersion, match=f"version {first.version} is there, not version 0"):
        store.put("sequence", "a", 2, expects=0)
    second = store.put("sequence", "a", 2, expects=first.version)
    with pytest.raises(StaleVersion):
        store.remove("sequence", "a", expects=first.version)
    assert store.find("sequence", "a") == second


def test_a_document_removed_and_created_again_has_another_version(store):
    first = store.put("sequence", "a", 1)
    store.remove("sequence", "a")
    assert store.get("sequence", "a") is None
    assert store.put("sequence", "a", 1).version > first.version


def test_what_is_not_there_is_named_with_what_is_like_it(store):
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

"""Messages are English texts that keep what they are made of."""

from __future__ import annotations

import json
import pickle

from skiros_py.errors import UnknownName, WrongState
from skiros_py.messages import Message, all_of, cut, joined, listed, messages_in, read_message


def test_a_message_is_its_english_text() -> None:
    text = Message("{part} is {width:.2f} m wide", part="ball_1", width=0.5)
    assert text == "ball_1 is 0.50 m wide"
    assert json.dumps(text) == '"ball_1 is 0.50 m wide"'
    assert {text: 1}["ball_1 is 0.50 m wide"] == 1


def test_its_data_has_numbers_as_written_and_the_template_without_formats() -> None:
    text = Message("{part} is {width:.2f} m wide", part="ball_1", width=0.5)
    assert text.data == {"template": "{part} is {width} m wide", "values": {"part": "ball_1", "width": "0.50"}}


def test_messages_in_messages_stay_messages() -> None:
    inner = Message("{part} is lost", part="ball_1")
    outer = Message("job {job}: {why}", job="kit", why=inner)
    assert outer.data["values"] == {"job": "kit", "why": inner.data}
    assert read_message(outer.data) == outer
    assert read_message(outer.data).data == outer.data


def test_a_message_outlives_errors_pickling_and_str() -> None:
    text = Message("job '{job}' is over", job="kit")
    assert str(WrongState(text)) is text
    assert pickle.loads(pickle.dumps(WrongState(text))).args[0].data == text.data


def test_an_error_of_a_template_and_values_is_a_message() -> None:
    error = WrongState("job '{job}' is over", job="kit")
    assert str(error) == "job 'kit' is over"
    assert error.args[0].data == {"template": "job '{job}' is over", "values": {"job": "kit"}}
    assert str(WrongState("{as it is}")) == "{as it is}"


def test_a_text_is_cut_and_a_short_message_stays_one() -> None:
    text = Message("{part} is lost", part="ball_1")
    assert cut(text, 100) is text
    assert cut(text, 4) == "ball"


def test_a_message_says_what_its_values_were_when_it_was_made() -> None:
    error = WrongState("first")
    error.args = (Message("again: {error}", error=error),)
    assert error.args[0].data["values"] == {"error": "first"}


def test_texts_are_joined_and_listed_as_messages() -> None:
    assert joined("; ", ["a", Message("no {kind}", kind="Ball")]) == "a; no Ball"
    assert listed([]) == ""
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert listed(["a", "b"], either=True) == "a or b"
    assert listed("abcdefg") == "a, b, c, d and 3 more"
    assert all_of(["a", "b", "c"]) == "a and b and c"


def test_all_messages_in_plain_data_are_found() -> None:
    text = Message("no {kind}", kind="Ball")
    assert messages_in({"why": ["plain", text], "number": 3, "more": {"deep": (text,)}}) == {"no Ball": text.data}


def test_an_unknown_name_is_said_in_sentences() -> None:
    error = UnknownName("skill", "pikc", ["pick", "place"], where="of arm_1")
    assert str(error) == "unknown skill 'pikc' of arm_1. Did you mean 'pick'? Known: pick, place."
    assert [part.template for part in error.args[0].values.values()] == [
        "unknown {kind} '{name}' {where}.",
        "Did you mean '{name}'?",
        "Known: {names}.",
    ]

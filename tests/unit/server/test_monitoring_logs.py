"""What is logged."""

import io
import json
import logging
from collections.abc import Iterator

import pytest

from skiros_py.server.monitoring import job_events_logged, log_to, request_id
from skiros_py.station.events.log import EventLog, Kind


@pytest.fixture
def lines() -> Iterator[io.StringIO]:
    root = logging.getLogger()
    before, level = root.handlers[:], root.level
    stream = io.StringIO()
    log_to(stream, form="json")
    yield stream
    root.handlers[:] = before
    root.setLevel(level)


def _read(stream: io.StringIO) -> list[dict]:
    return [json.loads(line) for line in stream.getvalue().splitlines()]


def test_a_log_record_of_a_plug_in_is_one_json_object_with_its_job(lines):
    logging.getLogger("my_plugin").warning("only %d left", 3, extra={"job": "kit-1"})

    (entry,) = _read(lines)
    assert (entry["event"], entry["level"], entry["logger"], entry["job"]) == (
        "only 3 left",
        "warning",
        "my_plugin",
        "kit-1",
    )


def test_a_traceback_holds_no_values_of_variables(lines):
    secret = "sk_very_secret"
    try:
        raise ValueError("broke")
    except ValueError:
        logging.getLogger("my_plugin").exception("it broke")

    assert secret not in lines.getvalue()
    (entry,) = _read(lines)
    assert entry["exception"][0]["exc_type"] == "ValueError"


class _Forger:
    def __repr__(self) -> str:
        return "x\n2026-11-27T10:00:00Z [info     ] forged"


def test_no_text_looks_like_another_record_or_steers_the_terminal_in_the_log_for_people(lines):
    stream = io.StringIO()
    log_to(stream, form="console")
    bad = "because\n2026-11-27T10:00:00Z [info     ] forged \x1b[2J\r\u202e"
    about = {"job": bad, bad: 1, "number": [bad], "other": _Forger()}
    logging.getLogger("my_plugin" + bad).info("order: %s", bad, extra=about, stack_info=True)
    try:
        raise ValueError(bad)
    except ValueError:
        logging.getLogger("my_plugin").exception("it broke")

    text = stream.getvalue()
    records = [line for line in text.split("\n") if line and not line.startswith("  ")]
    assert len(records) == 2
    assert all(char.isprintable() or char == "\n" for char in text)
    assert "order: because\\n2026-11-27T10:00:00Z [info     ] forged \\x1b[2J\\r\\u202e" in records[0]
    assert "ValueError: because" in text


def test_text_of_several_lines_stays_one_line(lines):
    logging.getLogger("my_plugin").info("one\ntwo\x00")

    (entry,) = _read(lines)
    assert entry["event"] == "one\ntwo\x00"


def test_a_log_record_names_the_request_that_caused_it(lines):
    token = request_id.set("r-1")
    logging.getLogger("x").warning("a")
    request_id.reset(token)
    logging.getLogger("x").warning("b")

    first, second = _read(lines)
    assert first["request"] == "r-1"
    assert "request" not in second


def test_each_state_of_a_job_is_logged_once_with_its_id_and_world_changes_are_not(lines):
    events = EventLog(10)
    job_events_logged(events)
    events.append(Kind.WORLD, "changed")
    events.append(Kind.JOB, "running", "kit-1", job="kit-1", data={"detail": "planning"})

    (entry,) = _read(lines)
    assert (entry["event"], entry["job"], entry["number"]) == ("job kit-1 running planning", "kit-1", 2)


def test_configuring_logging_twice_logs_each_record_once(lines):
    second = io.StringIO()
    log_to(second, form="console")
    logging.getLogger("x").warning("once")

    assert not lines.getvalue()
    assert second.getvalue().count("once") == 1

"""Records of runs: what was written while one went on, read again for replay and for people."""

from skiros_py.records.frames import Frame
from skiros_py.records.reader import Record, find_record
from skiros_py.records.recorder import RunRecorder
from skiros_py.records.report import report_page
from skiros_py.records.writer import RecordWriter

__all__ = ["Frame", "Record", "RecordWriter", "RunRecorder", "find_record", "report_page"]

"""TensorBoard's event files, written so that a full or failing disk costs only points of curves.

TensorBoard's own writer (2.21) ends its thread with a traceback at the first failed write. It leaves half a record in
the file, which hides all later records from readers. From then on it raises in the training loop.
"""

from __future__ import annotations

import contextlib
import io
import os
import socket
import sys
import time
from collections import deque
from typing import Any

from tensorboard.compat.proto.event_pb2 import (
    Event,  # pyright: ignore[reportAttributeAccessIssue]  # protobuf makes it at import
    SourceMetadata,  # pyright: ignore[reportAttributeAccessIssue]
)
from tensorboard.summary.writer.record_writer import RecordWriter
from torch.utils.tensorboard import SummaryWriter
from torch.utils.tensorboard.writer import FileWriter

MOST_WAITING = 50_000
"""Events kept while they cannot be written; the oldest are lost first. About 5 MB of scalars."""


class EventFile:
    """An event file. It always ends with a whole record, and no method raises because of the disk."""

    _made = 0

    def __init__(self, log_dir: str):
        """Name the file; it is made at the first :meth:`flush`.

        Args:
            log_dir: folder of the file.
        """
        self._log_dir = log_dir
        name = f"events.out.tfevents.{int(time.time()):010}.{socket.gethostname()}.{os.getpid()}.{EventFile._made}"
        EventFile._made += 1
        self.path = os.path.join(log_dir, name)
        self._handle: int | None = None
        self._size = 0
        self._waiting: deque[bytes] = deque()
        self.lost = 0
        """Events that were not written and are not kept any more."""
        self.problem: str | None = None
        """Why events are not written now."""
        source = SourceMetadata(writer="lift_lab_rl.rsl_rl.curve_files")
        self.add_event(Event(wall_time=time.time(), file_version="brain.Event:2", source_metadata=source))

    def get_logdir(self) -> str:
        """Folder of the file."""
        return self._log_dir

    def add_event(self, event: Event) -> None:
        """Keep an event for the next :meth:`flush`."""
        record = io.BytesIO()
        RecordWriter(record).write(event.SerializeToString())
        self._waiting.append(record.getvalue())
        if len(self._waiting) > MOST_WAITING:
            self._waiting.popleft()
            self.lost += 1

    def flush(self) -> None:
        """Write what waits. If that fails it stays for the next time, and the first failure is a warning."""
        data = b"".join(self._waiting)
        if not data:
            return
        try:
            self._write(data)
        except OSError as error:
            self._cut()
            if self.problem is None:
                reason = error.strerror or str(error)
                print(
                    f"warning: cannot write '{self.path}': {reason}; the training goes on, and its curves are kept "
                    "and written when that works again",
                    file=sys.stderr,
                )
            self.problem = error.strerror or str(error)
            return
        self._size += len(data)
        self._waiting.clear()
        self.problem = None

    def close(self) -> None:
        """Write what waits and close the file."""
        self.flush()
        lost = self.lost + len(self._waiting)
        if lost:
            print(f"warning: {lost} points of curves are missing in '{self.path}'", file=sys.stderr)
        self._waiting.clear()
        self.lost = 0
        if self._handle is not None:
            with contextlib.suppress(OSError):
                os.close(self._handle)
        self._handle = None

    def reopen(self) -> None:
        """Nothing to do: a file that is written to again is opened again."""

    def _write(self, data: bytes) -> None:
        if self._handle is None:
            os.makedirs(self._log_dir, exist_ok=True)
            self._handle = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        left = memoryview(data)
        while left:
            left = left[os.write(self._handle, left) :]

    def _cut(self) -> None:
        """Take half a record off the end of the file."""
        if self._handle is None:
            return
        with contextlib.suppress(OSError):
            os.ftruncate(self._handle, self._size)


class CurveWriter(SummaryWriter):
    """TensorBoard's writer on an :class:`EventFile`. A value reaches the disk with the next :meth:`flush`."""

    def _get_file_writer(self) -> FileWriter:
        if self.all_writers is None or self.file_writer is None:
            writer: Any = FileWriter.__new__(FileWriter)  # its constructor starts the thread that this does without
            writer.event_writer = EventFile(str(self.log_dir))
            self.file_writer = writer
            self.all_writers = {str(self.log_dir): writer}
        return self.file_writer

#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""One process of a stream of the soak test: stream_end.py NAME SPEC, in the folder of the run; streams.py describes SPEC.

The number of each frame that is pushed is written to NAME.sent, and of each that arrives to NAME.got, with the time: 16 bytes a frame
that outlast a killed process. NAME.stats has the counters of all elements, a line each second. SIGTERM ends the stream in order.
"""

import ctypes
import json
import os
import pathlib
import random
import re
import signal
import struct
import subprocess
import sys
import threading
import time
import warnings

import numpy
import weir

RECORD = struct.Struct("<qq")  # number of a frame, nanoseconds
LENGTH = 64  # numbers of a frame, all of them the same


class Mallinfo(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in
                ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost")]


mallinfo = ctypes.CDLL(None).mallinfo2
mallinfo.restype = Mallinfo


def allocated_bytes():
    info = mallinfo()
    return info.uordblks + info.hblkhd


class FrameLog:
    """Survives the process: every record is one write()."""

    def __init__(self, path):
        self.file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)

    def append(self, number):
        os.write(self.file, RECORD.pack(number, time.monotonic_ns()))

    def last(self):
        size = os.fstat(self.file).st_size
        return RECORD.unpack(os.pread(self.file, RECORD.size, size - RECORD.size))[0] if size else -1


class StreamEnd:
    def __init__(self, name, spec):
        self.spec = spec
        self.name = name
        self.ending = threading.Event()
        self.sent, self.got = FrameLog(f"{name}.sent"), FrameLog(f"{name}.got")
        self.stats = open(f"{name}.stats", "a", buffering=1, encoding="utf-8")
        self.random = random.Random(name)
        self.run = self.arrived = 0
        self.pipeline = None
        signal.signal(signal.SIGTERM, lambda *_: self.ending.set())

    def report(self, **more):
        line = {"pid": os.getpid(), "run": self.run, "time": time.monotonic_ns(), "allocated": allocated_bytes(),
                "stats": self.pipeline.stats() if self.pipeline else {}}
        self.stats.write(json.dumps(line | more) + "\n")

    def send(self, pipeline, stop):
        """Pushes numbered frames at the rate of the spec. A number that was used once is not used again."""
        due = time.monotonic()
        while not stop.is_set() and not self.ending.is_set():
            number = self.sent.last() + 1
            self.sent.append(number)
            try:
                pipeline.push("in", numpy.full(LENGTH, number, numpy.int64))
            except weir.Error:  # pull raises it too
                return
            due = max(due + 1 / self.spec["send"], time.monotonic())
            stop.wait(due - time.monotonic())
        if not stop.is_set():
            pipeline.end("in")

    def step(self, timeout):
        """Whether a frame came in this time, or for a pipeline without `out`, whether it still plays."""
        if "name=out" not in self.spec["pipeline"]:
            return not self.pipeline.wait(timeout)
        frame = self.pipeline.pull("out", timeout)
        if frame is None:
            return False
        self.arrived += 1
        if not self.spec.get("send") and not self.spec.get("numbered"):
            self.got.append(self.arrived)
            return True
        numbers = frame[0].reshape(-1) - self.spec.get("add", 0)
        if len(numbers) != LENGTH or (numbers != numbers[0]).any():
            raise ValueError(f"{self.name}: a frame is damaged: {numbers}")
        self.got.append(int(numbers[0]))
        return True

    def edit(self):
        if self.spec.get("edits"):
            method, *arguments = self.random.choice(self.spec["edits"])
            getattr(self.pipeline, method)(*arguments)

    def play(self):
        """Plays until SIGTERM, then until what is in the pipeline has arrived."""
        next_report = next_edit = time.monotonic() + 1
        while not self.ending.is_set():
            self.step(0.2)
            if time.monotonic() >= next_report:
                next_report = time.monotonic() + 1
                self.report()
            if time.monotonic() >= next_edit:
                next_edit = time.monotonic() + self.random.uniform(1, 5)
                self.edit()
        if "name=gate" in self.spec["pipeline"]:
            self.pipeline.start()  # the last edit may have paused it
            self.pipeline.open_valve("gate", False)
        end = time.monotonic() + 20
        while time.monotonic() < end and (self.step(2) or self.still_sends()):
            pass
        self.report(final=True)

    def still_sends(self):
        return bool(self.spec.get("send")) and not self.pipeline.wait(0)

    def keep_written(self, path):
        """What the stream wrote into its file counts as arrived, up to the last whole frame."""
        data = pathlib.Path(path).read_bytes()
        frames = numpy.frombuffer(data[:len(data) // (8 * LENGTH) * 8 * LENGTH], numpy.int64).reshape(-1, LENGTH)
        for frame in frames:
            if (frame != frame[0]).any():
                raise ValueError(f"{self.name}: a written frame is damaged: {frame}")
            self.got.append(int(frame[0]))
        os.truncate(path, 0)

    def main(self):
        while not self.ending.is_set():
            self.run += 1
            stop = threading.Event()
            self.pipeline = weir.Pipeline(self.spec["pipeline"])
            sender = threading.Thread(target=self.send, args=(self.pipeline, stop))
            try:
                with self.pipeline:
                    if self.spec.get("send"):
                        sender.start()
                    self.play()
            except weir.Error as error:
                # Of a pipeline that ends with the error that it must end with, the user starts the next one.
                if not re.search(self.spec.get("ends with", "$^"), str(error)):
                    raise
                self.report(error=str(error))
                self.ending.wait(1)
            stop.set()
            if sender.ident:
                sender.join()
            self.pipeline.close()
            if "file" in self.spec:
                self.keep_written(self.spec["file"])


def run_files(name, spec):
    """`weir run` of the same file again and again. Each run must write what it read, and add up."""
    end = StreamEnd(name, spec)
    source, out = pathlib.Path(f"{name}.in"), pathlib.Path(f"{name}.out")
    source.write_bytes(numpy.repeat(numpy.arange(spec["frames"], dtype=numpy.int64), LENGTH).tobytes())
    while not end.ending.is_set():
        end.run += 1
        pathlib.Path(spec["report"]).unlink(missing_ok=True)
        done = subprocess.run(["weir", "run", "--json", "--report", spec["report"], spec["command"].format(source=source, out=out)],
                              capture_output=True, text=True, check=False)
        try:
            printed = json.loads(done.stdout)
        except json.JSONDecodeError:
            printed = {}
        same = out.read_bytes() == source.read_bytes()
        if printed.get("result") != "eos" or not same or (done.returncode and not re.search(spec["ends with"], done.stderr)):
            raise RuntimeError(f"{name}: weir run exits with {done.returncode}, the file is {'the same' if same else 'another'}: {done}")
        end.got.append(end.run)
        end.report(result="eos", frames=spec["frames"], **({"error": done.stderr} if done.returncode else {}))
        end.ending.wait(spec["pause"])
    end.report(final=True)


def main():
    name, spec = sys.argv[1], json.loads(sys.argv[2])
    warnings.simplefilter("always", weir.PipelineWarning)
    if "command" in spec:
        run_files(name, spec)
    else:
        StreamEnd(name, spec).main()


if __name__ == "__main__":
    main()

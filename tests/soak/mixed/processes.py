# SPDX-License-Identifier: LGPL-2.1-or-later
"""A process of the soak test: starts, stalls and kills it, and reads what the kernel and the process itself say of it."""

import contextlib
import json
import os
import pathlib
import signal
import subprocess
import sys

STREAM_END = pathlib.Path(__file__).parent / "stream_end.py"
RECORD_BYTES = 16


def signal_pid(pid, number):
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, number)


def children():
    """Of each process, the processes that it started, by their names."""
    found = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            pid, rest = stat.read_text().split(" (", 1)
            name, fields = rest.rsplit(") ", 1)
            found.setdefault(int(fields.split()[1]), []).append((int(pid), name))
    return found


def memory_of(pid):
    """Resident memory and its parts, descriptors and threads; None when the process has ended."""
    folder = pathlib.Path("/proc") / str(pid)
    try:
        status = dict(line.split(":", 1) for line in (folder / "status").read_text().splitlines() if ":" in line)
        pss = next(int(line.split()[1]) for line in (folder / "smaps_rollup").read_text().splitlines() if line.startswith("Pss:"))
        return {"rss_kb": int(status["VmRSS"].split()[0]), "anon_kb": int(status["RssAnon"].split()[0]), "pss_kb": pss,
                "descriptors": len(os.listdir(folder / "fd")), "threads": int(status["Threads"])}
    except (OSError, KeyError, StopIteration):
        return None


class Process:
    def __init__(self, name, spec):
        self.name, self.spec = name, spec
        self.process = None
        self.down = True
        self.stalled = False

    def start(self):
        command = self.spec if isinstance(self.spec, list) else [sys.executable, STREAM_END, self.name, json.dumps(self.spec)]
        with open(f"{self.name}.log", "ab") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL)
        self.down = False

    def end(self, number, wait=True):
        """SIGKILL, or SIGTERM, after which the exit status must be 0."""
        self.resume()
        self.down = True
        self.process.send_signal(number)
        if wait:
            self.process.wait()

    def kill(self):
        if self.process:
            self.down = True
            self.process.kill()
            self.process.wait()

    def stall(self):
        self.stalled = True
        self.process.send_signal(signal.SIGSTOP)

    def resume(self):
        if self.stalled:
            self.stalled = False
            self.process.send_signal(signal.SIGCONT)

    def last_lines(self):
        return pathlib.Path(f"{self.name}.log").read_text(errors="replace")[-700:]

    def unexpected_end(self):
        """How the process ended unexpectedly, or ""."""
        if self.down or self.process.poll() is None:
            return ""
        self.down = True
        return f"{self.name} ended with {self.process.returncode}: {self.last_lines()}"

    def wait_for_end(self, seconds):
        try:
            code = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.kill()
            return f"{self.name} does not end: {self.last_lines()}"
        return f"{self.name} ended with {code}: {self.last_lines()}" if code else ""

    def feeds(self):
        return isinstance(self.spec, dict) and ("send" in self.spec or "gate" in self.spec.get("pipeline", ""))

    def frames(self):
        """Frames that arrived, or if they arrive elsewhere, that left."""
        got, sent = (pathlib.Path(f"{self.name}.{kind}") for kind in ("got", "sent"))
        file = sent if "file" in self.spec else got
        return file.stat().st_size // RECORD_BYTES if file.exists() else 0

    def workers(self):
        return [pid for pid, name in children().get(self.process.pid, []) if name == "weir-worker"]

    def allocated(self):
        """As the process itself last reported it."""
        stats = pathlib.Path(f"{self.name}.stats")
        if not stats.exists():
            return ""
        with stats.open("rb") as file:
            file.seek(max(0, stats.stat().st_size - 100_000))
            lines = file.read().splitlines()
        return json.loads(lines[-1])["allocated"] // 1024 if lines and lines[-1].endswith(b"}") else ""

    def samples(self):
        if self.down:
            return
        for pid, name in [(self.process.pid, self.name), *((pid, f"{self.name}.worker") for pid in self.workers())]:
            if memory := memory_of(pid):
                yield {"process": name, "pid": pid, **memory, "allocated_kb": self.allocated() if name == self.name else "",
                       "frames": self.frames() if name == self.name else ""}

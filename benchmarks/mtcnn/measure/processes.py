# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs a program and samples it and its children."""

import dataclasses
import os
import pathlib
import subprocess
import threading
import time

EVERY = 0.1  # seconds between two samples
OURS = "mtcnn"  # prefix of the names of watched processes: excludes roslaunch and ROS's master


@dataclasses.dataclass
class Watched:
    seconds: float
    cpu_seconds: float
    peak_rss: float  # MB, sum over all processes; shared pages count for each
    mapped: float  # peak address space in MB
    threads: int
    samples: list  # (seconds since the first sample, resident MB)
    text: str  # stdout


@dataclasses.dataclass
class _Seen:
    cpu: float
    rss: float
    peak: float
    mapped: float
    threads: int


TICK = os.sysconf("SC_CLK_TCK")


def look(pid):
    """Reads the process from /proc; None once it has ended."""
    folder = pathlib.Path(f"/proc/{pid}")
    try:
        status = dict(line.split(":", 1) for line in (folder / "status").read_text().splitlines())
        fields = (folder / "stat").read_text().rsplit(") ", 1)[1].split()
        return _Seen((int(fields[11]) + int(fields[12])) / TICK, int(status["VmRSS"].split()[0]) / 1024,
                     int(status["VmHWM"].split()[0]) / 1024, int(status["VmPeak"].split()[0]) / 1024, int(status["Threads"]))
    except (OSError, ValueError, KeyError, IndexError):
        return None


def family(pid):
    """The process and its descendants, as far as they are ours."""
    try:
        name = pathlib.Path(f"/proc/{pid}/comm").read_text()
        children = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return []
    return ([pid] if name.startswith(OURS) else []) + [one for child in children for one in family(int(child))]


def watch(command, environment=None):
    """Returns Watched. SystemExit with the program's output if it fails."""
    begin = time.monotonic()
    child = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, text=True, env=environment)
    ended = threading.Event()
    cpu, peaks, samples, mapped, threads, rss = {}, {}, [], [0.0], [0], [0.0]

    def follow():
        while not ended.wait(EVERY):
            seen = {pid: one for pid in family(child.pid) if (one := look(pid))}
            cpu.update({pid: one.cpu for pid, one in seen.items()})
            peaks.update({pid: one.peak for pid, one in seen.items()})
            if seen:
                rss.append(sum(one.rss for one in seen.values()))
                samples.append((time.monotonic(), rss[-1]))
                mapped.append(sum(one.mapped for one in seen.values()))
                threads.append(sum(one.threads for one in seen.values()))

    watcher = threading.Thread(target=follow)
    watcher.start()
    text = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    seconds = time.monotonic() - begin
    child.returncode = os.waitstatus_to_exitcode(status)
    ended.set()
    watcher.join()
    if child.returncode:
        raise SystemExit(f"bench: {' '.join(map(str, command))} ended with {child.returncode}")
    alone = len(cpu) == 1  # then the system's accounting is exact
    # Not ru_maxrss: a child starts as a copy of this process and inherits its peak.
    return Watched(seconds, usage.ru_utime + usage.ru_stime if alone else sum(cpu.values()),
                   max(peaks.values()) if alone else max(rss), max(mapped), max(threads),
                   [(time - samples[0][0], value) for time, value in samples], text)

# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs a program and watches it and its children while it runs."""

import dataclasses
import os
import pathlib
import subprocess
import threading
import time

EVERY = 0.1  # seconds between two looks
OURS = "mtcnn"  # what the watched processes' names begin with: not roslaunch, not ROS's master


@dataclasses.dataclass
class Watched:
    seconds: float
    cpu_seconds: float
    peak_rss: float  # MB, of all processes together; pages that they share count for each
    mapped: float  # MB of address space, the most
    threads: int
    samples: list  # (seconds since the first of them, MB resident)
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
    """What /proc says of a process; None once it has ended."""
    folder = pathlib.Path(f"/proc/{pid}")
    try:
        status = dict(line.split(":", 1) for line in (folder / "status").read_text().splitlines())
        fields = (folder / "stat").read_text().rsplit(") ", 1)[1].split()
        return _Seen((int(fields[11]) + int(fields[12])) / TICK, int(status["VmRSS"].split()[0]) / 1024,
                     int(status["VmHWM"].split()[0]) / 1024, int(status["VmPeak"].split()[0]) / 1024, int(status["Threads"]))
    except (OSError, ValueError, KeyError, IndexError):
        return None


def family(pid):
    """The process and what it started, those of ours."""
    try:
        name = pathlib.Path(f"/proc/{pid}/comm").read_text()
        children = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return []
    return ([pid] if name.startswith(OURS) else []) + [one for child in children for one in family(int(child))]


def watch(command, environment=None):
    """Watched. SystemExit with its words where the program fails."""
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
    alone = len(cpu) == 1  # then the system's own account is exact
    # ru_maxrss would be this process's own where that is larger: a child begins as its copy.
    return Watched(seconds, usage.ru_utime + usage.ru_stime if alone else sum(cpu.values()),
                   max(peaks.values()) if alone else max(rss), max(mapped), max(threads),
                   [(time - samples[0][0], value) for time, value in samples], text)

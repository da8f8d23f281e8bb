# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plays a program whose results end with a zero byte each, and samples its process."""

import dataclasses
import os
import pathlib
import select
import subprocess
import time

import table

EVERY = 0.05  # seconds between two samples


@dataclasses.dataclass
class Sample:
    time: float
    cpu: float  # seconds of user and system time
    resident: float  # MB
    mapped: float  # MB, the most until now
    threads: int


@dataclasses.dataclass
class Seen:
    results: list  # the time of each
    samples: list  # Sample
    cpu: float  # between the first and the last result
    text: list  # the results


def cpu_seconds(pid):
    """User and system time of all threads of a process, in nanoseconds' steps: the clock of clock_getcpuclockid(3)."""
    return time.clock_gettime((~pid << 3) | 2)


def look(pid):
    """Reads the process from /proc and its clock; None once it has ended."""
    try:
        folder = pathlib.Path(f"/proc/{pid}")
        status = dict(line.split(":", 1) for line in (folder / "status").read_text().splitlines())
        return Sample(time.monotonic(), cpu_seconds(pid), int(status["VmRSS"].split()[0]) / 1024,
                      int(status["VmPeak"].split()[0]) / 1024, int(status["Threads"]))
    except (OSError, ValueError, KeyError, IndexError):
        return None


def play(command, environment):
    """Returns Seen. SystemExit if the program fails or has fewer than two results."""
    child = subprocess.Popen([str(word) for word in command], env=environment, stdout=subprocess.PIPE)
    pipe, samples, results, first, last, data = child.stdout.fileno(), [], [], None, None, b""
    due = time.monotonic()
    while True:
        ready = select.select([pipe], [], [], max(0, due - time.monotonic()))[0]
        if ready:
            some = os.read(pipe, 65536)
            if not some:
                break
            data += some
            if number := some.count(b"\0"):
                last = look(child.pid) or last
                first = first or last
                results += [time.monotonic()] * number
        if time.monotonic() >= due:
            due += EVERY
            if sample := look(child.pid):
                samples.append(sample)
    if child.wait() or len(results) < 2:
        raise SystemExit(f"bench: {command[0]} ended with {child.returncode} after {len(results)} results")
    return Seen(results, samples, last.cpu - first.cpu, data.decode().split("\0")[:-1])


def fast_rows(seen, frames_of_results):
    """The rows of a run with all frames at once; `frames_of_results`: frames of the input for each result after the first."""
    seconds = seen.results[-1] - seen.results[0]
    frames = frames_of_results * (len(seen.results) - 1)
    return {"output rate, frames per second": frames / seconds, "CPU share, %": 100 * seen.cpu / seconds,
            "rate per CPU, frames per CPU second": frames / seen.cpu,
            "mapped memory, MB": max(one.mapped for one in seen.samples),
            "resident memory, MB": max(one.resident for one in seen.samples), "threads": max(one.threads for one in seen.samples)}


def worker_rows(seen, frames_of_results, workers):
    """The rows of a run with all frames at once and several windows at once in the large networks."""
    rows = fast_rows(seen, frames_of_results)
    return {table.with_workers(name, workers): rows[name] for name in (table.RATE, table.CPU_RATE)}


def live_rows(seen):
    return {"CPU share at the sensor's rate, %": 100 * seen.cpu / (seen.results[-1] - seen.results[0])}

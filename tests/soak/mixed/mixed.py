#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs 16 mixed streams at once with random faults: mixed.py SECONDS FOLDER [SEED], in the environment of `meson devenv`.

Processes are killed and stalled, the broker too, and a small disk is full at times. FOLDER gets samples.csv (memory, descriptors and
threads of each process every ten seconds), faults.csv, ledger.csv, and the log of each process. Fails when a frame is missing that no
policy allows, when a stream or a process does not come back, when memory grows, or when descriptors or threads remain.
"""

import contextlib
import csv
import heapq
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

import ledger
import processes
import streams

DISK_BYTES = 4 << 20
SILENCE = 120  # seconds after which a stream does not come back


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def small_disk():
    """A folder with few bytes; None where no file system can be mounted."""
    with tempfile.TemporaryDirectory(prefix="soak-disk-") as folder:
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK_BYTES}", "soak", folder], capture_output=True, check=False)
        if mounted.returncode:
            print("mixed: no disk is full in this run, because only root can mount one:", mounted.stderr.decode().strip())
        try:
            yield pathlib.Path(folder), not mounted.returncode
        finally:
            if not mounted.returncode:
                subprocess.run(["umount", "--lazy", folder], check=False)


class Soak:
    def __init__(self, seconds, seed, disk, can_fill):
        self.seconds, self.disk, self.can_fill = seconds, disk, can_fill
        self.random = random.Random(seed)
        self.start = time.monotonic()
        self.due = []  # (time, number, function)
        self.busy = set()  # streams with a fault from which they have not recovered
        self.disk_full = False
        self.wrong = []
        self.samples, self.faults = [], []
        pathlib.Path("other.onnx").write_bytes(streams.DIGITS.read_bytes())
        pictures = [self.random.randbytes(192 * 32) for _ in range(4)]
        broker = free_port() if shutil.which("mosquitto") else None
        self.streams = {**streams.files(disk, pictures), **streams.live(pathlib.Path("other.onnx").absolute()),
                        **streams.links(free_port, broker), **streams.servers(free_port), **streams.isolated_models(disk)}
        if not broker:
            print("mixed: without mosquitto there are no streams through a broker: apt-get install mosquitto")
        self.processes = {(name, role): processes.Process(f"{name}.{role}", spec)
                          for name, stream in self.streams.items() for role, spec in stream.processes.items()}
        if broker:
            self.processes["", "broker"] = processes.Process("broker", ["mosquitto", "-p", str(broker)])

    def now(self):
        return time.monotonic() - self.start

    def at(self, seconds, function):
        heapq.heappush(self.due, (self.now() + seconds, len(self.faults) + len(self.samples) + self.random.random(), function))

    def log_fault(self, stream, role, kind, seconds):
        """The stream gets no other fault until frames arrive again."""
        fault = {"seconds": round(self.now(), 1), "ns": time.monotonic_ns(), "stream": stream, "process": role, "fault": kind,
                 "for": round(seconds, 1), "frames after": ""}
        self.faults.append(fault)
        if stream:
            self.busy.add(stream)
            self.at(seconds, lambda: self.recover(fault, self.frames(stream), self.now()))

    def recover(self, fault, frames, since):
        if self.frames(fault["stream"]) < frames + 20:
            self.at(0.5, lambda: self.recover(fault, frames, since))
            return
        fault["frames after"] = round(self.now() - since, 1)
        self.busy.discard(fault["stream"])

    def frames(self, stream):
        return sum(process.frames() for (name, _), process in self.processes.items() if name == stream)

    def inject(self, stream, role, kind):
        """One fault, and when it ends."""
        if kind == "disk":
            stream, seconds = "", self.random.uniform(2, 8)
            if self.disk_full or not self.can_fill:
                return
            self.disk_full = True
            self.at(seconds, self.free_disk)
        elif role == "worker":
            seconds = self.random.uniform(2, 5)
            owner = next(process for (name, _), process in self.processes.items() if name == stream)
            pids = owner.workers()
            if not pids:
                return
            processes.signal_pid(pids[0], signal.SIGKILL if kind == "kill" else signal.SIGSTOP)  # Weir kills the one that hangs
        else:
            process = self.processes["" if role == "broker" else stream, role]
            seconds = self.random.uniform(1, 6)
            if process.down or process.stalled:
                return
            if kind == "stall":
                process.stall()
                self.at(seconds, process.resume)
            else:
                process.end(signal.SIGTERM if kind == "stop" else signal.SIGKILL)
                self.at(seconds, process.start)
        self.log_fault(stream, role, kind, seconds)

    def free_disk(self):
        self.disk_full = False
        (self.disk / "full").unlink(missing_ok=True)

    def fill_disk(self):
        with contextlib.suppress(OSError), open(self.disk / "full", "ab", buffering=0) as file:
            while True:
                file.write(bytes(4096))

    def sample(self):
        now = round(self.now(), 1)
        self.samples += [{"seconds": now, **row} for process in self.processes.values() for row in process.samples()]
        for name, stream in self.streams.items():
            moved = self.frames(name)
            if moved != getattr(stream, "moved", None):
                stream.moved, stream.moved_at = moved, self.now()
            elif self.now() - stream.moved_at > SILENCE:
                self.wrong.append(f"{name}: no frame for {SILENCE} seconds, at {self.now():.0f} s")
                stream.moved_at = self.now()
        return now

    def run_until(self, end, tick=0.2):
        """What is due, a full disk that stays full, and processes that ended unexpectedly."""
        while self.now() < end:
            while self.due and self.due[0][0] <= self.now():
                heapq.heappop(self.due)[2]()
            if self.disk_full:
                self.fill_disk()
            for process in self.processes.values():
                if text := process.unexpected_end():
                    self.wrong.append(f"at {self.now():.0f} s: {text}")
                    self.at(2, process.start)
            time.sleep(tick)

    def each_fault_once(self, until):
        """Part of warming up, because some threads and tables are made when they are needed first."""
        every = list(dict.fromkeys((name if role else "", role, kind) for name, stream in self.streams.items()
                                   for role, kind in stream.faults))
        pause = (until - self.now()) / len(every)
        for fault in every:
            self.recovered([fault[0]])
            self.inject(*fault)
            self.run_until(self.now() + pause)

    def random_faults(self, until, spacing):
        every = [(name, role, kind) for name, stream in self.streams.items() for role, kind in stream.faults]
        while self.now() < until:
            self.run_until(min(until, self.now() + self.random.expovariate(1 / spacing)))
            stream, role, kind = self.random.choice(every)
            if stream not in self.busy:
                self.inject(stream, role, kind)

    def calm(self, seconds):
        """A time without faults after all have recovered: its first and last sample."""
        self.recovered(self.streams)
        self.run_until(self.now() + 2)
        begin = self.sample()
        self.run_until(self.now() + seconds)
        return begin, self.sample()

    def recovered(self, names):
        """Waits until these streams have frames again."""
        give_up = self.now() + SILENCE
        while (self.disk_full or self.busy.intersection(names)) and self.now() < give_up:
            self.run_until(self.now() + 0.5)
        self.wrong += [f"{name}: no frames after a fault, at {self.now():.0f} s" for name in self.busy.intersection(names)]

    def sample_regularly(self, every):
        self.sample()
        self.at(every, lambda: self.sample_regularly(every))

    def play(self):
        """The two times without faults that are compared: after warming up, and at the end."""
        for process in self.processes.values():
            process.start()
        quiet = max(25, min(60, self.seconds / 12))  # GLib ends idle threads after 15 seconds
        self.at(5, lambda: self.sample_regularly(min(10, max(2, self.seconds / 60))))
        self.run_until(quiet)
        self.each_fault_once(self.seconds / 4 if self.seconds < 1200 else 360)
        warm = self.calm(quiet)
        self.random_faults(max(self.now() + 1, self.seconds - quiet), min(8, max(1, self.seconds / 60)))
        end = self.calm(quiet)
        senders = [process for process in self.processes.values() if process.feeds()]
        for some in (senders, [process for process in self.processes.values() if process not in senders]):
            for process in some:
                process.end(signal.SIGTERM, wait=False)
            for process in some:
                if text := process.wait_for_end(90):
                    self.wrong.append(text)
            self.drain()
        return warm, end

    def drain(self):
        """Until the receivers have what was sent, or nothing more comes."""
        def arrived():
            return sum(process.frames() for process in self.processes.values())
        before = -1
        while before != arrived():
            before = arrived()
            time.sleep(3)


def write_table(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    os.chdir(folder)
    with small_disk() as (disk, can_fill):
        soak = Soak(float(sys.argv[1]), int((sys.argv[3:] or ["1"])[0]), disk, can_fill)
        try:
            warm, end = soak.play()
        finally:
            for process in soak.processes.values():
                process.kill()
    write_table("samples.csv", soak.samples)
    write_table("faults.csv", soak.faults)
    rows = [ledger.account(name, stream, soak.faults) for name, stream in soak.streams.items()]
    write_table("ledger.csv", rows)
    wrong = soak.wrong + [f"{row['stream']}: {row['wrong']}" for row in rows if row["wrong"]]
    wrong += ledger.compare(soak.samples, warm, end)
    grown = ledger.growth(soak.samples, warm[1], "anon_kb")
    pathlib.Path("summary.json").write_text(json.dumps({"warm": warm, "end": end, "growth_kb_per_hour": grown, "wrong": wrong}, indent=1))
    ledger.print_table(rows)
    for name, kilobytes in grown.items():
        print(f"{name}: {kilobytes:+.0f} KB an hour")
    print(f"{len(soak.faults)} faults in {soak.seconds:.0f} seconds; {len(wrong)} things are wrong", *wrong, sep="\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

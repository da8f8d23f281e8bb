#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws what the soak test measured: curves.py RUN FOLDER. RUN is the folder of mixed.py. Writes FOLDER/soak-{memory,counts,frames}.png and
their data as .csv, a row each half minute. Needs gnuplot."""

import csv
import json
import pathlib
import shutil
import subprocess
import sys

EVERY = 30  # seconds


def in_periods(samples, column):
    """{period: {process: (seconds, value) of its last sample}}, of the processes themselves and not their workers."""
    found = {}
    for row in samples:
        if row[column] and not row["process"].endswith(".worker"):
            seconds = float(row["seconds"])
            found.setdefault(int(seconds / EVERY), {})[row["process"]] = (seconds, float(row[column]))
    return found


def memory(samples, warm):
    """Of the processes that were never killed, the difference to the end of warming up."""
    pids = {}
    for row in samples:
        pids.setdefault(row["process"], set()).add(row["pid"])
    names = [name for name, seen in pids.items() if len(seen) == 1 and not name.endswith(".worker")]
    periods = in_periods(samples, "anon_kb")
    first = periods[int(warm / EVERY)]
    return names, {period: [(values[name][1] - first[name][1]) / 1024 if name in values else "" for name in names]
                   for period, values in periods.items()}


def counts(samples):
    kinds = ("descriptors", "threads")
    periods = [in_periods(samples, kind) for kind in kinds]
    return kinds, {period: [sum(value for _, value in kind[period].values()) for kind in periods] for period in periods[0]}


def frames(samples, faults):
    """Frames a second of all streams together, and the faults of each period."""
    arrived = in_periods(samples, "frames")

    def rate(before, after):
        return sum((after[name][1] - before[name][1]) / (after[name][0] - before[name][0]) for name in before.keys() & after.keys())
    return ("frames per second", f"faults in {EVERY} s"), {
        period: [rate(arrived[period - 1], values), sum(int(float(fault["seconds"]) / EVERY) == period for fault in faults)]
        for period, values in arrived.items() if period - 1 in arrived}


def draw(path, columns, rows, title, y_name, y_range="0:*"):
    numbers = path.with_suffix(".csv")
    with numbers.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["minutes", *columns])
        for period, values in sorted(rows.items()):
            table.writerow([round(period * EVERY / 60, 1), *(round(value, 2) if value != "" else "" for value in values)])
    # Two kinds of lines, because colours repeat after eight.
    curves = ", ".join(f"'{numbers}' using 1:{column} with lines lw 2 dashtype {1 + (column - 2) // 8} title columnheader"
                       for column in range(2, len(columns) + 2))
    script = f"""set terminal pngcairo size 1000,520 font 'DejaVu Sans,11' noenhanced
set output '{path.with_suffix(".png")}'
set datafile separator ','
set title "{title}"
set xlabel "minutes"
set ylabel "{y_name}"
set yrange [{y_range}]
set grid
set key outside right
plot {curves}
"""
    subprocess.run(["gnuplot"], input=script, text=True, check=True)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    if not shutil.which("gnuplot"):
        sys.exit("curves: gnuplot is not there: apt-get install gnuplot-nox")
    run, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    samples, faults = ([*csv.DictReader((run / name).read_text().splitlines())] for name in ("samples.csv", "faults.csv"))
    warm = json.loads((run / "summary.json").read_text())["warm"][1]
    draw(folder / "soak-memory", *memory(samples, warm), "Anonymous memory of each process that was never killed, since warming up", "MiB", "-4:4")
    draw(folder / "soak-counts", *counts(samples), "Descriptors and threads of all processes together", "number")
    draw(folder / "soak-frames", *frames(samples, faults), "Frames that arrived in all streams together, and faults", "number")


if __name__ == "__main__":
    main()

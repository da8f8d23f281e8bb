# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the soak test checks at its end: each frame is accounted for, and no process has grown."""

import json
import math
import pathlib
import struct

RECORD = struct.Struct("<qq")
NEAR = 5_000_000_000  # nanoseconds between a kill and the last frame before it that may still arrive
MAX_GROWTH = 4096  # kilobytes an hour, of a process that lives for at least half an hour after warming up


def records(path):
    """(number, nanoseconds) of each frame; the last one of a killed process is whole, because it is one write()."""
    return list(RECORD.iter_unpack(path.read_bytes())) if path.exists() else []


def reports(name):
    """The last line that each pipeline wrote, and the errors that ended pipelines."""
    last, errors = {}, []
    for path in sorted(pathlib.Path().glob(f"{name}.*.stats")):
        for line in path.read_text().splitlines():
            try:
                report = json.loads(line)
            except json.JSONDecodeError:
                continue  # its process was killed while it wrote
            last[path.stem, report["pid"], report["run"]] = report
            if "error" in report:
                errors.append(report["time"])
    return list(last.values()), errors


def total(all_reports, counters):
    return sum(report["stats"].get(element, {}).get(counter, 0) for report in all_reports for element, counter in counters)


def unbalanced(all_reports):
    """Elements whose own ledger does not add up at the end."""
    return [f"{element}: {one}" for report in all_reports if report.get("final") for element, one in report["stats"].items()
            if "received" in one and one["received"] != one["consumed"] + one["dropped"] + one["held"]]


def missing_frames(sent, got, breaks):
    """(missing without a break, missing around one, repeated), from the numbers that arrived, in their order."""
    plain = broken = repeated = 0
    last, last_time = -1, -math.inf
    for number, when in [*got, (sent, math.inf)]:
        if number <= last:
            repeated += 1
            continue
        if number > last + 1:
            if last < 0 or any(last_time - NEAR <= one <= when for one in breaks):
                broken += number - last - 1
            else:
                plain += number - last - 1
        last, last_time = number, when
    return plain, broken, repeated


def account(name, stream, faults):
    """The row of a stream: what went in, what came out, what is lost and why."""
    all_reports, errors = reports(name)
    counted = total(all_reports, stream.counted)
    if stream.through:
        first, out, ratio = stream.through
        sent, got = total(all_reports, [(first, "consumed")]) // ratio, total(all_reports, [(out, "received")])
        plain, broken, repeated = sent - got, 0, 0
    else:
        breaks = errors + [fault["ns"] for fault in faults if fault["fault"] in ("kill", "stop") and fault["process"] != "worker"
                           and (fault["stream"] == name or fault["process"] == "broker")]
        sent_frames = [one for path in pathlib.Path().glob(f"{name}.*.sent") for one in records(path)]
        got_frames = [one for path in pathlib.Path().glob(f"{name}.*.got") for one in records(path)]
        sent, got = len(sent_frames) or len(got_frames), len(got_frames)
        plain, broken, repeated = missing_frames(sent, got_frames, breaks) if sent_frames else (0, 0, 0)
    wrong = unbalanced(all_reports)
    if plain > counted:
        wrong.append(f"{plain} frames are missing without a kill, and the elements counted {counted}")
    if stream.exact and plain + broken != counted:
        wrong.append(f"{plain + broken} frames are missing, and the elements counted {counted}")
    if plain < 0 or (repeated and not stream.repeats):
        wrong.append(f"{repeated or -plain} frames arrived twice or out of order")
    return {"stream": name, "faults": sum(fault["stream"] == name for fault in faults), "sent": sent, "arrived": got - repeated,
            "lost with a process": broken, "lost by policy": plain, "counted": counted, "repeated": repeated,
            "unaccounted": abs(plain + broken - counted) if stream.exact else max(0, plain - counted), "wrong": "; ".join(wrong)}


def slope(points):
    """Least squares."""
    n = len(points)
    mean_x, mean_y = (sum(point[i] for point in points) / n for i in (0, 1))
    spread = sum((x - mean_x) ** 2 for x, _ in points)
    return sum((x - mean_x) * (y - mean_y) for x, y in points) / spread if spread else 0


def growth(samples, warm, column):
    """Kilobytes an hour of each process that lives long enough."""
    of = {}
    for row in samples:
        if row["seconds"] >= warm and row[column] != "":
            of.setdefault((row["process"], row["pid"]), []).append((row["seconds"], row[column]))
    return {name: slope(points) * 3600 for (name, _), points in of.items() if points[-1][0] - points[0][0] >= 1800}


def counts(samples, column, begin, end):
    """(fewest, most) of each process in this time. Both, because a paused pipeline has fewer descriptors than one that plays."""
    of = {}
    for row in samples:
        if begin <= row["seconds"] <= end:
            of.setdefault(row["process"], []).append(row[column])
    return {name: (min(values), max(values)) for name, values in of.items()}


def compare(samples, warm, end):
    """What is wrong at the end."""
    wrong = [f"{name}: {column} grows by {kilobytes:.0f} KB an hour, at most {MAX_GROWTH} may be"
             for column in ("anon_kb", "allocated_kb") for name, kilobytes in growth(samples, warm[1], column).items()
             if kilobytes > MAX_GROWTH]
    for column in ("descriptors", "threads"):
        before, after = (counts(samples, column, *times) for times in (warm, end))
        wrong += [f"{name}: {after[name][0]} {column} at the end, {before[name][1]} after warming up"
                  for name in before.keys() & after.keys() if after[name][0] > before[name][1]]
        wrong += [f"{name} is missing at the end" for name in before.keys() - after.keys()]
    return wrong


def print_table(rows):
    columns = [column for column in rows[0] if column != "wrong"]
    print("  ".join(columns))
    for row in rows:
        print("  ".join(f"{row[column]:>{len(column)}}" for column in columns))

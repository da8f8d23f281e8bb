# SPDX-License-Identifier: LGPL-2.1-or-later
"""Formats the results as Markdown."""

import lines
import numbers_of as numbers
import parts

NAMES = {"weir": "Weir", "kernels": "Weir, own kernels", "control": "control", "ros": "three ROS nodes"}
FLOORS = {"onnxruntime": "floor", "mtcnn-kernels": "floor of own kernels"}


def number(value):
    return f"{value:.4g}" if abs(value) < 10000 else f"{value:.0f}"


def words(rounds, floor):
    """Median, minimum and maximum, percentage of the floor."""
    if not rounds:
        return "-"
    median, least, most = numbers.middle(rounds)
    text = number(median) + (f" ({number(least)} to {number(most)})" if len(rounds) > 1 else "")
    share = numbers.of_floor(median, floor)
    return text + (f"; {share:.0f} %" if share is not None else "")


def gathered(results):
    """Returns {row: {program: [a number per round]}} of all measured parts, in their order."""
    rows = {}
    for part in ("fast", "latency", "live", "memory"):
        for who, rounds in results.get(part, {}).items():
            once = {}
            if part == "latency":
                rounds, once, _ = parts.of_latencies(rounds)
            for one in rounds:
                for name, value in one.items():
                    if name != "samples":
                        rows.setdefault(name, {}).setdefault(who, []).append(value)
            for name, value in once.items():
                rows.setdefault(name, {})[who] = [value]
    if any(label in one for rounds in results.get("floor", {}).values() for one in rounds for label in parts.DECODES.values()):
        rows = {key: row for name, row in rows.items() for key in (name, parts.DECODES.get(name, name))}
    return rows


def floors(results):
    """Returns {engine: {row: its floor, the median of its rounds}}."""
    out = {}
    for engine, rounds in results.get("floor", {}).items():
        medians, once, _ = parts.of_latencies(rounds)
        whole = [{**one, **latencies} for one, latencies in zip(rounds, medians)]
        out[engine] = once | {name: numbers.middle([one[name] for one in whole])[0] for name in whole[0] if name != "pictures"}
    return out


def get_floor(floor, who):
    """Returns {row: the floor of a program's engine}."""
    return floor.get("mtcnn-kernels" if who == "kernels" else "onnxruntime", {})


def ratio(row, who, other):
    if not row.get(who) or not row.get(other):
        return "-"
    below = numbers.middle(row[other])[0]
    return f"{numbers.middle(row[who])[0] / below:.2f}" if below else "-"


def measured(results):
    rows, floor = gathered(results), floors(results)
    who = [one for one in NAMES if any(one in row for row in rows.values())]
    pairs = [(one, other) for other in who if other not in parts.WEIR for one in who if one in parts.WEIR]
    head = ["", *(NAMES[one] for one in who), *(FLOORS[engine] for engine in floor), *(f"{NAMES[one]} / {NAMES[other]}" for one, other in pairs)]
    out = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for name, row in rows.items():
        cells = [name, *(words(row.get(one, []), get_floor(floor, one).get(name)) for one in who),
                 *(number(one[name]) if name in one else "-" for one in floor.values()), *(ratio(row, *pair) for pair in pairs)]
        out.append("| " + " | ".join(cells) + " |")
    return out


def counted():
    all_parts, columns = lines.by_part(), [one for one in NAMES if one != "kernels"]  # an engine's lines are not the program's
    out = ["| lines of code | " + " | ".join(NAMES[one] for one in columns) + " |", "|---|" + "---|" * len(columns)]
    for part, who, count in all_parts:
        out.append(f"| {part} | " + " | ".join(str(count) if one in who else "-" for one in columns) + " |")
    sums = [sum(count for _, who, count in all_parts if one in who) for one in columns]
    return [*out, "| together | " + " | ".join(map(str, sums)) + " |"]


def markdown(results):
    pooled = [f"{parts.of_latencies(rounds)[2]} ({NAMES[who]})" for who, rounds in results.get("latency", {}).items()]
    note = ["", f"{results['machine']}; {results['clip']}. Medians (least to most of the rounds); a percentage is of the floor of the program's engine."]
    if pooled:
        note.append(f"Pictures behind the p99, or the slowest of fewer than 100: {', '.join(pooled)}.")
    return "\n".join([*measured(results), *note, "", *counted()]) + "\n"

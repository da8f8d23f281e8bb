# SPDX-License-Identifier: LGPL-2.1-or-later
"""The results of examples/ars/bench as Markdown, and as a plot for gnuplot."""

import math
import statistics
import subprocess

RATE, CPU_RATE = "output rate, frames per second", "rate per CPU, frames per CPU second"


def spread(values):
    middle, least, most = statistics.median(values), min(values), max(values)
    return number(middle) if len(values) == 1 else f"{number(middle)} ({number(least)} to {number(most)})"


def number(value):
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def ratio(rounds, name):
    """Weir's median over the control's; nan where one was not measured."""
    ours, theirs = ([one[name] for one in rounds.get(who, []) if name in one] for who in ("weir", "control"))
    return statistics.median(ours) / statistics.median(theirs) if ours and theirs and statistics.median(theirs) else math.nan


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(value) for value in values))


def rows_of(variant, rounds):
    """`rounds`: {"weir": [{row: value}], "control": ..., "bare": ...} of one variant."""
    out = []
    for name in rounds["weir"][0]:
        cells = [spread([one[name] for one in rounds[who] if name in one]) for who in ("weir", "control")]
        bare = [one[name] for one in rounds["bare"] if name in one]
        share = f"{100 * statistics.median(one[name] for one in rounds['weir']) / statistics.median(bare):.0f} %" if bare else "-"
        out.append(f"| {variant.upper()}: {name} | {' | '.join(cells)} | {spread(bare) if bare else '-'} | {share} | {ratio(rounds, name):.2f} |")
    return out


def markdown(results, code_lines):
    """`results`: {variant: rounds}; `code_lines`: {variant: (ours, the control's)}."""
    out = ["| | Weir | control | bare engine | Weir / bare | Weir / control |", "|---|---|---|---|---|---|"]
    for variant, rounds in results.items():
        ours, theirs = code_lines[variant]
        out += [f"| {variant.upper()}: lines of code | {ours} | {theirs} | - | - | {ours / theirs:.2f} |", *rows_of(variant, rounds)]
    out.append("")
    for name in (RATE, CPU_RATE):
        mean = geometric_mean([ratio(rounds, name) for rounds in results.values()])
        out.append(f"{name[0].upper()}{name[1:]}: {mean:.2f} times the control's in the geometric mean.")
    return "\n".join(out) + "\n"


def plot(samples, path):
    """CPU, threads and memory over time of a run: `samples` is {name: [Sample]}."""
    head = [f"set terminal pngcairo size 900,700 font 'DejaVu Sans,10' noenhanced", f"set output '{path}'", "set multiplot layout 3,1",
            "set grid ytics", "set key outside right top", "set yrange [0:]"]
    for who, of_run in samples.items():
        begin = of_run[0].time
        head.append(f"${who} << E")
        for before, one in zip(of_run, of_run[4:]):
            share = 100 * (one.cpu - before.cpu) / (one.time - before.time)
            head.append(f"{one.time - begin:.2f} {share:.1f} {one.threads} {one.resident:.1f}")
        head.append("E")
    for column, label in ((2, "CPU, %"), (3, "threads"), (4, "MB resident")):
        head += [f"set ylabel '{label}'", *(["set xlabel 'seconds'"] if column == 4 else []),
                 "plot " + ", ".join(f"${who} using 1:{column} with lines lw 2 title '{who}'" for who in samples)]
    subprocess.run(["gnuplot"], input="\n".join(head) + "\n", text=True, check=True)

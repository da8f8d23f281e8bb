# SPDX-License-Identifier: LGPL-2.1-or-later
"""The results of benchmarks/ars/bench as Markdown, and as a plot for gnuplot."""

import math
import statistics
import subprocess

RATE, CPU_RATE = "output rate, frames per second", "rate per CPU, frames per CPU second"
LIVE, RESIDENT = "CPU share at the sensor's rate, %", "resident memory, MB"


def with_workers(row, workers):
    """The row of the same with several windows at once in the large networks."""
    what, unit = row.split(", ")
    return f"{what} with {workers} workers, {unit}"


def spread(values):
    middle, least, most = statistics.median(values), min(values), max(values)
    return number(middle) if len(values) == 1 else f"{number(middle)} ({number(least)} to {number(most)})"


def number(value):
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def median(rounds, who, name):
    """Of the rounds of one program; nan where the row was not measured."""
    values = [one[name] for one in rounds.get(who, []) if name in one]
    return statistics.median(values) if values else math.nan


def ratio(rounds, name, over="control", name_over=None):
    """Weir's median over the other program's; nan where one was not measured."""
    theirs = median(rounds, over, name_over or name)
    return median(rounds, "weir", name) / theirs if theirs else math.nan


def geometric_mean(values):
    return math.exp(statistics.fmean(math.log(value) for value in values))


def make_rows(variant, rounds):
    """`rounds`: {"weir": [{row: value}], "control": ..., "bare": ...} of one variant."""
    out = []
    for name in rounds["weir"][0]:
        cells = [spread([one[name] for one in rounds[who] if name in one]) for who in ("weir", "control")]
        bare = [one[name] for one in rounds["bare"] if name in one]
        share = f"{100 * statistics.median(one[name] for one in rounds['weir']) / statistics.median(bare):.0f} %" if bare else "-"
        out.append(f"| {variant.upper()}: {name} | {' | '.join(cells)} | {spread(bare) if bare else '-'} | {share} | {ratio(rounds, name):.2f} |")
    return out


def targets(results, workers):
    """What the example aims at, and what was reached: a table."""
    at_once = with_workers(RATE, workers)

    def of_each(value, form="{:.2f}"):
        return ", ".join(f"{variant.upper()} {form.format(value(rounds))}" for variant, rounds in results.items())

    def mean(*names):
        values = {variant: ratio(rounds, *names) for variant, rounds in results.items()}
        return f"{geometric_mean(values.values()):.2f} ({of_each(lambda rounds: ratio(rounds, *names))})"

    def above_bare(rounds):
        ours, theirs, bare = (median(rounds, who, RESIDENT) for who in ("weir", "control", "bare"))
        return (ours - bare) / (theirs - bare)

    rows = (("output rate at least 1.66 times the control's, geometric mean", mean(RATE)),
            (f"the same, with {workers} workers in both programs", mean(at_once)),
            (f"the same, with {workers} workers in Weir (a property) and one thread in the control", mean(at_once, "control", RATE)),
            ("rate per CPU at least 1.75 times the control's, geometric mean", mean(CPU_RATE)),
            ("output rate at least 95 % of the bare engine's", of_each(lambda rounds: 100 * ratio(rounds, RATE, "bare"), "{:.0f} %")),
            ("the same by CPU time", of_each(lambda rounds: 100 * ratio(rounds, CPU_RATE, "bare"), "{:.0f} %")),
            ("resident memory above the bare engine's at most 0.7 times the control's", of_each(above_bare)),
            ("CPU at the sensor's rate at most 0.5 times the control's", of_each(lambda rounds: ratio(rounds, LIVE))))
    return ["| target | reached |", "|---|---|", *(f"| {target} | {reached} |" for target, reached in rows)]


def costs(results, frames_of_result):
    """The CPU time of a result by what takes it: a table. A pipeline that cost nothing would reach the last column."""
    out = ["| CPU time of a result, ms | bare engine | the rest of Weir | the rest of the control | most that Weir / control can be by CPU |",
           "|---|---|---|---|---|"]
    for variant, rounds in results.items():
        bare, ours, theirs = (1000 * frames_of_result[variant] / median(rounds, who, CPU_RATE) for who in ("bare", "weir", "control"))
        out.append(f"| {variant.upper()} | {bare:.3f} | {ours - bare:.3f} | {theirs - bare:.3f} | {theirs / bare:.2f} |")
    return out


def markdown(results, code_lines, frames_of_result, workers):
    """`results`: {variant: rounds}; `code_lines`: {variant: (ours, the control's)}."""
    out = ["| | Weir | control | bare engine | Weir / bare | Weir / control |", "|---|---|---|---|---|---|"]
    for variant, rounds in results.items():
        ours, theirs = code_lines[variant]
        out += [f"| {variant.upper()}: lines of code | {ours} | {theirs} | - | - | {ours / theirs:.2f} |", *make_rows(variant, rounds)]
    return "\n".join([*out, "", *targets(results, workers), "", *costs(results, frames_of_result)]) + "\n"


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

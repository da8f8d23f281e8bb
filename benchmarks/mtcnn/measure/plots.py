# SPDX-License-Identifier: LGPL-2.1-or-later
"""Draws the results with gnuplot."""

import subprocess

import numbers_of as numbers
import parts
import table

COLOURS = {"weir": "#1f5f9f", "kernels": "#30a060", "control": "#d08020", "ros": "#808080"}
FLOORS = {"onnxruntime": ("#b00020", "ONNX Runtime alone"), "mtcnn-kernels": ("#006020", "own kernels alone")}


def draw(path, title, commands):
    head = ["set terminal pngcairo size 900,420 font 'DejaVu Sans,10' noenhanced", f"set output '{path}'", f"set title '{title}'",
            "set grid ytics", "set key outside right top"]
    subprocess.run(["gnuplot"], input="\n".join([*head, *commands]) + "\n", text=True, check=True)


def block(name, rows):
    return [f"${name} << E", *(" ".join(str(word) for word in row) for row in rows), "E"]


def bars(path, title, unit, rows, names, floor):
    """One group of bars per row: the programs with minimum and maximum, and the floors as lines across."""
    who = [one for one in table.NAMES if any(one in rows.get(name, {}) for name in names)]
    commands, plots = ["set style fill solid 0.85", f"set ylabel '{unit}'", "set yrange [0:]", "set offsets 0, 0, graph 0.1, 0",
                       f"set boxwidth {0.9 / (len(who) + 1):.3f}",
                       f"set xrange [-0.6:{len(names) - 0.4}]"], []
    ticks = ", ".join(f"'{name.removesuffix(', ms')}' {place}" for place, name in enumerate(names))
    commands.append(f"set xtics ({ticks})")
    for turn, one in enumerate(who):
        data = [(place + (turn - (len(who) - 1) / 2) * 0.9 / (len(who) + 0.7), *numbers.middle(rows[name][one]))
                for place, name in enumerate(names) if one in rows.get(name, {})]
        commands += block(one, data)
        plots += [f"${one} using 1:2 with boxes lc rgb '{COLOURS[one]}' title '{table.NAMES[one]}'",
                  f"${one} using 1:2:3:4 with yerrorbars lc rgb 'black' pt 0 ps 0 lw 1.5 notitle"]
    for turn, (engine, of_rows) in enumerate(floor.items()):
        colour, title_of = FLOORS[engine]
        known = [(place, of_rows[name]) for place, name in enumerate(names) if name in of_rows]
        if not known:
            continue
        commands += block(f"floor{turn}", known)
        plots.append(f"$floor{turn} using 1:2:(0.45) with xerrorbars lc rgb '{colour}' lw 2 pt 0 title '{title_of}'")
    draw(path, title, [*commands, "plot " + ", ".join(plots)])


def memory(path, results):
    commands, plots = ["set xlabel 'seconds'", "set ylabel 'MB resident'", "set yrange [0:]"], []
    for who, rounds in results.items():
        commands += block(who, rounds[-1]["samples"])
        plots.append(f"${who} using 1:2 with lines lw 2 lc rgb '{COLOURS[who]}' title '{table.NAMES[who]}'")
    draw(path, "Resident memory, 30 pictures of 1920x1080 a second", [*commands, "plot " + ", ".join(plots)])


def all_plots(results, folder):
    """Draws the parts that were measured; returns the paths of the pictures."""
    rows, floor, made = table.gathered(results), table.floors(results), []
    if results.get("latency"):
        made.append(folder / "mtcnn-latency.png")
        bars(made[-1], "Latency, one picture a second", "ms", rows, ["latency, ms", *(f"{name}, ms" for name in parts.STAGES)], floor)
    rates = [name for name in ("pictures per second", "results per second at 30", "display: pictures per second") if name in rows]
    if rates:
        made.append(folder / "mtcnn-rate.png")
        bars(made[-1], "Rates, 1920x1080", "pictures per second", rows, rates, floor)
    if results.get("memory"):
        made.append(folder / "mtcnn-memory.png")
        memory(made[-1], results["memory"])
    return made

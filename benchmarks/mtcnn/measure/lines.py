# SPDX-License-Identifier: LGPL-2.1-or-later
"""Counts lines of code by part.

A line counts if anything remains after removing comments (// and /* */ of C++, # of messages, <!-- --> of XML).
Command line options and time measurement count. Build files, tests, this folder and the floors do not.
"""

import pathlib
import re

HERE = pathlib.Path(__file__).resolve().parent.parent
EXAMPLE = HERE.parents[1] / "examples/mtcnn"
COMMENTS = {".cpp": r"/\*.*?\*/|//[^\n]*", ".hpp": r"/\*.*?\*/|//[^\n]*", ".launch": r"<!--.*?-->", ".msg": r"#[^\n]*"}
PARTS = {  # which program needs it: weir, control, ros; files of the example if weir does, else of this benchmark
    "MTCNN's arithmetic": ("cascade.cpp cascade.hpp", "weir control ros"),
    "faces as text, times of the stages": ("faces_text.cpp faces_text.hpp stage_times.cpp stage_times.hpp", "weir control ros"),
    "the three networks as filters": ("filters.cpp filters.hpp", "weir"),
    "the pipeline's text, four formats": ("line.cpp line.hpp", "weir"),
    "the program": ("mtcnn.cpp copied_bytes.cpp copied_bytes.hpp", "weir"),
    "networks, resizing, batches by hand": ("network.hpp stages.cpp stages.hpp", "control ros"),
    "pictures of a file": ("pictures.cpp pictures.hpp", "control ros"),
    "the loop": ("control.cpp", "control"),
    "nodes, messages, launch file": ("ros/parts.cpp ros/parts.hpp ros/node.hpp ros/camera.cpp "
                                     "ros/p_node.cpp ros/r_node.cpp ros/o_node.cpp ros/mtcnn.launch ros/mtcnn_control/Regions.msg "
                                     "ros/mtcnn_control/Faces.msg", "ros"),
}


def of_text(text, suffix):
    return sum(1 for line in re.sub(COMMENTS[suffix], "", text, flags=re.DOTALL).splitlines() if line.strip())


def of_files(names, folder):
    return sum(of_text((folder / name).read_text(), pathlib.Path(name).suffix) for name in names.split())


def by_part():
    """Returns [(part, program that needs it, lines)]."""
    return [(part, who.split(), of_files(names, EXAMPLE if "weir" in who else HERE)) for part, (names, who) in PARTS.items()]

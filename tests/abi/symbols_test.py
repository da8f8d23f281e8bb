#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tests the exports of built objects: only weir_module_entry for modules, GStreamer's entry points for the plug-in, and for
libraries the list next to this file. Programs were linked with it, so removing a name requires a new soname."""

import pathlib
import subprocess
import sys

PLUGIN = ["gst_plugin_weir_get_desc", "gst_plugin_weir_register"]
failed = 0


def read(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def wanted_of(name):
    """The symbols that an object with this file name should export."""
    if name.startswith("libgst"):
        return PLUGIN
    library = pathlib.Path(__file__).with_name(name.partition(".")[0] + ".symbols")
    if name.startswith("libcapi-ml-"):
        return []  # another name of libcapi-nnstreamer, which it loads
    return library.read_text().split() if library.exists() else ["weir_module_entry"]


for path in sys.argv[1:]:
    name = pathlib.Path(path).name
    lines = read("nm", "-D", "--defined-only", "--format=posix", path).splitlines()
    symbols = sorted(line.split()[0] for line in lines if line.split()[1] != "A")
    wanted = wanted_of(name)
    if symbols != wanted:
        failed += 1
        print(f"FAILED {name}: missing {sorted(set(wanted) - set(symbols))}, more {sorted(set(symbols) - set(wanted))}")
    needed = "libweir.so.0" in read("readelf", "-d", path)
    # libweir.so contains its own name.
    if needed != name.startswith(("libgst", "libweir.so", "libweir-pipeline", "libnnstreamer.so", "libcapi-nnstreamer")):
        failed += 1
        print(f"FAILED {name}: {'does' if needed else 'does not'} name libweir.so.0")
    # The soname does not depend on the release, so programs of an earlier release find the library.
    library = name.partition(".")[0]
    number = {"libweir": 0, "libweir-pipeline": 0, "libcapi-nnstreamer": 1, "libcapi-ml-common": 1,
              "libcapi-ml-inference-single": 1}.get(library)
    if number is not None and f"soname: [{library}.so.{number}]" not in read("readelf", "-d", path):
        failed += 1
        print(f"FAILED {name}: its soname is not {library}.so.{number}")
print(f"{len(sys.argv) - 1} objects looked at, {failed} findings")
sys.exit(failed > 0 or len(sys.argv) < 2)

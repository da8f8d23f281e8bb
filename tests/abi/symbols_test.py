#!/usr/bin/python3
"""Modules export weir_module_entry and nothing else; the plug-in what GStreamer and programs ask for."""

import pathlib
import subprocess
import sys

PLUGIN = ["gst_plugin_weir_get_desc", "gst_plugin_weir_register", "weir_condition_register", "weir_condition_unregister",
          "weir_converter_register", "weir_converter_unregister"]
failed = 0
for name in sys.argv[1:]:
    listed = subprocess.run(["nm", "-D", "--defined-only", "--format=posix", name], check=True, capture_output=True, text=True)
    symbols = sorted(line.split()[0] for line in listed.stdout.splitlines() if line.split()[1] != "A")
    plugin = pathlib.Path(name).name.startswith("libgst")
    wanted = PLUGIN if plugin else ["weir_module_entry"]
    if symbols != wanted:
        failed += 1
        print(f"FAILED {name} exports {symbols}, not {wanted}")
print(f"{len(sys.argv) - 1 - failed} of {len(sys.argv) - 1} export what they should")
sys.exit(failed > 0 or len(sys.argv) < 2)

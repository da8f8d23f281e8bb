# SPDX-License-Identifier: LGPL-2.1-or-later
"""Finds the parts of Weir that a wheel brings along: libraries, plug-ins, modules, model cards.

`make install` puts them where the system looks; a wheel has them in the folder `bundle` of the package.
"""

import ctypes
import os
import pathlib


def use(folder: pathlib.Path) -> None:
    """Points Weir and GStreamer to the parts below `folder`; no effect if there is no such folder.

    Sets environment variables that the user has not set. GST_PLUGIN_PATH keeps the folders that it names.
    """
    library = next(folder.rglob("libweir.so.0"), None)
    if library is None:
        return
    parts = {
        "WEIR_MODULE_PATH": library.parent / "weir" / "modules",
        "WEIR_ENGINES_DIR": library.parent / "weir" / "engines",
        "WEIR_WORKER": folder / "libexec" / "weir" / "weir-worker",
        "WEIR_CARD_PATH": folder / "share" / "weir" / "cards",
    }
    for variable, part in parts.items():
        if part.exists():
            os.environ.setdefault(variable, str(part))
    plugins, others = str(library.parent / "gstreamer-1.0"), os.environ.get("GST_PLUGIN_PATH")
    os.environ["GST_PLUGIN_PATH"] = f"{plugins}:{others}" if others else plugins
    # The extension module needs both, and finds those that are loaded.
    for name in ("libweir.so.0", "libweir-pipeline.so.0"):
        ctypes.CDLL(str(library.parent / name))

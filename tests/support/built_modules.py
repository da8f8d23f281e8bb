# SPDX-License-Identifier: LGPL-2.1-or-later
"""For tests in Python: which modules this build has."""

import os
import pathlib


def has_engine(name):
    folders = os.environ["WEIR_MODULE_PATH"].split(":")
    return any((pathlib.Path(folder) / f"libweir-engine-{name}.so").exists() for folder in folders)

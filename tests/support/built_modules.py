# SPDX-License-Identifier: LGPL-2.1-or-later
"""Lists the modules of this build, for tests in Python."""

import os
import pathlib


def has_module(kind, name):
    """Whether there is a module of this kind: engine, decoder, converter."""
    folders = os.environ["WEIR_MODULE_PATH"].split(":")
    return any((pathlib.Path(folder) / f"libweir-{kind}-{name}.so").exists() for folder in folders)


def has_engine(name):
    return has_module("engine", name)

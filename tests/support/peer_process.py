# SPDX-License-Identifier: LGPL-2.1-or-later
"""Inference servers in processes of their own, which print `port N` once they listen."""

import os
import pathlib
import re
import subprocess


def start_peer(test, *command):
    """The process, which ends with the test, and its port."""
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    for cleanup in (process.stdout.close, process.wait, process.stdin.close, process.kill):
        test.addCleanup(cleanup)
    port = re.fullmatch(r"port (\d+)\n", process.stdout.readline())
    test.assertTrue(port, "the server did not start")
    return process, int(port[1])


def start_grpcio_server(test, *options):
    """The same for inference_server.py, whose model is `affine`, y = 2 x + 1."""
    server = pathlib.Path(os.environ["WEIR_SOURCE"]) / "tests/support/inference_server.py"
    return start_peer(test, "/usr/bin/python3", server, "--classes", os.environ["WEIR_INFERENCE_CLASSES"], *options)

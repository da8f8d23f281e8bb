# SPDX-License-Identifier: LGPL-2.1-or-later
"""A mosquitto of a test, on a free port of 127.0.0.1."""

import contextlib
import os
import shutil
import socket
import subprocess

PATH = os.environ.get("PATH", "") + ":/usr/sbin:/usr/local/sbin"


def find_mosquitto():
    """None too for a build without MQTT, whose elements could not use it."""
    if os.environ.get("WEIR_WITHOUT_MQTT"):
        return None
    return shutil.which("mosquitto", path=PATH)


def accepts_connections(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def running_broker(port=None):
    """The port of a broker, which ends with the block."""
    port = port or free_port()
    with subprocess.Popen([find_mosquitto(), "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as broker:
        try:
            while not accepts_connections(port):
                if broker.poll() is not None:
                    raise RuntimeError(f"mosquitto -p {port} ended with {broker.returncode}")
            yield port
        finally:
            broker.kill()

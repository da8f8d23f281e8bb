# SPDX-License-Identifier: LGPL-2.1-or-later
"""A mosquitto of a test, on a free port of 127.0.0.1."""

import contextlib
import os
import random
import shutil
import socket
import subprocess
import time

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


def started_broker(port):
    """None if it ended, for example because another process has the port."""
    broker = subprocess.Popen([find_mosquitto(), "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while broker.poll() is None and not accepts_connections(port):
        time.sleep(0.002)
    return broker if broker.poll() is None else None


@contextlib.contextmanager
def running_broker(port=None):
    """The port of a broker, which ends with the block."""
    # mosquitto cannot choose one itself. The kernel gives connections and listeners with port 0 those from 32768 on.
    ports = [port] if port else random.sample(range(20000, 32000), 20)
    for port in ports:
        if not accepts_connections(port) and (broker := started_broker(port)):
            break
    else:
        raise RuntimeError(f"mosquitto does not start on port {port}")
    try:
        yield port
    finally:
        broker.kill()
        broker.wait()

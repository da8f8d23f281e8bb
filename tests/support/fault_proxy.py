#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A TCP proxy that damages connections, the same way for the same seed.

fault_proxy.py --to PORT [--seed N] [--fault NAME=CHANCE]...; prints `port PORT` when it listens. Each piece of data that it
forwards meets each fault with that chance:

    delay   is held back for up to 20 ms, in its order
    stall   is held back for 400 ms, with all that follows
    cut     only its first half is forwarded; then both connections are closed
    half    is forwarded; then this direction is closed and the other one stays open
    reset   is dropped; both connections end with RST
    flip    one bit is changed

Each connection and direction has random numbers of its own, so that their order in time does not matter. The line `drop` on
standard input resets all connections and is answered by `dropped N`, the number of connections accepted so far. Ends with
its input.
"""

import argparse
import asyncio
import random
import socket
import struct
import sys

PIECE = 16384
FAULTS = ["delay", "stall", "cut", "half", "reset", "flip"]


class Broken(Exception):
    """Both connections must end."""


def parse_arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--to", type=int, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--fault", action="append", default=[], metavar="NAME=CHANCE")
    arguments = parser.parse_args()
    chances = dict(fault.split("=") for fault in arguments.fault)
    if unknown := set(chances) - set(FAULTS):
        parser.error(f"unknown fault {', '.join(unknown)}; known: {', '.join(FAULTS)}")
    arguments.chances = {name: float(chance) for name, chance in chances.items()}
    return arguments


def reset(writer):
    """Closes with RST: without lingering."""
    sock = writer.get_extra_info("socket")
    if sock is not None and sock.fileno() >= 0:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    writer.transport.abort()


class Proxy:
    def __init__(self, arguments):
        self.arguments = arguments
        self.connections = 0
        self.writers = set()

    async def forward(self, reader, writer, rng):
        while data := await reader.read(PIECE):
            # All are drawn for each piece, so that one fault does not shift the others.
            drawn = {name: rng.random() < self.arguments.chances.get(name, 0) for name in FAULTS}
            wait, bit = rng.random(), rng.randrange(len(data) * 8)
            if drawn["delay"]:
                await asyncio.sleep(wait * 0.02)
            if drawn["stall"]:
                await asyncio.sleep(0.4)
            if drawn["reset"]:
                raise Broken
            if drawn["flip"]:
                data = bytearray(data)
                data[bit // 8] ^= 1 << bit % 8
            if drawn["cut"]:
                writer.write(bytes(data[:len(data) // 2]))
                await writer.drain()
                raise Broken
            writer.write(bytes(data))
            await writer.drain()
            if drawn["half"]:
                break
        if writer.can_write_eof():
            writer.write_eof()

    async def serve(self, reader, writer):
        number = self.connections
        self.connections += 1
        self.writers.add(writer)
        onward = None
        try:
            back, onward = await asyncio.open_connection("127.0.0.1", self.arguments.to)
            self.writers.add(onward)
            await asyncio.gather(self.forward(reader, onward, random.Random(f"{self.arguments.seed} {number} out")),
                                 self.forward(back, writer, random.Random(f"{self.arguments.seed} {number} back")))
        except (Broken, OSError):
            pass
        finally:
            for each in (writer, onward):
                if each is not None:
                    reset(each)
                    self.writers.discard(each)

    async def obey(self):
        loop = asyncio.get_running_loop()
        while line := await loop.run_in_executor(None, sys.stdin.readline):
            if line == "drop\n":
                for writer in list(self.writers):
                    reset(writer)
                print(f"dropped {self.connections}", flush=True)


async def main():
    proxy = Proxy(parse_arguments())
    server = await asyncio.start_server(proxy.serve, "127.0.0.1", 0)
    print(f"port {server.sockets[0].getsockname()[1]}", flush=True)
    await proxy.obey()


if __name__ == "__main__":
    asyncio.run(main())

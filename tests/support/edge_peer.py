#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""A peer of the nnstreamer-edge protocol for tests, written from docs/compatibility/edge-wire.md alone.

  edge_peer.py server     [--port P] [--form F] [--src-caps CAPS] [--sink-caps CAPS] [--drop N] [--clients N]
  edge_peer.py client     --connect HOST:PORT [--form F] FRAME...
  edge_peer.py publisher  [--port P] [--form F] [--caps CAPS] [--subscribers N] FRAME...
  edge_peer.py subscriber --connect HOST:PORT --frames N
  edge_peer.py encode     message|mqtt|mqtt-header      JSON lines of stdin become bytes on stdout
  edge_peer.py decode     message|mqtt|mqtt-header      bytes of stdin become JSON lines on stdout

FRAME is the memories in hexadecimal digits, with commas between them. A server or publisher prints `port P` when it
listens. A form is the number of bytes of the header: 2088, 168 or 160. Each frame that arrives is a line of JSON.
"""

import argparse
import json
import random
import socket
import struct
import sys
import threading

MAGIC, MQTT_MAGIC = 0xFEEDFEED, 0xEDDAEDDA
ERROR, TRANSFER_DATA, HOST_INFO, CAPABILITY = range(4)
COMMANDS = ["ERROR", "TRANSFER_DATA", "HOST_INFO", "CAPABILITY"]
# Magic, command, version key, client id, N, sizes, size of the metadata.
LAYOUTS = {2088: struct.Struct("<IIQqI4x256QQ"), 168: struct.Struct("<IIQqI4x16QQ"), 160: struct.Struct("<IIqI4x16QQ")}
TABLE = {2088: 256, 168: 16, 160: 16}
MICRO = {2088: 6, 168: 4}
# The same for the payload of MQTT: magic, version key, N, sizes, size of the metadata.
MQTT_LAYOUTS = {2080: struct.Struct("<I4xQI4x256QQ"), 160: struct.Struct("<I4xQI4x16QQ"), 144: struct.Struct("<II16QQ")}
MQTT_TABLE = {2080: 256, 160: 16, 144: 16}
MQTT_MICRO = {2080: 6, 160: 4}
MQTT_HEADER = struct.Struct("<I4x16QqqQQQ512s336x")
MOST_BYTES = 64 << 20
SECONDS = 10


class Fault(Exception):
    """The other side broke the protocol."""


def version_key(micro):
    return 0xEFDD << 48 | micro << 24 | 2


def version_of(key):
    return (key >> 12 & 0xFFF, key & 0xFFF, key >> 24 & 0xFFF)


def encode_metadata(pairs):
    """`pairs` in the order of the bytes."""
    if not pairs:
        return b""
    return struct.pack("<I", len(pairs)) + b"".join(text.encode() + b"\0" for pair in pairs for text in pair)


def decode_metadata(blob):
    if not blob:
        return []
    if len(blob) < 4:
        raise Fault("metadata without a count")
    count = struct.unpack_from("<I", blob)[0]
    parts = blob[4:].split(b"\0")
    if parts.pop() != b"" or len(parts) != 2 * count:
        raise Fault("metadata whose pairs are not those of its count")
    texts = [part.decode() for part in parts]
    return [[texts[i], texts[i + 1]] for i in range(0, len(texts), 2)]


def encode_message(form, command, client_id, memories=(), metadata=()):
    blob = encode_metadata(metadata)
    sizes = [len(memory) for memory in memories] + [0] * (TABLE[form] - len(memories))
    head = [MAGIC, command]
    if form in MICRO:
        head.append(version_key(MICRO[form]))
    return LAYOUTS[form].pack(*head, client_id, len(memories), *sizes, len(blob)) + b"".join(memories) + blob


def greet_both(client_id, text):
    """The greeting that clients of 168 and of 2088 bytes both understand."""
    message = bytearray(encode_message(2088, CAPABILITY, client_id, [text]))
    if 168 + len(text) <= 2080:
        message[168:168 + len(text)] = text
    return bytes(message)


def recognise(read):
    """Returns the form of what `read(n)` yields, and the bytes that this took."""
    start = read(16)
    if start[14:16] != b"\xdd\xef":
        return 160, start
    version = version_of(struct.unpack_from("<Q", start, 8)[0])
    if version != (0, 2, 5):
        return (168 if version <= (0, 2, 4) else 2088), start
    start += read(169 - 16)
    return (168 if start[168] else 2088), start


def read_message(read, form, start=b""):
    """Returns the next message; `start` is what was read of it already."""
    layout = LAYOUTS[form]
    have = start

    def take(size):
        nonlocal have
        if len(have) < size:
            have += read(size - len(have))
        part, have = have[:size], have[size:]
        return part

    fields = layout.unpack(take(layout.size))
    table = TABLE[form]
    magic, command, client_id, count = fields[0], fields[1], fields[-table - 3], fields[-table - 2]
    sizes, metadata_size = fields[-table - 1:-1], fields[-1]
    if magic != MAGIC or command >= len(COMMANDS):
        raise Fault(f"magic {magic:#x}, command {command}")
    if form in MICRO and fields[2] >> 48 != 0xEFDD:
        raise Fault(f"version key {fields[2]:#x}")
    if count >= table or sum(sizes[:count]) + metadata_size > MOST_BYTES:
        raise Fault(f"{count} memories of {sum(sizes[:count])} bytes")
    memories = [take(size) for size in sizes[:count]]
    metadata = decode_metadata(take(metadata_size))
    return command, client_id, memories, metadata


def encode_mqtt(form, memories, metadata):
    blob = encode_metadata(metadata)
    sizes = [len(memory) for memory in memories] + [0] * (MQTT_TABLE[form] - len(memories))
    head = [MQTT_MAGIC] + ([version_key(MQTT_MICRO[form])] if form in MQTT_MICRO else [])
    return MQTT_LAYOUTS[form].pack(*head, len(memories), *sizes, len(blob)) + b"".join(memories) + blob


def decode_mqtt(payload):
    for form, layout in MQTT_LAYOUTS.items():
        if len(payload) < layout.size:
            continue
        table = MQTT_TABLE[form]
        fields = layout.unpack_from(payload)
        count, sizes, metadata_size = fields[-table - 2], fields[-table - 1:-1], fields[-1]
        if fields[0] != MQTT_MAGIC or count > table:
            continue
        if form in MQTT_MICRO and fields[1] >> 48 != 0xEFDD:
            continue
        if layout.size + sum(sizes[:count]) + metadata_size != len(payload):
            continue
        memories, at = [], layout.size
        for size in sizes[:count]:
            memories.append(payload[at:at + size])
            at += size
        return form, memories, decode_metadata(payload[at:])
    raise Fault(f"no form has a payload of these {len(payload)} bytes")


MQTT_NUMBERS = ["base_time_epoch", "sent_time_epoch", "duration", "dts", "pts"]
NONE = (1 << 64) - 1


def encode_mqtt_header(fields):
    sizes = fields["sizes"]
    times = [NONE if fields[name] is None else fields[name] for name in MQTT_NUMBERS]
    return MQTT_HEADER.pack(len(sizes), *sizes, *[0] * (16 - len(sizes)), *times, fields["caps"].encode())


def decode_mqtt_header(header):
    count, *numbers, caps = MQTT_HEADER.unpack(header)
    if count > 16 or b"\0" not in caps:
        raise Fault(f"{count} memories")
    times = dict(zip(MQTT_NUMBERS, numbers[16:]))
    times = {name: None if value == NONE else value for name, value in times.items()}
    return {"sizes": numbers[:count], **times, "caps": caps[:caps.index(0)].decode()}


def reader_of(connection):
    """A function that returns exactly n bytes of a socket or file."""
    receive = connection.recv if isinstance(connection, socket.socket) else connection.read

    def read(size):
        parts = []
        while size:
            part = receive(min(size, 1 << 16))
            if not part:
                raise EOFError
            parts.append(part)
            size -= len(part)
        return b"".join(parts)

    return read


def as_json(form, message):
    command, client_id, memories, metadata = message
    return json.dumps({"form": form, "command": COMMANDS[command], "client_id": client_id,
                       "memories": [memory.hex() for memory in memories], "metadata": metadata})


def report(form, message):
    print(as_json(form, message), flush=True)


def listener(port, host="127.0.0.1"):
    server = socket.create_server((host, port), backlog=10)
    server.settimeout(SECONDS)
    return server


def connection_to(address):
    host, port = address.split(":", 1)
    connection = socket.create_connection((host, int(port)), timeout=SECONDS)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


def own_id():
    return random.SystemRandom().getrandbits(62)


def text_of(message, command):
    """The text of a HOST_INFO or CAPABILITY."""
    if message[0] != command or len(message[2]) != 1 or not message[2][0].endswith(b"\0"):
        raise Fault(f"{COMMANDS[message[0]]} of {len(message[2])} memories instead of {COMMANDS[command]}")
    return message[2][0][:-1].decode()


def send_greeting(connection, form, client_id, text):
    connection.sendall(greet_both(client_id, text) if form == 0 else encode_message(form, CAPABILITY, client_id, [text]))


def receive_host_info(connection):
    """Returns the form of the other side, and the address that it gives; None after an ERROR."""
    read = reader_of(connection)
    form, start = recognise(read)
    message = read_message(read, form, start)
    return form, None if message[0] == ERROR else text_of(message, HOST_INFO)


def serve_client(options, a):
    """One client of a query server: what it sends on A comes back on B."""
    client_id = own_id()
    text = f"@query_server_src_caps@{options.src_caps}@query_server_sink_caps@{options.sink_caps}".encode() + b"\0"
    with a:
        send_greeting(a, options.form, client_id, text)
        form, address = receive_host_info(a)
        if address is None:
            return
        read, received = reader_of(a), 0
        with connection_to(address) as b:
            while True:
                try:
                    message = read_message(read, form)
                except EOFError:
                    return
                if message[0] == ERROR:
                    b.sendall(encode_message(form, ERROR, 0))
                    return
                received += 1
                report(form, message)
                if options.drop and received % options.drop == 0:
                    continue
                b.sendall(encode_message(form, TRANSFER_DATA, client_id, message[2], [["client_id", str(client_id)]]))


def run_server(options):
    with listener(options.port) as server:
        print("port", server.getsockname()[1], flush=True)
        threads = []
        for _ in range(options.clients):
            connection, _ = server.accept()
            connection.settimeout(SECONDS)
            threads.append(threading.Thread(target=serve_client, args=(options, connection)))
            threads[-1].start()
        for thread in threads:
            thread.join()


def frames_of(texts):
    return [[bytes.fromhex(part) for part in text.split(",")] for text in texts]


def run_client(options):
    with listener(0) as back, connection_to(options.connect) as a:
        read = reader_of(a)
        if options.form in (0, 2088):
            form, start = recognise(read)
        else:  # what a client of this form does: it reads its own header, whatever comes
            form, start = options.form, b""
        greeting = read_message(read, form, start)
        print(json.dumps({"form": form, "capability": text_of(greeting, CAPABILITY)}), flush=True)
        address = f"127.0.0.1:{back.getsockname()[1]}".encode() + b"\0"
        a.sendall(encode_message(form, HOST_INFO, greeting[1], [address]))
        b, _ = back.accept()
        b.settimeout(SECONDS)
        with b:
            responses = reader_of(b)
            for memories in frames_of(options.frame):
                a.sendall(encode_message(form, TRANSFER_DATA, greeting[1], memories, [["client_id", str(greeting[1])]]))
                report(form, read_message(responses, form))
            a.sendall(encode_message(form, ERROR, 0))


def run_publisher(options):
    text = f"@edge_sink_caps@{options.caps}".encode() + b"\0"
    with listener(options.port) as server:
        print("port", server.getsockname()[1], flush=True)
        subscribers = []
        for _ in range(options.subscribers):
            connection, _ = server.accept()
            connection.settimeout(SECONDS)
            client_id = own_id()
            form = options.form or 2088
            send_greeting(connection, form, client_id, text)
            if receive_host_info(connection)[1] is not None:
                subscribers.append((connection, client_id))
        for memories in frames_of(options.frame):
            for connection, client_id in subscribers:
                connection.sendall(encode_message(form, TRANSFER_DATA, client_id, memories))
        for connection, _ in subscribers:
            connection.sendall(encode_message(form, ERROR, 0))
            connection.close()


def run_subscriber(options):
    with connection_to(options.connect) as connection:
        read = reader_of(connection)
        form, start = recognise(read)
        greeting = read_message(read, form, start)
        print(json.dumps({"form": form, "capability": text_of(greeting, CAPABILITY)}), flush=True)
        connection.sendall(encode_message(form, HOST_INFO, greeting[1], [b"127.0.0.1:1\0"]))
        for _ in range(options.frames):
            report(form, read_message(read, form))


def encode_line(kind, line):
    fields = json.loads(line)
    if kind == "mqtt-header":
        return encode_mqtt_header(fields)
    memories = [bytes.fromhex(memory) for memory in fields["memories"]]
    if kind == "mqtt":
        return encode_mqtt(fields["form"], memories, fields["metadata"])
    return encode_message(fields["form"], COMMANDS.index(fields["command"]), fields["client_id"], memories, fields["metadata"])


def run_encode(options):
    for line in sys.stdin:
        sys.stdout.buffer.write(encode_line(options.kind, line))


def run_decode(options):
    """`mqtt` and `mqtt-header` take one payload, `message` a connection's bytes."""
    if options.kind == "message":
        read = reader_of(sys.stdin.buffer)
        form, start = recognise(read)
        while True:
            try:
                report(form, read_message(read, form, start))
            except EOFError:
                return
            start = b""
    payload = sys.stdin.buffer.read()
    if options.kind == "mqtt":
        form, memories, metadata = decode_mqtt(payload)
        print(json.dumps({"form": form, "memories": [memory.hex() for memory in memories], "metadata": metadata}))
    else:
        print(json.dumps(decode_mqtt_header(payload)))


def arguments(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    roles = parser.add_subparsers(required=True)

    def role(name, run):
        added = roles.add_parser(name)
        added.set_defaults(run=run)
        return added

    for name, run in (("server", run_server), ("publisher", run_publisher)):
        added = role(name, run)
        added.add_argument("--port", type=int, default=0)
        added.add_argument("--form", type=int, default=0, choices=[0, *LAYOUTS], help="0: the greeting for both newer forms")
        if name == "server":
            added.add_argument("--src-caps", default="other/tensors")
            added.add_argument("--sink-caps", default="other/tensors")
            added.add_argument("--drop", type=int, default=0, help="each Nth request gets no response")
            added.add_argument("--clients", type=int, default=1, help="ends after so many")
        else:
            added.add_argument("--caps", default="")
            added.add_argument("--subscribers", type=int, default=1, help="waits for so many")
            added.add_argument("frame", nargs="*")
    added = role("client", run_client)
    added.add_argument("--connect", required=True)
    added.add_argument("--form", type=int, default=0, choices=[0, *LAYOUTS], help="0: the server's")
    added.add_argument("frame", nargs="*")
    added = role("subscriber", run_subscriber)
    added.add_argument("--connect", required=True)
    added.add_argument("--frames", type=int, required=True)
    for name, run in (("encode", run_encode), ("decode", run_decode)):
        role(name, run).add_argument("kind", choices=["message", "mqtt", "mqtt-header"])
    return parser.parse_args(words)


if __name__ == "__main__":
    given = arguments()
    given.run(given)

# SPDX-License-Identifier: LGPL-2.1-or-later
"""An HTTP/2 connection that sends what it likes: streams that announce large gRPC messages and never end them."""

import select
import socket
import struct

DATA, HEADERS, RST_STREAM, SETTINGS, PING, GOAWAY, WINDOW_UPDATE = 0, 1, 3, 4, 6, 7, 8
ACK, END_STREAM, END_HEADERS = 1, 1, 4
INITIAL_WINDOW_SIZE, WINDOW, FRAME = 4, 65535, 16384


def header_block(headers):
    """HPACK: literals that are not indexed."""
    def text(value):
        data = value if isinstance(value, bytes) else value.encode()
        assert len(data) < 127
        return bytes([len(data)]) + data
    return b"".join(b"\0" + text(name) + text(value) for name, value in headers)


class Stream:
    def __init__(self, number, data, window):
        self.number, self.unsent, self.window, self.reset = number, memoryview(data), window, None
        self.headers = b""  # that came, as HPACK: gRPC sends their texts as they are


class Connection:
    """`goodbye` is the error code of a GOAWAY, `closed` whether the other side closed the connection."""

    def __init__(self, port, host="127.0.0.1", own_window=WINDOW):
        """`own_window`: bytes that the other side may send on each stream before open()."""
        self.socket = socket.create_connection((host, port), 10)
        self.streams, self.next_number = {}, 1
        self.window, self.first_window = WINDOW, WINDOW
        self.received, self.pongs, self.pings = b"", 0, 0
        self.closed, self.goodbye, self.served = False, None, False
        self.socket.sendall(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n")
        self.frame(SETTINGS, 0, 0, struct.pack(">HI", INITIAL_WINDOW_SIZE, own_window))

    def close(self):
        self.socket.close()

    def frame(self, kind, flags, stream, payload=b""):
        try:
            self.socket.sendall(struct.pack(">I", len(payload))[1:] + bytes([kind, flags]) + struct.pack(">I", stream) + payload)
        except OSError:
            self.closed = True

    def call(self, path, message=b"", announced=None, more=(), compressed=False):
        """Begins a call whose message is said to have `announced` bytes, and to be compressed; its bytes are sent by push()."""
        announced = len(message) if announced is None else announced
        stream = Stream(self.next_number, bytes([compressed]) + struct.pack(">I", announced) + message, self.first_window)
        self.next_number += 2
        self.streams[stream.number] = stream
        headers = [(":method", "POST"), (":scheme", "http"), (":path", path), (":authority", "localhost"), ("te", "trailers"),
                   ("content-type", "application/grpc"), *more]
        self.frame(HEADERS, END_HEADERS, stream.number, header_block(headers))
        return stream

    def open(self, stream, size):
        """Lets the other side send `size` bytes more on a stream."""
        for number in (0, stream.number):
            self.frame(WINDOW_UPDATE, 0, number, struct.pack(">I", size))

    def push(self):
        """Sends what the other side's windows allow."""
        for stream in self.streams.values():
            while stream.unsent and stream.reset is None and not self.closed:
                size = min(len(stream.unsent), self.window, stream.window, FRAME)
                if size <= 0:
                    break
                self.frame(DATA, 0, stream.number, stream.unsent[:size])
                stream.unsent = stream.unsent[size:]
                self.window -= size
                stream.window -= size

    def read(self, seconds):
        """Handles the frames that came; waits for one if there is none."""
        if self.closed or not select.select([self.socket], [], [], seconds)[0]:
            return
        try:
            data = self.socket.recv(1 << 20)
        except OSError:
            data = b""
        self.closed = not data
        self.received += data
        while len(self.received) >= 9 and len(self.received) >= 9 + int.from_bytes(self.received[:3], "big"):
            size = int.from_bytes(self.received[:3], "big")
            kind, flags, number = self.received[3], self.received[4], int.from_bytes(self.received[5:9], "big")
            payload, self.received = self.received[9:9 + size], self.received[9 + size:]
            self.handle(kind, flags, self.streams.get(number), payload)

    def handle(self, kind, flags, stream, payload):
        self.served = True
        if kind == SETTINGS and not flags & ACK:
            for i in range(0, len(payload), 6):
                name, value = struct.unpack(">HI", payload[i:i + 6])
                if name == INITIAL_WINDOW_SIZE:
                    for other in self.streams.values():
                        other.window += value - self.first_window
                    self.first_window = value
            self.frame(SETTINGS, ACK, 0)
        elif kind == PING and flags & ACK:
            self.pongs += 1
        elif kind == PING:
            self.frame(PING, ACK, 0, payload)
        elif kind == GOAWAY:
            self.goodbye = struct.unpack(">I", payload[4:8])[0]
        elif kind == WINDOW_UPDATE and stream:
            stream.window += struct.unpack(">I", payload)[0]
        elif kind == WINDOW_UPDATE:
            self.window += struct.unpack(">I", payload)[0]
        if stream and kind == HEADERS:
            stream.headers += payload
        if stream and (kind == RST_STREAM or flags & END_STREAM):
            stream.reset = kind

    def ping(self):
        """Returns when the other side has handled what was sent before; False when the connection ended."""
        self.pings += 1
        self.frame(PING, 0, 0, struct.pack(">Q", self.pings))
        while self.pongs < self.pings and not self.closed:
            self.read(10)
        return not self.closed

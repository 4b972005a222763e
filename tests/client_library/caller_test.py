"""The session over a WebSocket that the caller owns: the native library as a browser's page uses it."""

import base64
import os
import socket
import struct
import time
import unittest

import game_server
import zoned_client
from zoned_client import Client, State, StreamWish


class WebSocket:
    """As much of RFC 6455 as a client of messages needs."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port))
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
                             "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                             f"Sec-WebSocket-Protocol: zoned\r\nSec-WebSocket-Key: {key}\r\n\r\n").encode())
        self.bytes = b""
        while b"\r\n\r\n" not in self.bytes:
            self.bytes += self.socket.recv(4096)
        head, self.bytes = self.bytes.split(b"\r\n\r\n", 1)
        assert head.startswith(b"HTTP/1.1 101"), head
        self.socket.setblocking(False)

    def send(self, payload):
        mask = os.urandom(4)
        size = len(payload)
        head = struct.pack(">BB", 0x82, 0x80 | size) if size < 126 else struct.pack(
            ">BBH", 0x82, 0x80 | 126, size)
        masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload))
        self.socket.setblocking(True)
        self.socket.sendall(head + mask + masked)
        self.socket.setblocking(False)

    def messages(self):
        """All that have come; raises ConnectionError at the end."""
        try:
            while True:
                part = self.socket.recv(65536)
                if not part:
                    raise ConnectionError
                self.bytes += part
        except BlockingIOError:
            pass
        while len(self.bytes) >= 2:
            size, at = self.bytes[1] & 127, 2
            if size == 126:
                size, at = struct.unpack(">H", self.bytes[2:4])[0] if len(self.bytes) >= 4 else 1 << 40, 4
            elif size == 127:
                size, at = struct.unpack(">Q", self.bytes[2:10])[0] if len(self.bytes) >= 10 else 1 << 40, 10
            if len(self.bytes) < at + size:
                return
            code, payload = self.bytes[0] & 15, self.bytes[at:at + size]
            self.bytes = self.bytes[at + size:]
            if code == 8:
                raise ConnectionError
            if code == 2:
                yield payload


class Caller:
    """A client whose WebSocket lives here."""

    def __init__(self, port, name):
        self.client = Client(name)
        self.port = port
        self.socket = None
        self.opened = 0
        self.client.begin()

    def poll(self):
        state = self.client.poll()
        while frame := self.client.next_frame():
            if self.socket:
                self.socket.send(frame)
        wish = self.client.stream_wish()
        if wish == StreamWish.OPEN:
            self.opened += 1
            self.socket = WebSocket(self.port)
            self.client.stream_opened()
        elif wish == StreamWish.CLOSE and self.socket:
            self.socket.socket.close()
            self.socket = None
        if self.socket:
            try:
                for message in self.socket.messages():
                    self.client.stream_frame(message)
            except OSError:
                self.cut()
        return state

    def cut(self):
        self.socket.socket.close()
        self.socket = None
        self.client.stream_closed("cut")


class CallersWebSocket(unittest.TestCase):
    def play(self, caller, until, seconds=20.0):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.assertNotEqual(caller.poll(), State.CLOSED, caller.client.trouble)
            if until():
                return True
            time.sleep(1.0 / 60.0)
        return False

    def test_joins_walks_and_comes_back(self):
        with game_server.serve(websocket=True) as server:
            caller = Caller(server.websocket, "caller")
            self.addCleanup(caller.client.close)
            client = caller.client
            self.assertTrue(self.play(caller, lambda: client.own() and client.stats().rtt_ms > 0))
            self.assertTrue(client.stats().tunnelled)
            before = list(client.own().position)
            client.set_input(move_x=1.0 if before[0] < 0 else -1.0)
            self.assertTrue(self.play(
                caller, lambda: abs(client.own().position[0] - before[0]) > 2.0))
            caller.cut()
            self.assertTrue(self.play(caller, lambda: client.stats().resumed == 1))
            self.assertEqual(caller.opened, 2)

    def test_takes_no_frames_without_a_session_of_its_own(self):
        client = Client("nobody")
        self.addCleanup(client.close)
        library = zoned_client._library
        for function in ("stream_wish", "stream_opened"):
            call = getattr(library, f"zoned_client_{function}")
            self.assertEqual(call(client._client), -1)
            self.assertEqual(call(None), -1)


if __name__ == "__main__":
    unittest.main()

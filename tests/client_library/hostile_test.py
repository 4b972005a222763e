"""The client library against servers that lie, stammer and fall silent: no abort, no hang, and a
trouble text that says what is wrong. Time is passed in, so that waiting costs none."""

import os
import random
import shutil
import socket
import ssl
import struct
import threading
import time
import unittest

from game_server import scratch, serve
from zoned_client import Client, State


def frame(payload):
    return struct.pack("<I", len(payload)) + payload


def varint(number):
    out = b""
    while number >= 0x80:
        out += bytes([number & 0x7F | 0x80])
        number >>= 7
    return out + bytes([number])


def field(number, payload):
    """A field of bytes in protobuf's wire format."""
    return varint(number << 3 | 2) + varint(len(payload)) + payload


def welcome(world=None, key_bytes=28):
    inner = b"\x08\x01\x10\x02\x18\x09" + field(4, b"0123456789abcdef") + b"\x28\x1e"
    keys = field(21, bytes(28)) + field(22, bytes(key_bytes))
    return frame(field(1, inner + (field(9, world) if world is not None else b"") + keys))


def doubles(*values):
    return struct.pack(f"<{len(values)}d", *values)


# A world that a client can use: its rate, steps, one type, one level of detail, one zone.
STEPS = b"".join(bytes([n << 3 | 5]) + struct.pack("<f", v) for n, v in
                 ((1, 0.01), (2, 0.01), (3, 0.01), (4, 0.01)))
STEPS += b"\x28\x0a\x30\x0a"
STEPS += b"".join(bytes([n << 3 | 5]) + struct.pack("<f", v) for n, v in
                  ((7, 100.0), (8, 100.0), (9, 100.0), (10, 9.8)))
ZONE = b"\x08\x01" + field(2, doubles(0, 0, 0)) + field(3, doubles(-9, -9)) + field(4, doubles(9, 9))
RATE = b"\x09" + struct.pack("<d", 30.0)
GOOD_WORLD = RATE + field(2, STEPS) + field(3, field(1, b"ball")) + field(4, b"") + field(5, ZONE)


class HostileServer:
    """Listens once or more, with TLS where it has a certificate, and does `act` on each stream."""

    def __init__(self, act, certificate=None):
        self.act = act
        self.context = None
        if certificate is not None:
            self.context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            self.context.load_cert_chain(certificate / "certificate.pem", certificate / "key.pem")
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.open = True
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while self.open:
            try:
                stream, _ = self.listener.accept()
                stream.settimeout(5.0)
                if self.context:
                    stream = self.context.wrap_socket(stream, server_side=True)
                with stream:
                    self.act(stream)
            except OSError:
                pass

    def close(self):
        self.open = False
        self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.thread.join()


def silence(stream):
    while stream.recv(4096):
        pass


def says(data, then=silence):
    def act(stream):
        stream.sendall(data)
        then(stream)
    return act


class Hostile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.certificates = cls.enterClassContext(scratch())
        with serve() as server:
            for name in ("certificate.pem", "key.pem"):
                shutil.copy(server.state / name, cls.certificates)

    def meet(self, act, tls=True, seconds=60.0, until=State.CLOSED):
        """The client's trouble once it has given up; `seconds` of its own time."""
        server = HostileServer(act, self.certificates if tls else None)
        self.addCleanup(server.close)
        with Client("victim") as client:
            client.connect("127.0.0.1", server.port)
            now_s, end = 0.0, time.monotonic() + 20.0
            while client.poll(now_s) != until and now_s < seconds and time.monotonic() < end:
                client.entities(), client.own(), client.next_event()
                time.sleep(0.002)
                now_s += 0.02
            self.assertEqual(client.state, until, f"after {now_s} s: {client.trouble}")
            return client.trouble

    def test_nobody_listens(self):
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        with Client("victim") as client:
            client.connect("127.0.0.1", port)
            now_s = 0.0
            while client.poll(now_s) != State.CLOSED and now_s < 60.0:
                now_s += 0.1
                time.sleep(0.001)
            self.assertIn("cannot connect", client.trouble)

    def test_a_name_that_nobody_knows_holds_no_frame_up(self):
        with Client("victim") as client:
            client.connect("no-such-host.invalid", 7777)
            end = time.monotonic() + 30.0
            longest = 0.0
            while client.state != State.CLOSED and time.monotonic() < end:
                begin = time.monotonic()
                client.poll()
                longest = max(longest, time.monotonic() - begin)
                time.sleep(0.005)
            self.assertIn("cannot resolve no-such-host.invalid", client.trouble)
            self.assertLess(longest, 0.1)

    def test_speaks_no_tls(self):
        self.assertIn("TLS handshake failed", self.meet(says(b"HTTP/1.1 400\r\n\r\n"), tls=False))
        self.assertIn("TLS handshake failed", self.meet(says(os.urandom(4096)), tls=False))

    def test_closes_at_once(self):
        self.assertNotEqual(self.meet(lambda stream: None, tls=False), "")
        self.assertIn("closed", self.meet(lambda stream: stream.unwrap()))

    def test_is_silent(self):
        self.assertIn("no answer", self.meet(silence))

    def test_answers_with_another_protocol(self):
        answer = self.meet(says(frame(b"\xff" * 40)))
        self.assertIn("no server of protocol version", answer)

    def test_refuses_another_version_and_says_so(self):
        refused = frame(field(2, b"\x08\x01" + field(2, b"this server speaks version 9")))
        self.assertEqual(self.meet(says(refused)), "refused: this server speaks version 9")
        self.assertIn("different versions", self.meet(says(frame(field(2, b"\x08\x01")))))
        escape = frame(field(2, b"\x08\x01" + field(2, b"\x1b[31mred")))
        self.assertNotIn("\x1b", self.meet(says(escape)))

    def test_announces_an_endless_frame(self):
        self.assertIn("frame of 4294967295 bytes", self.meet(says(b"\xff" * 64)))

    def test_sends_half_a_frame_and_closes(self):
        self.assertNotEqual(self.meet(says(welcome(GOOD_WORLD)[:40], lambda s: s.unwrap())), "")

    def test_welcomes_without_a_world_that_makes_sense(self):
        for world in (None, b"", RATE, GOOD_WORLD + field(5, b""), GOOD_WORLD + field(6, b""),
                      GOOD_WORLD + b"\x09" + struct.pack("<d", float("nan"))):
            self.assertIn("the server's world makes no sense", self.meet(says(welcome(world))))

    def test_welcomes_with_keys_of_another_length(self):
        for length in (0, 27, 29, 5000):
            self.assertIn("has no keys for datagrams", self.meet(says(welcome(GOOD_WORLD, length))))

    def test_welcomes_and_then_sends_random_frames(self):
        dice = random.Random(5)
        noise = b"".join(frame(bytes([8 * dice.randrange(1, 9) + 2]) + dice.randbytes(dice.randrange(60)))
                         for _ in range(2000))

        def act(stream):
            stream.sendall(welcome(GOOD_WORLD) + noise)
            stream.sendall(frame(field(6, field(2, b"enough of you"))))
            stream.unwrap()

        self.assertEqual(self.meet(act), "closed by the server: enough of you")

    def test_floods_with_events_that_nobody_fetches(self):
        event = lambda n: frame(field(3, b"\x08" + varint(n) + b"\x10" + varint(n) + b"\x20\x12" +
                                      field(6, bytes(5000))))

        def act(stream):
            stream.sendall(welcome(GOOD_WORLD))
            for n in range(1, 6000):
                stream.sendall(event(n))
            silence(stream)

        server = HostileServer(act, self.certificates)
        self.addCleanup(server.close)
        with Client("victim") as client:
            client.connect("127.0.0.1", server.port)
            end = time.monotonic() + 20.0
            while time.monotonic() < end:
                client.poll()
                if client.state == State.ONLINE and client.stats().events_dropped > 2000:
                    break
                time.sleep(0.002)
            self.assertGreater(client.stats().events_dropped, 2000)
            self.assertEqual(len(client.next_event().payload), 5000)


if __name__ == "__main__":
    unittest.main()

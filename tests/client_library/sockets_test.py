"""Sockets of the game's own: the library brings TLS, framing and seals; no name is looked up where no thread may be."""

import ctypes
import socket
import time
import unittest

import game_server
import zoned_client
from zoned_client import Client, SocketKind, State, Trust


class OwnSockets:
    """As a game has them: not blocking, by its own numbers. A number below 0 of `refuse` is what open() says."""

    def __init__(self, refuse=(), lie=0):
        self.refuse = refuse
        self.lie = lie  # bytes by which receive() exaggerates
        self.sockets = {}
        self.opened = []
        self.closed = []
        fields = dict(zoned_client.Sockets._fields_)
        self.functions = zoned_client.Sockets(
            open=fields["open"](self.open), send=fields["send"](self.send),
            receive=fields["receive"](self.receive), close=fields["close"](self.close))

    def open(self, _, kind, host, port):
        if kind in self.refuse:
            return -1
        number = 100 + len(self.opened)
        self.opened.append((SocketKind(kind), host.decode(), port))
        made = socket.socket(type=socket.SOCK_DGRAM if kind else socket.SOCK_STREAM)
        made.setblocking(False)
        made.connect_ex((host.decode(), port))
        self.sockets[number] = made
        return number

    def send(self, _, number, data, size):
        try:
            return self.sockets[number].send(ctypes.string_at(data, size))
        except (BlockingIOError, ConnectionRefusedError):
            return 0
        except OSError:
            return zoned_client.SOCKET_FAILED

    def receive(self, _, number, data, capacity):
        own = self.sockets[number]
        try:
            part = own.recv(capacity)
        except (BlockingIOError, ConnectionRefusedError):
            return 0
        except OSError:
            return zoned_client.SOCKET_FAILED
        if not part and own.type == socket.SOCK_STREAM:
            return zoned_client.SOCKET_ENDED
        ctypes.memmove(data, part, len(part))
        return len(part) if not self.lie else capacity + self.lie

    def close(self, _, number):
        self.closed.append(number)
        self.sockets.pop(number).close()

    def cut(self):
        for own in self.sockets.values():
            if own.type == socket.SOCK_STREAM:
                own.shutdown(socket.SHUT_RDWR)


class GamesOwnSockets(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.running = game_server.serve()
        cls.server = cls.running.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.running.__exit__(None, None, None)

    def client(self, own=None, trust=Trust.ANYONE, **settings):
        client = Client("socketeer", trust=trust, sockets=own.functions if own else None, **settings)
        self.addCleanup(client.close)
        return client

    def poll_until(self, client, until, seconds=20.0):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            client.poll()
            if until():
                return True
            time.sleep(1.0 / 60.0)
        return False

    def joined(self, client):
        return lambda: client.own() and client.stats().rtt_ms > 0

    def test_play_resume_and_are_closed(self):
        own = OwnSockets()
        client = self.client(own)
        client.connect("127.0.0.1", self.server.port)
        self.assertTrue(self.poll_until(client, self.joined(client)), client.trouble)
        self.assertEqual([kind for kind, _, _ in own.opened], [SocketKind.STREAM, SocketKind.DATAGRAMS])
        packets = client.stats().packets_in
        self.assertTrue(self.poll_until(client, lambda: client.stats().packets_in > packets + 60))
        self.assertEqual(client.stats().tunnelled, 0)
        own.cut()
        self.assertTrue(self.poll_until(client, lambda: client.stats().resumed == 1), client.trouble)
        client.close()
        self.assertEqual(own.sockets, {})
        self.assertEqual(len(own.closed), len(set(own.closed)))

    def test_without_datagrams_states_travel_inside_the_stream(self):
        own = OwnSockets(refuse={SocketKind.DATAGRAMS})
        client = self.client(own)
        client.connect("127.0.0.1", self.server.port)
        self.assertTrue(self.poll_until(client, lambda: client.own() and client.stats().tunnelled),
                        client.trouble)

    def test_that_refuse_or_lie_end_the_client_with_a_reason(self):
        for own, reason in ((OwnSockets(refuse={SocketKind.STREAM}), "cannot connect: the game's socket"),
                            (OwnSockets(lie=1), "the game's socket failed"),
                            (OwnSockets(lie=-(1 << 40)), "the game's socket failed")):
            client = self.client(own)
            client.connect("127.0.0.1", self.server.port)
            self.assertTrue(self.poll_until(client, lambda: client.state == State.CLOSED))
            self.assertIn(reason, client.trouble)
            self.assertEqual(own.sockets, {})

    def test_lack_a_function(self):
        half = zoned_client.Sockets()
        with self.assertRaisesRegex(zoned_client.Error, "sockets: lacks"):
            Client("half", sockets=half)
        with self.assertRaisesRegex(zoned_client.Error, "allocator: lacks"):
            Client("half", allocator=zoned_client.Allocator())

    def test_trust_nobody_unasked(self):
        own = OwnSockets()
        client = self.client(own, trust=Trust.DEFAULT)
        client.connect("127.0.0.1", self.server.port)
        self.assertTrue(self.poll_until(client, lambda: client.state == State.CLOSED))
        self.assertIn("certificate verify failed", client.trouble)

    def test_the_certificates_name_may_be_another_than_the_hosts(self):
        authority = str(self.server.state / "certificate.pem")
        right = self.client(trust=Trust.AUTHORITIES, ca_file=authority, server_name="localhost")
        right.connect("127.0.0.1", self.server.port)
        self.assertTrue(self.poll_until(right, self.joined(right)), right.trouble)
        wrong = self.client(trust=Trust.AUTHORITIES, ca_file=authority, server_name="elsewhere")
        wrong.connect("127.0.0.1", self.server.port)
        self.assertTrue(self.poll_until(wrong, lambda: wrong.state == State.CLOSED))
        self.assertIn("certificate verify failed", wrong.trouble)

    def test_no_thread_looks_up_a_name_where_none_may(self):
        client = self.client(no_threads=True)
        client.connect("server.example", self.server.port)
        self.assertTrue(self.poll_until(client, lambda: client.state == State.CLOSED))
        self.assertIn("server.example is a name", client.trouble)
        client.connect("127.0.0.1", self.server.port)
        self.assertTrue(self.poll_until(client, self.joined(client)), client.trouble)


if __name__ == "__main__":
    unittest.main()

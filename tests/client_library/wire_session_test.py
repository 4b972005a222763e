"""Sessions of the client that was written from proto/WIRE.md: tickets, broken streams, and a path without UDP."""

import hashlib
import ssl
import subprocess
import unittest

import game_server
import proto_messages
import wire_session
from wire_client import WireClient
from wire_judge import clean_samples
from wire_session import PROTO, SCHEMA, Refused

SANDBOX = proto_messages.Schema(PROTO / "sandbox.proto")


def walk(_):
    """Along +z, where nothing is in the way."""
    return 0, 127, 0, 0, 0


class Sessions(unittest.TestCase):
    """A server of one world for all of them but those with tickets."""

    @classmethod
    def setUpClass(cls):
        cls.running = game_server.serve()
        cls.server = cls.running.__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.running.__exit__(None, None, None)

    def join(self, name="Ann", server=None, **hello):
        """A client that has an avatar."""
        client = WireClient("127.0.0.1", (server or self.server).port, name=name, **hello)
        self.assertTrue(client.run(10, lambda: client.player.own and client.session.joined))
        self.assertEqual(client.session.joined.avatar, client.player.own.avatar)
        return client

    def events(self, client, kind, message):
        """Messages of the game's events of a kind."""
        return [SANDBOX.decode(message, event.payload) for event in client.session.events
                if event.kind == SANDBOX.enums[kind]]

    def say(self, client, text):
        """A chat line."""
        client.session.command(SANDBOX.enums["COMMAND_CHAT"], SANDBOX.encode("Chat", {"topic": "world", "text": text}))

    def said(self, client):
        """Lines that were heard."""
        return [line.text.decode() for line in self.events(client, "EVENT_CHAT", "ChatLine")]

    def exact(self, client, since=0):
        """How many own states were predicted to the bit; no other is near."""
        samples = [sample for sample in clean_samples(client.player)[0] if sample.tick > since]
        self.assertEqual([vars(sample) for sample in samples if sample.error > 0], [])
        return len(samples)

    def test_leaves_and_others_hear_of_it(self):
        watcher, client = self.join("Bob"), self.join("Ann")
        avatar = client.player.own.avatar
        seen = lambda: watcher.player.view.at(avatar)
        self.assertTrue(watcher.run(5, lambda: client.poll() or seen()))
        client.session.quit()
        left = lambda: [player.name for player in self.events(watcher, "EVENT_LEAVE", "PlayerName")
                        if player.avatar == avatar]
        self.assertTrue(watcher.run(5, lambda: left() and not seen()))
        self.assertEqual(left(), [b"Ann"])
        watcher.session.quit()

    def test_a_push_moves_a_crate_or_is_denied_with_a_reason(self):
        client = self.join()
        client.run(0.5)
        crate = next(one for one in client.player.view.entities()
                     if client.session.world.types[client.player.view.at(one).type].name == b"crate")
        client.session.command(SANDBOX.enums["COMMAND_PUSH"], SANDBOX.encode("Push", {"entity": crate}))
        denied = lambda: [(one.command_kind, one.reason) for one in self.events(client, "EVENT_DENIED", "Denied")]
        moved = lambda: client.player.view.at(crate).motion > 0
        self.assertTrue(client.run(5, lambda: denied() or moved()))
        self.assertTrue(moved() or denied()[0][0] == SANDBOX.enums["COMMAND_PUSH"] and denied()[0][1])
        client.session.quit()

    def test_comes_back_after_its_stream_broke(self):
        client = self.join()
        client.drive = walk
        client.run(1)
        before, avatar = client.player.own.tick, client.player.own.avatar
        client.session.cut()
        self.say_into_nothing(client, "one")
        client.session.resume()
        self.assertTrue(client.session.welcome.resumed)
        self.assertFalse(client.session.welcome.recovered)
        self.say(client, "two")
        self.assertTrue(client.run(5, lambda: "two" in self.said(client)))
        self.assertTrue(client.run(5, lambda: client.player.own.tick > before + 40))
        self.assertEqual(self.said(client), ["one", "two"])
        self.assertEqual((client.player.own.avatar, client.session.path.state), (avatar, wire_session.UDP))
        self.assertEqual([event.number for event in client.session.events],
                         list(range(1, client.session.last_event + 1)))
        self.assertGreater(self.exact(client), 8)
        client.session.quit()

    def say_into_nothing(self, client, text):
        """A chat line that the broken stream does not carry: it is sent when the session is back."""
        session = client.session
        session.last_command += 1
        session.commands[session.last_command] = {
            "number": session.last_command, "kind": SANDBOX.enums["COMMAND_CHAT"],
            "payload": SANDBOX.encode("Chat", {"topic": "world", "text": text})}

    def test_goes_on_inside_the_stream_and_back_to_udp(self):
        client = self.join()
        client.drive = walk
        client.session.udp_closed = True
        self.assertTrue(client.run(6, lambda: client.session.path.state == wire_session.STREAM))
        client.drive = lambda tick: (0, -127, 32768, 0, 0)
        client.run(0.5)  # commands that UDP lost are missing on the server
        since = before = client.player.own.tick
        self.assertTrue(client.run(3, lambda: client.player.own.tick > before + 30))
        self.assertGreater(self.exact(client, since), 3)
        client.session.udp_closed = False
        self.assertTrue(client.run(4, lambda: client.session.path.state == wire_session.UDP))
        before = client.player.own.tick
        self.assertTrue(client.run(3, lambda: client.player.own.tick > before + 30))
        self.assertEqual(client.session.path.state, wire_session.UDP)
        self.assertEqual(client.player.troubles, [])
        client.session.quit()


class Tickets(unittest.TestCase):
    """A server that lets in players with a ticket alone."""

    def zoned(self, *words):
        """A command of zoned."""
        subprocess.run([game_server.BUILD / "zoned", *words], check=True, stdout=subprocess.DEVNULL)

    def refused(self, server, reason, **hello):
        """A login that fails."""
        with self.assertRaises(Refused) as caught:
            WireClient("127.0.0.1", server.port, **hello)
        self.assertEqual(caught.exception.reason, SCHEMA.enums[reason], caught.exception)

    def test_opens_one_session_of_its_account(self):
        with game_server.scratch() as folder:
            self.zoned("keygen", folder / "operator")
            self.zoned("ticket", "--key", folder / "operator.key", "--account", "ann", "--right", "play", "--out",
                       folder / "ann.ticket")
            ticket = (folder / "ann.ticket").read_bytes()
            settings = ["session.dev_mode_loopback=false", f'session.ticket_public_key_file="{folder}/operator.pub"']
            with game_server.serve(settings=settings) as server:
                self.refused(server, "REFUSED_TICKET", name="Ann")
                self.refused(server, "REFUSED_TICKET", ticket=ticket[:-1] + bytes([ticket[-1] ^ 1]))
                certificate = next(path for path in sorted(server.state.iterdir())
                                   if b"BEGIN CERTIFICATE" in path.read_bytes())
                pin = hashlib.sha256(ssl.PEM_cert_to_DER_cert(certificate.read_text())).digest()
                with self.assertRaisesRegex(ConnectionError, "pinned"):
                    WireClient("127.0.0.1", server.port, ticket=ticket, certificate_sha256=bytes(32))
                client = WireClient("127.0.0.1", server.port, ticket=ticket, certificate_sha256=pin)
                self.assertTrue(client.run(5, lambda: client.player.own))
                self.assertEqual(client.session.welcome.rights, 1)
                self.refused(server, "REFUSED_TICKET", ticket=ticket)
                client.session.quit()

    def test_another_protocol_or_config_is_refused(self):
        with game_server.serve() as server:
            self.refused(server, "REFUSED_PROTOCOL_VERSION", name="Ann", protocol_version=6)
            self.refused(server, "REFUSED_CONFIG_DIGEST", name="Ann", config_digest="c0ffee")
            self.refused(server, "REFUSED_MALFORMED", name="A" * 33)


if __name__ == "__main__":
    unittest.main()

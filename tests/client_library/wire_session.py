"""A session by proto/WIRE.md: its stream (section 8), and the path of its datagrams (section 9)."""

import heapq
import pathlib
import random
import select
import socket
import time

import proto_messages
import wire_datagrams
from openssl import TlsStream

PROTO = pathlib.Path(__file__).resolve().parents[2] / "proto"
SCHEMA = proto_messages.Schema(PROTO / "session.proto")
PROTOCOL_VERSION = 8
PATIENCE_S = 10.0
SILENCE_S, SURE_S, ASKS_ONE_IN, PROBES_ONE_IN = 2.0, 0.5, 8, 30
UDP, ASKING, STREAM = "UDP", "asking", "stream"


class Refused(Exception):
    """The server's answer to Hello."""

    def __init__(self, refused):
        super().__init__(refused.text.decode())
        self.reason = refused.reason


class Network:
    """What becomes of datagrams on their way: a share is lost, all are late, some later than others."""

    def __init__(self, loss=0.0, delay_s=0.0, jitter_s=0.0, seed=1):
        self.loss, self.delay_s, self.jitter_s = loss, delay_s, jitter_s
        self.dice = random.Random(seed)
        self.on_the_way, self.count = [], 0

    def put(self, now, datagram):
        """Begins its way."""
        if self.dice.random() >= self.loss:
            self.count += 1
            due = now + self.delay_s + self.jitter_s * self.dice.random()
            heapq.heappush(self.on_the_way, (due, self.count, datagram))

    def take(self, now):
        """Those that have arrived."""
        while self.on_the_way and self.on_the_way[0][0] <= now:
            yield heapq.heappop(self.on_the_way)[2]


class DatagramPath:
    """Which way datagrams go up: by UDP, or inside the stream where UDP does not get through."""

    def __init__(self, now):
        self.state, self.heard, self.answered, self.count = UDP, now, None, 0

    def came(self, now, by_udp):
        """A datagram that opened."""
        if by_udp:
            self.state, self.heard, self.answered = UDP, now, None
        elif self.state == ASKING and self.answered is None:
            self.answered = now

    def next_by_udp(self, now):
        """The way of the next one."""
        if self.state == UDP and now > self.heard + SILENCE_S:
            self.state, self.count = ASKING, 0
        if self.state == ASKING and self.answered is not None and now > self.answered + SURE_S:
            self.state, self.count = STREAM, 0
        self.count += 1
        if self.state == ASKING:
            return self.count % ASKS_ONE_IN != 1
        return self.state == UDP or self.count % PROBES_ONE_IN == 0


class Session:
    """`welcome` is the newest one; `world` the first one's. Times are those of `time.monotonic`."""

    def __init__(self, host, port, up=None, down=None, certificate_sha256=None, **hello):
        self.host, self.port, self.hello, self.certificate = host, port, hello, certificate_sha256
        self.up, self.down = up or Network(), down or Network()
        self.udp_closed = False
        self.events, self.last_event = [], 0
        self.commands, self.last_command = {}, 0
        self.audits, self.joined, self.closing = [], None, None
        self.sequence = 0
        self.incoming = self.world = self.udp = None
        self.log_in({})

    def log_in(self, more):
        """Connects, and says hello; a refusal ends the stream."""
        self.stream, self.bytes_in = TlsStream(self.host, self.port, self.certificate), b""
        try:
            self.say_hello(more)
        except (Refused, ConnectionError):
            self.stream.close()
            raise

    def say_hello(self, more):
        """Until there is an answer."""
        self.send("hello", {"protocol_version": PROTOCOL_VERSION, **self.hello, **more})
        self.welcome, end = None, time.monotonic() + PATIENCE_S
        while not self.welcome:
            if time.monotonic() > end:
                raise ConnectionError("no answer to Hello")
            select.select([self.stream.socket], [], [], 0.1)
            self.read_stream()
        self.begin()

    def begin(self):
        """After Welcome."""
        welcome = self.welcome
        self.up_seal, down_seal = [wire_datagrams.Seal(key)
                                   for key in (welcome.datagram_key_up, welcome.datagram_key_down)]
        self.world = welcome.world or self.world
        if self.incoming and not welcome.recovered:
            self.incoming.seal = down_seal
        else:
            self.incoming, self.sequence = wire_datagrams.Incoming(welcome.connection_id, down_seal), 0
        if self.udp:
            self.udp.close()
        address = self.stream.socket.getpeername()[0]
        self.udp = socket.socket(self.stream.socket.family, socket.SOCK_DGRAM)
        self.udp.connect((address, welcome.udp_port))
        self.udp.setblocking(False)
        self.path = DatagramPath(time.monotonic())

    def resume(self):
        """Comes back on a new stream; commands that the server has not carried out are sent again."""
        self.log_in({"resume_token": self.welcome.resume_token, "last_event": self.last_event})
        for number in sorted(self.commands):
            if number <= self.welcome.last_command:
                del self.commands[number]
            else:
                self.send("command", self.commands[number])

    def send(self, name, values):
        """A message with its frame."""
        body = SCHEMA.encode("ClientMessage", {name: values})
        self.stream.write(len(body).to_bytes(4, "little") + body)

    def command(self, kind, payload):
        """A command of the game: it comes exactly once."""
        self.last_command += 1
        self.commands[self.last_command] = {"number": self.last_command, "kind": kind, "payload": payload}
        self.send("command", self.commands[self.last_command])

    def quit(self):
        """Leaves."""
        self.send("quit", {})
        self.close()

    def close(self):
        """Ends the stream."""
        self.stream.close()
        self.udp.close()

    def cut(self):
        """Loses the stream as a broken network would."""
        self.stream.cut()

    def read_stream(self):
        """Messages that have come; returns datagrams among them."""
        self.stream.write()
        self.bytes_in += self.stream.read()
        datagrams, before = [], self.last_event
        while len(self.bytes_in) >= 4:
            size = int.from_bytes(self.bytes_in[:4], "little")
            if size > 2 ** 24:
                raise ConnectionError(f"a frame of {size} bytes")
            if len(self.bytes_in) < 4 + size:
                break
            message = SCHEMA.decode("ServerMessage", self.bytes_in[4:4 + size])
            self.bytes_in = self.bytes_in[4 + size:]
            self.take(message, datagrams)
        if self.last_event > before:
            self.send("event_ack", {"through": self.last_event})
        return datagrams

    def take(self, message, datagrams):
        """One message."""
        kind = message.which[-1] if message.which else ""
        if kind == "welcome":
            self.welcome = message.welcome
        elif kind == "refused":
            raise Refused(message.refused)
        elif kind == "event":
            self.take_event(message.event)
        elif kind == "command_ack":
            for number in [number for number in self.commands if number <= message.command_ack.through]:
                del self.commands[number]
        elif kind == "datagram":
            datagrams.append(message.datagram.sealed)
        elif kind == "audit":
            self.audits.append(message.audit)
        elif kind == "joined":
            self.joined = message.joined
        elif kind == "closing":
            self.closing = message.closing

    def take_event(self, event):
        """Each number once, in order."""
        if event.number <= self.last_event:
            return
        if event.number != self.last_event + 1:
            raise ConnectionError(f"event {event.number} after {self.last_event}")
        self.last_event = event.number
        self.events.append(event)
        if event.confirm:
            self.send("confirm", {"event_id": event.event_id})

    def send_datagram(self, now, body):
        """A packet with the transport; returns its sequence."""
        self.sequence += 1
        plain = self.incoming.transport(int(now * 1e6)) + body
        datagram = self.up_seal.write(self.incoming.connection, self.sequence, plain)
        if self.path.next_by_udp(now):
            self.up.put(now, datagram)
        else:
            self.send("datagram", {"sealed": datagram})
        self.send_due(now)
        return self.sequence

    def send_due(self, now):
        """Datagrams whose way up has ended."""
        for datagram in self.up.take(now):
            if not self.udp_closed:
                try:
                    self.udp.send(datagram)
                except OSError:
                    pass

    def read_datagrams(self, now):
        """Sequence and plain bytes of all that have come and open, by UDP and in the stream."""
        found = [(datagram, False) for datagram in self.read_stream()]
        self.send_due(now)
        while True:
            try:
                datagram = self.udp.recv(2048)
            except OSError:
                break
            if not self.udp_closed:
                self.down.put(now, datagram)
        found += [(datagram, True) for datagram in self.down.take(now)]
        opened = []
        for datagram, by_udp in found:
            packet = self.incoming.open(datagram)
            if packet:
                self.path.came(now, by_udp)
                opened.append(packet)
        return opened

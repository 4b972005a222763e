"""A client in Python, written from proto/WIRE.md and the files beside it alone: it logs in, sees, predicts and plays.

It shares no code with the server. `wire_session` has the stream and the path of datagrams, `wire_player` what they say;
`wire_datagrams`, `wire_records`, `coded_records` and `wire_motion` are sections of the page."""

import collections
import math
import select
import time

import wire_datagrams
import wire_motion
from wire_player import Player
from wire_session import Session

FIRST_DATAGRAMS_S = 0.05
MOST_COMMANDS = 8
ACKNOWLEDGE_EVERY = 16
REFUSALS_UNTIL_RESET = 3
FIRST_LEAD_TICKS, LEAST_LEAD_TICKS = 3.0, 1.0


class Clock:
    """The server's tick by the send times of its packets; all times are those of `time.monotonic`."""

    def __init__(self, tick_s):
        self.tick_s = tick_s
        self.offsets, self.round_trips = collections.deque(maxlen=64), collections.deque(maxlen=64)

    def heard(self, now, tick, send_time_us):
        """A state packet came. Its send time counts from tick 0; the upper bits follow from its tick."""
        begin_us = round(tick * self.tick_s * 1e6)
        sent_us = begin_us + (send_time_us - begin_us + 2 ** 31) % 2 ** 32 - 2 ** 31
        self.offsets.append(now - 1e-6 * sent_us)

    def known(self):
        """Whether ticks can be told."""
        return bool(self.offsets and self.round_trips)

    def heard_tick(self, now):
        """The tick at which a fast packet left that would come now."""
        return (now - min(self.offsets)) / self.tick_s

    def round_trip_ticks(self):
        """The slowest one of late."""
        return max(self.round_trips) / self.tick_s

    def server_tick(self, now):
        """The tick at which the server is, half a round trip ahead."""
        return self.heard_tick(now) + 0.5 * min(self.round_trips) / self.tick_s


class WireClient:
    """`drive` gives move_x, move_z, yaw, pitch and buttons of a tick, or None to leave the tick out.

    `journal` holds what came and what was made, so that another `Player` can go through it again."""

    def __init__(self, host, port, **session):
        self.session = Session(host, port, **session)
        self.player = Player(self.session.world)
        self.clock = Clock(1 / self.session.world.tick_rate_hz)
        self.drive = lambda tick: (0, 0, 0, 0, 0)
        self.journal, self.on_audit = [], lambda audit: None
        self.lead_ticks, self.leads, self.made = FIRST_LEAD_TICKS, collections.deque(maxlen=30), None
        self.sent, self.sent_last = {}, -math.inf
        self.refused_in_a_row = 0

    def poll(self):
        """Reads all that has come, then sends what is due."""
        now = time.monotonic()
        for count, (sequence, plain) in enumerate(self.session.read_datagrams(now), 1):
            self.read_packet(now, sequence, plain)
            if count % ACKNOWLEDGE_EVERY == 0:
                self.send(now, b"")
        while self.session.audits:
            self.on_audit(self.session.audits.pop(0))
        self.make_commands(now)
        if now > self.sent_last + FIRST_DATAGRAMS_S:
            self.send(now, b"")

    def run(self, seconds, until=lambda: False):
        """Polls for some time, or until a condition holds; whether it does."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.poll()
            if until():
                return True
            select.select([self.session.stream.socket, self.session.udp], [], [], 0.004)
        return until()

    def send(self, now, body):
        """A datagram, noted for its round trip."""
        sequence = self.session.send_datagram(now, body)
        self.sent[sequence], self.sent_last = now, now
        self.sent.pop(sequence - 1024, None)

    def read_packet(self, now, sequence, plain):
        """One state packet."""
        transport = wire_datagrams.DownTransport(plain)
        self.measure(now, transport)
        self.journal.append(("packet", sequence, plain[12:]))
        before = self.player.own
        head, accepted = self.player.take_packet(sequence, plain[12:])
        self.clock.heard(now, head.tick, transport.send_time_us)
        if accepted:
            self.session.incoming.accept(sequence, int(now * 1e6), transport.send_time_us)
        self.ask_for_reset(head, sequence, accepted)
        if self.player.own is not before and self.made is not None:
            self.adjust_lead(self.player.own)

    def measure(self, now, transport):
        """Round trip by what the server acknowledges."""
        acknowledged = wire_datagrams.whole_sequence(transport.ack, self.session.sequence)
        if transport.ack and acknowledged in self.sent and transport.ack_delay_10us < 65535:
            self.clock.round_trips.append(max(0.0, now - self.sent[acknowledged] - transport.ack_delay_10us * 1e-5))

    def ask_for_reset(self, head, sequence, accepted):
        """After packets in a row that ought to have been decoded."""
        if accepted:
            self.refused_in_a_row = 0 if head.coded else self.refused_in_a_row
        elif sequence > self.player.coded.newest:
            self.refused_in_a_row += 1
            if self.refused_in_a_row == REFUSALS_UNTIL_RESET:
                self.refused_in_a_row = 0
                self.session.send("view_reset", {"reason": self.player.troubles[-1]})

    def adjust_lead(self, own):
        """Commands are made earlier when one was late, and later when all were early for a while."""
        self.leads.append(own.lead)
        if own.lead < 1:
            self.lead_ticks += 1
            self.leads.clear()
        elif len(self.leads) == self.leads.maxlen and min(self.leads) > FIRST_LEAD_TICKS + 1:
            self.lead_ticks -= 0.5
            self.leads.clear()

    def make_commands(self, now):
        """Commands of all ticks up to the one that has to leave now."""
        if not self.player.own or not self.clock.known():
            return
        target = math.floor(self.clock.heard_tick(now) + self.clock.round_trip_ticks() + self.lead_ticks)
        if self.made is None or target > self.made + MOST_COMMANDS:
            self.made = target - 1
        if target <= self.made:
            return
        arrives = self.clock.heard_tick(now) + self.clock.round_trip_ticks()
        for tick in range(self.made + 1, target + 1):
            wanted, late = self.drive(tick), tick < arrives + LEAST_LEAD_TICKS
            self.journal.append(("tick", tick, (wanted, late)))
            self.player.take_tick(tick, wanted, late)
        self.made = target
        self.send(now, self.newest_commands())

    def newest_commands(self):
        """Body with the newest ones, without a gap between them; they are repeated while nothing new is made."""
        commands, found = self.player.prediction.commands, []
        last = max(commands, default=0)
        while len(found) < MOST_COMMANDS and last - len(found) in commands:
            found.insert(0, commands[last - len(found)])
        return wire_motion.write_commands(found) if last > self.made - MOST_COMMANDS else b""


def replay(world, journal):
    """A player that goes through a journal again."""
    player = Player(world)
    for kind, number, data in journal:
        if kind == "packet":
            player.take_packet(number, data)
        else:
            player.take_tick(number, *data)
    return player

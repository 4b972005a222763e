"""Datagrams of proto/WIRE.md: sections 1 (header, seal), 2 (transport) and the head of section 3."""

import struct

import openssl

KEY_BYTES, SALT_BYTES = 16, 12
REPLAY_WINDOW = 1024
UNBOUNDED = 63


class Seal:
    """Keys of one direction of a session: 16 bytes of key and 12 of salt."""

    def __init__(self, material):
        self.key, self.salt = material[:KEY_BYTES], material[KEY_BYTES:]

    def nonce(self, sequence):
        """The salt, its last 8 bytes XORed with the sequence."""
        return (int.from_bytes(self.salt, "big") ^ sequence).to_bytes(SALT_BYTES, "big")

    def write(self, connection, sequence, plain):
        """A datagram."""
        head = struct.pack("<IH", connection, sequence & 0xFFFF)
        return head + openssl.seal(self.key, self.nonce(sequence), head, plain)

    def read(self, datagram, sequence):
        """Its plain bytes; None where it does not open."""
        return openssl.unseal(self.key, self.nonce(sequence), datagram[:6], datagram[6:])


def whole_sequence(low, newest):
    """The sequence nearest to the one expected, newest + 1, that has these 16 bits."""
    expected = newest + 1
    found = expected & ~0xFFFF | low
    if found <= expected - 0x8000:
        return found + 0x10000
    return found - 0x10000 if found > expected + 0x8000 and found >= 0x10000 else found


class Incoming:
    """Datagrams of the server: opens them, refuses those that came before, and acknowledges."""

    def __init__(self, connection, seal):
        self.connection, self.seal = connection, seal
        self.newest = 0
        self.seen, self.accepted = set(), {}
        self.refused = 0

    def open(self, datagram):
        """Sequence and plain bytes; None where the datagram is dropped."""
        if len(datagram) < 22 or struct.unpack_from("<I", datagram)[0] != self.connection:
            return self.refuse()
        sequence = whole_sequence(struct.unpack_from("<H", datagram, 4)[0], self.newest)
        if sequence in self.seen or sequence <= self.newest - REPLAY_WINDOW:
            return self.refuse()
        plain = self.seal.read(datagram, sequence)
        if plain is None:
            return self.refuse()
        self.newest = max(self.newest, sequence)
        self.seen.add(sequence)
        if len(self.seen) > 2 * REPLAY_WINDOW:
            self.seen = {one for one in self.seen if one > self.newest - REPLAY_WINDOW}
        return sequence, plain

    def refuse(self):
        """Counts what is dropped."""
        self.refused += 1

    def accept(self, sequence, arrived_us, send_time_us):
        """It counts as accepted from now on."""
        self.accepted[sequence] = (arrived_us, (arrived_us - send_time_us) % 2 ** 32)
        if len(self.accepted) > 64:
            for one in sorted(self.accepted)[:-33]:
                del self.accepted[one]

    def transport(self, now_us):
        """The 10 bytes of the transport up."""
        if not self.accepted:
            return bytes(10)
        newest = max(self.accepted)
        arrived_us, difference = self.accepted[newest]
        bits = sum(1 << i for i in range(32) if newest - i - 1 in self.accepted)
        delay = min(65535, (now_us - arrived_us) // 10)
        return struct.pack("<HIHH", newest & 0xFFFF, bits, delay, difference // 128 & 0xFFFF)


class DownTransport:
    """The 12 bytes of the transport down."""

    def __init__(self, plain):
        self.send_time_us, self.ack, self.ack_bits, self.ack_delay_10us = struct.unpack_from("<IHIH", plain)


class Own:
    """Own state of a packet; `tick` is that of the command after which it is."""

    def __init__(self, avatar, tick, flags, lead, yaw, numbers):
        self.avatar, self.tick, self.lead, self.yaw = avatar, tick, lead, yaw
        self.missing, self.grounded, self.carried = bool(flags & 1), bool(flags & 2), bool(flags & 4)
        self.position, self.velocity = numbers[:3], numbers[3:]


class Head:
    """Head of a state packet; `records` are the bytes behind it."""

    def __init__(self, body):
        self.body, self.at = body, 4
        self.tick = struct.unpack_from("<I", body)[0]
        word = self.leb128()
        self.zone, self.coded = word >> 3, bool(word & 4)
        self.widened, self.incomplete = 0, False
        if word & 2:
            self.read_width()
        self.own = self.read_own() if word & 1 else None
        self.records = body[self.at:]

    def byte(self):
        """The next byte."""
        self.at += 1
        return self.body[self.at - 1]

    def leb128(self):
        """A number in its shortest form."""
        value = shift = 0
        while True:
            byte = self.byte()
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                break
        if byte == 0 and shift > 7 or value >= 2 ** 32:
            raise ValueError("a number that is not in its shortest form, or too great")
        return value

    def read_width(self):
        """By how much the bounds are wider."""
        byte = self.byte()
        self.widened, self.incomplete = byte & 63, bool(byte & 64)
        if byte & 128 or 40 < self.widened != UNBOUNDED:
            raise ValueError("a width of the bounds that is none")

    def read_own(self):
        """The own state."""
        avatar, age, flags = self.leb128(), self.leb128(), self.byte()
        lead, yaw, *numbers = struct.unpack_from("<bH6f", self.body, self.at)
        self.at += 27
        if avatar == 0 or age > self.tick or flags > 7:
            raise ValueError("an own state that is none")
        return Own(avatar, self.tick - age, flags, lead, yaw, tuple(numbers))

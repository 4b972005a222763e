"""The examples of coded records in proto/WIRE.md, read by a decoder that was written from that page alone."""

import os
import pathlib
import re
import subprocess
import unittest

from coded_records import REMOVE, DeclaredField, Decoder, Quantization

PAGE = pathlib.Path(__file__).resolve().parents[2] / "proto" / "WIRE.md"
WIDTHS = {"type": 1, "upright": 1, "lod": 1, "tick": 1, "motion": 1, "position": 3, "velocity": 3, "acceleration": 3,
          "turn": 3, "floor": 1, "orientation": 3, "orientation_largest": 1, "angular_velocity": 3, "appearance": 1}
NAMES = {"lod": "level", "orientation_largest": "left_out"}
TYPE_OF_THE_EXAMPLES = [DeclaredField(100, 100), DeclaredField(1000000), DeclaredField(2), DeclaredField(1),
                        DeclaredField(None, "")]


def blocks(kind):
    """Lines of each block of a kind, as pairs of a name and a text."""
    found = re.findall(rf"^```wire {kind}\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    return [[line.split(" = ", 1) for line in block.splitlines()] for block in found]


def told(line):
    """Kind, entity and fields of a line `record`."""
    kind, entity, *words = line.split()
    fields = {"entity": int(entity)}
    for name, width in WIDTHS.items():
        fields[NAMES.get(name, name)] = 0 if width == 1 else (0, 0, 0)
    while words:
        name, width = words[0], WIDTHS[words[0]]
        numbers = tuple(int(word) for word in words[1:1 + width])
        fields[NAMES.get(name, name)] = numbers[0] if width == 1 else numbers
        words = words[1 + width:]
    return kind, fields


class Examples(unittest.TestCase):
    """The decoder reads each record as its block says it."""

    def compare(self, line, publication):
        """A record with its line."""
        kind, fields = told(line)
        self.assertEqual(kind == "remove", publication.kind == REMOVE, line)
        if publication.kind == REMOVE:
            self.assertEqual(fields["entity"], publication.entity, line)
            return
        self.assertEqual(["known", "new", "", "", "moving"][publication.kind], kind, line)
        self.assertEqual(fields, {name: getattr(publication, name) for name in fields}, line)

    def play(self, kind, decoder, all_of_them):
        """All blocks of a kind."""
        for block in blocks(kind):
            values = dict(block)
            if "lost" in values and not all_of_them:
                continue
            records = decoder.decode(int(values["packet"]), int(values["tick"]), int(values.get("zone", 0)),
                                     bytes.fromhex(values["hex"]))
            lines = [text for name, text in block if name == "record"]
            self.assertEqual(len(lines), len(records), values["packet"])
            for line, record in zip(lines, records):
                self.compare(line, record)
            self.compare_declared(values, records)

    def compare_declared(self, values, records):
        """Declared fields of a block's record."""
        if "declared" in values:
            numbers = [int(word) for word in values["declared"].split()]
            for index, value in zip(numbers[::2], numbers[1::2]):
                self.assertEqual(records[0].declared[index], value)
        if "declared_text" in values:
            index, text = values["declared_text"].split(" ", 1)
            self.assertEqual(records[0].declared[int(index)], text)

    def test_all_packets(self):
        self.play("coded", Decoder(), True)

    def test_without_the_lost_packets(self):
        self.play("coded", Decoder(), False)

    def test_declared_fields(self):
        self.play("coded-declared", Decoder(declared_fields={3: TYPE_OF_THE_EXAMPLES}), True)

    def feed(self, decoder, number, code=None):
        """One block's packet, or another code in its place."""
        values = next(dict(block) for block in blocks("coded") if dict(block)["packet"] == str(number))
        code = bytes.fromhex(values["hex"]) if code is None else code
        return decoder.decode(number, int(values["tick"]), int(values["zone"]), code)

    def refused(self, reason, decoder, *packet):
        """A packet that must be refused."""
        with self.assertRaisesRegex(ValueError, reason):
            self.feed(decoder, *packet)

    def test_a_late_packet(self):
        decoder = Decoder()
        early = [self.feed(decoder, number)[0].tick for number in (1, 3, 2)]
        self.assertEqual(early, [100, 106, 104])

    def test_refused_packets(self):
        decoder = Decoder()
        self.refused("a packet that was not decoded is named", decoder, 2)
        self.feed(decoder, 1)
        self.refused("decoded before", decoder, 1)
        self.feed(decoder, 6)
        self.refused("another epoch", decoder, 3)

    def test_refused_lengths(self):
        code = bytes.fromhex(dict(blocks("coded")[0])["hex"])
        for end in range(len(code)):
            self.refused("", Decoder(), 1, code[:end])
        self.refused("", Decoder(), 1, code[:8] + bytes(8) + code[8:])

    def test_changed_bytes_are_read_or_refused(self):
        code = bytes.fromhex(dict(blocks("coded")[0])["hex"])
        for place in range(len(code)):
            changed = code[:place] + bytes([code[place] ^ 1 << place % 8]) + code[place + 1:]
            try:
                self.feed(Decoder(), 1, changed)
            except ValueError as refusal:
                self.assertTrue(str(refusal))


class Streams(unittest.TestCase):
    """Long streams of the server's own encoder, of which packets are lost and late."""

    def values(self, record):
        """All that a stream says of a record."""
        if record.kind == REMOVE:
            return [record.entity]
        return [record.entity, record.type, int(record.upright), record.tick, record.level, record.motion,
                *record.position, *record.velocity, *record.acceleration, *record.turn, *record.orientation,
                *record.angular_velocity, record.left_out, record.appearance, record.floor]

    def play(self, seed):
        """One stream."""
        program = pathlib.Path(os.environ["ZONED_BINARY_DIR"]) / "coded-stream"
        told = subprocess.run([program, str(seed), "300"], capture_output=True, text=True, check=True).stdout
        decoder = Decoder(Quantization(lod_shift=((0, 0), (1, 1), (2, 1), (4, 3))))
        plain = 0
        for part in told.split("packet ")[1:]:
            head, *lines = part.splitlines()
            number, tick, zone, lost, code = head.split()
            if lost == "1":
                continue
            records = decoder.decode(int(number), int(tick), int(zone), bytes.fromhex(code))
            self.assertEqual([[int(word) for word in line.split()] for line in lines],
                             [self.values(record) for record in records], number)
            plain += sum(record.plain for record in records)
        self.assertGreater(plain, 10)

    def test_streams_of_the_encoder(self):
        for seed in (1, 2):
            self.play(seed)


if __name__ == "__main__":
    unittest.main()

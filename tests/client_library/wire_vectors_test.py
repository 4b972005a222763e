"""The examples of proto/WIRE.md against the client in Python that was written from the page."""

import math
import pathlib
import struct
import types
import unittest

import proto_messages
import wire_datagrams
import wire_motion
import wire_records
import wire_session
from coded_records import Quantization, single
from coded_records_test import NAMES, TYPE_OF_THE_EXAMPLES, WIDTHS, blocks

PROTO = pathlib.Path(__file__).resolve().parents[2] / "proto"
DEFAULT = Quantization()


def bytes_of(block, name="hex"):
    """A line of hexadecimal bytes."""
    return bytes.fromhex(dict(block)[name])


def numbers(text):
    """Numbers of a line."""
    return [float(word) for word in text.split()]


class Datagrams(unittest.TestCase):
    """Sections 1 to 3, 8 and 9."""

    def test_sealed(self):
        for block in blocks("sealed-datagram") + blocks("first-datagram"):
            values = dict(block)
            seal = wire_datagrams.Seal(bytes_of(block, "key") + bytes_of(block, "salt"))
            sealed = seal.write(int(values["connection"]), int(values["sequence"]), bytes_of(block, "plain"))
            self.assertEqual(sealed, bytes_of(block))
            incoming = wire_datagrams.Incoming(int(values["connection"]), seal)
            incoming.newest = int(values["sequence"]) - 1
            self.assertIsNone(incoming.open(sealed[:-1] + bytes([sealed[-1] ^ 1])))
            self.assertEqual(incoming.open(sealed), (int(values["sequence"]), bytes_of(block, "plain")))
            self.assertIsNone(incoming.open(sealed))
            self.assertEqual(incoming.refused, 2)

    def test_sequences_wrap(self):
        for newest, sequence in ((0, 1), (65535, 65536), (65536, 65530), (131071, 131073), (3, 1),
                                 (131000, 131001 + 32767), (69999, 70000 - 32767)):
            self.assertEqual(wire_datagrams.whole_sequence(sequence & 0xFFFF, newest), sequence)

    def test_transports(self):
        for block in blocks("down-transport"):
            transport = wire_datagrams.DownTransport(bytes_of(block))
            for name in ("send_time_us", "ack", "ack_bits", "ack_delay_10us"):
                self.assertEqual(getattr(transport, name), int(dict(block)[name]))
        block, = blocks("up-transport")
        values = {name: int(text) for name, text in block if name != "hex"}
        incoming = wire_datagrams.Incoming(7, None)
        for back in range(1, 33):
            if values["ack_bits"] >> back - 1 & 1:
                incoming.accept(values["ack"] - back, 0, 0)
        incoming.accept(values["ack"], values["one_way_128us"] * 128 + 5, 0)
        self.assertEqual(incoming.transport(10 ** 6 + values["one_way_128us"] * 128), bytes_of(block))

    def test_acknowledgements_name_each_of_those_before(self):
        incoming = wire_datagrams.Incoming(7, None)
        self.assertEqual(incoming.transport(0), bytes(10))
        for sequence in (100, 98, 68, 67):
            incoming.accept(sequence, 0, 0)
        self.assertEqual(struct.unpack_from("<HI", incoming.transport(0)), (100, 1 << 1 | 1 << 31))

    def test_heads(self):
        for block in blocks("down-head"):
            values, head = dict(block), wire_datagrams.Head(bytes_of(block))
            self.assertEqual((head.tick, head.zone), (int(values["tick"]), int(values["zone"])))
            self.assertEqual((head.widened, head.incomplete),
                             (int(values.get("widened", 0)), values.get("incomplete") == "1"))
            self.assertEqual((head.coded, head.records), (False, b""))
            self.assertEqual(head.own is not None, "avatar" in values)
            if head.own:
                own = head.own
                told = [own.avatar, head.tick - own.tick, own.lead, own.yaw]
                self.assertEqual(told, [int(values[name]) for name in ("avatar", "age", "input_lead", "yaw")])
                self.assertEqual((own.missing, own.grounded, own.carried), (True, True, False))
                self.assertEqual([*own.position, *own.velocity],
                                 [single(one) for one in numbers(values["position"] + " " + values["velocity"])])

    def test_messages_come_back(self):
        schema = proto_messages.Schema(PROTO / "session.proto")
        values = {"entity": 300, "position": [1.5, -2.0], "distance_m": 0.25, "breach_tick": -7,
                  "quantized": [-64, 63, 0], "must_know": True}
        message = schema.decode("AuditEntity", schema.encode("AuditEntity", values))
        self.assertEqual({name: getattr(message, name) for name in values}, values)

    def test_frames(self):
        schema = proto_messages.Schema(PROTO / "session.proto")
        hello, = blocks("hello-frame")
        values = {"protocol_version": wire_session.PROTOCOL_VERSION, "name": "Ann"}
        body = schema.encode("ClientMessage", {"hello": values})
        self.assertEqual(len(body).to_bytes(4, "little") + body, bytes_of(hello))
        refused, = blocks("refused-frame")
        message = schema.decode("ServerMessage", bytes_of(refused)[4:])
        self.assertEqual(message.which, ["refused"])
        self.assertEqual(message.refused.reason, schema.enums["REFUSED_PROTOCOL_VERSION"])
        self.assertIn(b"version 6", message.refused.text)
        first, = blocks("first-datagram")
        body = schema.encode("ClientMessage", {"datagram": {"sealed": bytes_of(first)}})
        self.assertEqual(len(body).to_bytes(4, "little") + body, bytes_of(first, "frame"))


class Records(unittest.TestCase):
    """Sections 4, 5 and 5a."""

    def reference(self, decoder, values):
        """The keyframe that a delta of the examples refers to."""
        entity = int(values["entity"])
        publication = wire_records.Publication(entity, wire_records.NEW, 0, 0)
        publication.type, publication.upright = 3, values["upright"] == "1"
        fields = decoder.declared_fields.get(3, ()) if "declared" in values else ()
        publication.declared = wire_records.initial_values(fields)
        self.put(publication, {name[10:]: text for name, text in values.items() if name.startswith("reference.")})
        key = (0, entity, int(values.get("lod", 0)))
        decoder.keyframes[key] = {int(values["keyframe"]): (publication, 0)}

    @staticmethod
    def put(publication, values):
        """Fields of a block."""
        for name, width in WIDTHS.items():
            if name in values:
                told = tuple(int(word) for word in values[name].split())
                setattr(publication, NAMES.get(name, name), told[0] if width == 1 else told)

    def read(self, kind, block):
        """A record against its block."""
        values = dict(block)
        decoder = wire_records.SharedDecoder(DEFAULT, {3: TYPE_OF_THE_EXAMPLES} if "declared" in values else {})
        if kind == "delta":
            self.reference(decoder, values)
        tick = int(values.get("tick_low", 0)) + 512
        records, trouble = decoder.decode(1, tick, 0, bytes_of(block))
        self.assertIsNone(trouble)
        record, = records
        self.assertEqual(record.entity, int(values["entity"]))
        if kind == "remove":
            self.assertEqual(record.kind, wire_records.REMOVE)
            return decoder
        self.assertEqual((record.tick, record.level), (tick, int(values["lod"])))
        for name, width in WIDTHS.items():
            if name in ("tick", "type", "lod", "upright"):
                continue
            told = values.get(name, "0" if width == 1 else "0 0 0")
            told = tuple(int(word) for word in told.split())
            self.assertEqual(getattr(record, NAMES.get(name, name)), told[0] if width == 1 else told, name)
        self.compare_declared(values, record)
        return decoder

    def compare_declared(self, values, record):
        """Declared fields of a block."""
        told = [int(word) for word in values.get("declared", "").split()]
        for index, value in zip(told[::2], told[1::2]):
            self.assertEqual(record.declared[index], value)

    def test_examples(self):
        for kind in ("absolute", "delta", "remove"):
            found = blocks(kind)
            self.assertGreater(len(found), 0)
            for block in found:
                self.read(kind, block)

    def test_records_that_are_cut_off_are_refused(self):
        for block in blocks("absolute"):
            data = bytes_of(block)
            declared = {3: TYPE_OF_THE_EXAMPLES} if "declared" in dict(block) else {}
            for end in range(1, len(data)):
                self.assertTrue(wire_records.SharedDecoder(DEFAULT, declared).decode(1, 512, 0, data[:end])[1], end)

    def test_changed_bits_are_read_or_refused(self):
        refused = 0
        for block in blocks("absolute"):
            data = bytes_of(block)
            declared = {3: TYPE_OF_THE_EXAMPLES} if "declared" in dict(block) else {}
            for bit in range(8 * len(data)):
                changed = bytearray(data)
                changed[bit // 8] ^= 1 << bit % 8
                refused += bool(wire_records.SharedDecoder(DEFAULT, declared).decode(1, 512, 0, bytes(changed))[1])
        self.assertGreater(refused, 50)

    def test_a_form_that_is_wider_than_needed_is_refused(self):
        for width, value, good in ((1, 255, False), (1, 256, True), (0, 255, True), (3, 65535, False)):
            bits = wire_motion.BitWriter()
            for number, count in ((2, 2), (width, 2), (value, (8, 12, 16, 32)[width])):
                bits.put(number, count)
            _, trouble = wire_records.SharedDecoder(DEFAULT, {}).decode(1, 512, 0, bits.bytes())
            self.assertEqual(trouble is None, good, value)

    def test_a_delta_without_its_keyframe_is_passed_over(self):
        for block in blocks("delta"):
            if "declared" not in dict(block):
                decoder = wire_records.SharedDecoder(DEFAULT, {})
                remove = bytes_of(blocks("remove")[0])
                records, trouble = decoder.decode(1, 512, 0, bytes_of(block) + remove)
                self.assertEqual((len(records), trouble, decoder.passed_over), (1, None, 1))


class Motion(unittest.TestCase):
    """Sections 5, 6 and 6a."""

    def limits(self):
        """The page's character."""
        block, = blocks("character")
        return types.SimpleNamespace(**{name: single(float(text)) for name, text in block})

    def test_landings(self):
        for block in blocks("landing"):
            publication = wire_records.Publication(1, wire_records.NEW, 0, 0)
            values = dict(block)
            publication.motion, publication.floor = 4, int(values["floor_y"])
            publication.position, publication.velocity = [
                tuple(int(word) for word in values[name].split()) for name in ("position", "velocity")]
            level, gravity = DEFAULT.levels[0], DEFAULT.gravity_mps2
            time = wire_motion.landing_time(publication.position[1] * level.position,
                                            publication.velocity[1] * level.velocity,
                                            publication.floor * level.position, gravity)
            self.assertAlmostEqual(time, float(values["landing_s"]), delta=1e-6)
            for name, text in block:
                if name == "at":
                    after, *place = numbers(text)
                    found = wire_motion.predict_position(publication, level, gravity, after)
                    self.assertLess(math.dist(found, place), 2e-6)

    def test_a_turning_acceleration_leads_in_a_circle(self):
        publication = wire_records.Publication(1, wire_records.NEW, 0, 0)
        publication.motion, publication.velocity = 5, (0, 0, 128)
        publication.acceleration, publication.turn = (64, 0, 0), (0, 32, 0)
        for t in (1e-5, 0.5, 2.0):  # 2 m/s at 1 rad/s: a radius of 2 m about (2, 0, 0)
            place = wire_motion.predict_position(publication, DEFAULT.levels[0], 9.81, t)
            self.assertLess(math.dist(place, (2 - 2 * math.cos(t), 0, 2 * math.sin(t))), 1e-9)

    def test_commands(self):
        block, = blocks("commands")
        tick = int(dict(block)["tick"])
        commands = [wire_motion.Command(tick + i, *[int(word) for word in text.split()])
                    for i, text in enumerate(text for name, text in block if name == "command")]
        self.assertEqual(wire_motion.write_commands(commands), bytes_of(block))

    def test_differences_of_yaw_take_nine_bits_as_far_as_they_go(self):
        for yaw, count in ((255, 9), (-256, 9), (256, 16), (-257, 16)):
            body = wire_motion.write_commands([wire_motion.Command(0, yaw=yaw % 65536)])
            self.assertEqual(len(body), (3 + 32 + 3 + 2 + count + 2 + 7) // 8, yaw)

    def test_moves_to_the_bit(self):
        limits = self.limits()
        for block in blocks("moves"):
            values, commands = dict(block), []
            dt = single(1 / float(values["tick_rate_hz"]))
            x = numbers(values["before"])
            state = wire_motion.AvatarState(tuple(map(single, x[:3])), tuple(map(single, x[3:6])), x[6] == 1)
            for name, text in block:
                if name == "command":
                    command = wire_motion.Command(int(values["tick"]) + len(commands), *map(int, text.split()))
                    commands.append(command)
                    state = wire_motion.apply_command(state, command, limits, dt, 0.0)
                elif name == "after":
                    told = [single(one) for one in numbers(text)]
                    self.assertEqual([*state.position, *state.velocity, float(state.grounded)], told, text)
            self.assertEqual(wire_motion.write_commands(commands), bytes_of(block))

    def test_missing_inputs(self):
        block, = blocks("missing-inputs")
        command = wire_motion.Command(1000, *map(int, dict(block)["command"].split()))
        for name, text in block:
            if name == "repeated":
                tick, *told = map(int, text.split())
                found = wire_motion.missing_command(command, tick, single(1 / 30))
                self.assertEqual(found, wire_motion.Command(tick, *told))


if __name__ == "__main__":
    unittest.main()

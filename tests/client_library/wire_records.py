"""Records of proto/WIRE.md that are one for all clients: sections 4, 5 and 5a."""

import math

from coded_records import KNOWN, NEW, REMOVE, Publication, check, greatest_of, initial_values, rounded

ABSOLUTE, DELTA, REMOVAL, DECLARED = range(4)
ENTITY_WIDTHS, TYPE_WIDTHS, PART_WIDTHS = (8, 12, 16, 32), (4, 8, 12, 16), (5, 8, 10, 12)
FULL = 99
PLACE = ((8, 12, 15, FULL), (0, 5, 9, FULL))
RATE = ((0, 5, 8, FULL),) * 2
FAST = ((0, 7, 10, FULL),) * 2
SLOW_TURN = ((0, 6, 8, FULL),) * 2


class Bits:
    """A bit stream, the least significant bit of the first byte first."""

    def __init__(self, data):
        self.number, self.count, self.at = int.from_bytes(data, "little"), 8 * len(data), 0

    def take(self, width):
        """A number of so many bits."""
        check(self.at + width <= self.count, "a record that is cut off")
        self.at += width
        return self.number >> (self.at - width) & (1 << width) - 1

    def narrowest(self, widths):
        """A number behind the selector of its width, which is the narrowest that holds it."""
        selector = self.take(2)
        value = self.take(widths[selector])
        check(selector == 0 or value >> widths[selector - 1], "a wider form than needed")
        return value

    def pad(self):
        """Zeros up to the next byte."""
        check(self.take(-self.at % 8) == 0, "padding that is not zero")


class Fields:
    """Reads the fields of one record, against those of a reference where there is one."""

    def __init__(self, bits, publication, level, reference):
        self.bits, self.publication, self.level, self.reference = bits, publication, level, reference
        self.delta = publication.delta

    def read(self):
        """All fields that are present, in the order of the table."""
        publication, level = self.publication, self.level
        publication.motion = self.bits.take(3)
        check(publication.motion <= 5, "an unknown motion")
        moving = publication.motion >= 2
        publication.position = self.vector("position", level.position_limit, ((FULL,), (0, 9, 12, FULL)), PLACE)
        if moving:
            limits = (level.velocity_limit,) * 3
            publication.velocity = self.vector("velocity", limits, ((0, 8, 10, FULL),) * 2, RATE)
        if publication.motion in (3, 5):
            publication.acceleration = self.vector("acceleration", (level.acceleration_limit,) * 3, FAST, FAST)
        rates = (level.rate_limit,) * 3
        if publication.motion == 5:
            publication.turn = self.vector("turn", rates, SLOW_TURN, SLOW_TURN)
        if publication.motion == 4:
            publication.floor, = self.field([self.of("floor")], level.position_limit[1], PLACE)
            check(not self.known() or publication.floor <= publication.position[1], "a floor above its body")
        if publication.upright:
            self.read_yaw(moving)
        else:
            self.read_orientation(moving, rates)
        publication.appearance = self.unsigned(self.of("appearance"), 65535, (0, 5, 9, FULL), (0, FULL))

    def known(self):
        """Whether values can be told: a delta without its keyframe is passed over."""
        return self.reference or not self.delta

    def of(self, name):
        """Value of the reference."""
        return getattr(self.reference, name) if self.reference else getattr(EMPTY, name)

    def read_yaw(self, moving):
        """Of an upright entity, with its rate."""
        size, before = 1 << self.level.yaw_bits, self.of("orientation")[0]
        width = self.size_class((0, 7, 9, FULL) if self.delta else (FULL,), self.level.yaw_bits)
        if width == FULL:
            yaw = self.bits.take(self.level.yaw_bits)
        else:
            yaw = (before + self.signed(width)) % size
        difference = (yaw - before + size // 2) % size - size // 2
        self.check_class(width, [difference], (0, 7, 9, FULL) if self.delta else (FULL,), self.level.yaw_bits)
        self.publication.orientation = (yaw, 0, 0)
        if moving:
            rate, = self.field([self.of("angular_velocity")[1]], self.level.rate_limit,
                               ((0, 6, 8, FULL), (0, 8, 9, FULL)))
            self.publication.angular_velocity = (0, rate, 0)

    def read_orientation(self, moving, rates):
        """Of an entity that turns freely, with its rates."""
        publication, limit = self.publication, self.level.orientation
        publication.left_out = self.unsigned(self.of("left_out"), 3, (FULL,), (0, FULL))
        publication.orientation = tuple(self.field(self.of("orientation"), limit, ((FULL,), (0, 5, 8, FULL))))
        if self.known():
            parts = list(publication.orientation)
            left = 2 * limit ** 2 - sum(part * part for part in parts)
            check(left >= 0, "an orientation that is none")
            parts.insert(publication.left_out, rounded(math.sqrt(left)))
            check(greatest_of(parts) == publication.left_out, "not the greatest component left out")
        if moving:
            publication.angular_velocity = self.vector("angular_velocity", rates, RATE, RATE)

    def vector(self, name, limits, classes_xz, classes_y):
        """A field of x and z, then one of y."""
        before = self.of(name)
        x, z = self.field([before[0], before[2]], limits[0], classes_xz)
        y, = self.field([before[1]], limits[1], classes_y)
        return x, y, z

    def field(self, before, limit, classes):
        """Components from -limit to limit; classes of absolute records and of deltas."""
        classes, full = classes[self.delta], (2 * limit).bit_length()
        width = self.size_class(classes, full)
        if width == FULL:
            values = [self.bits.take(full) - limit for _ in before]
        else:
            values = [one + self.signed(width) for one in before]
        if self.known():
            check(all(abs(value) <= limit for value in values), "a field beyond its range")
            self.check_class(width, [a - b for a, b in zip(values, before)], classes, full)
        return values

    def unsigned(self, before, most, absolute, delta):
        """A component from 0 to a number."""
        classes, full = delta if self.delta else absolute, most.bit_length()
        width = self.size_class(classes, full)
        value = self.bits.take(full) if width == FULL else before + self.signed(width)
        if self.known():
            check(0 <= value <= most, "a field beyond its range")
            self.check_class(width, [value - before], classes, full)
        return value

    def size_class(self, classes, full):
        """The width behind its selector."""
        width = classes[self.bits.take((0, 0, 1, 0, 2)[len(classes)])]
        check(width == FULL or width < full, "a class that is not in use")
        return width

    def signed(self, width):
        """A two's complement number."""
        value = self.bits.take(width)
        return value - (1 << width) if width and value >> (width - 1) else value

    def check_class(self, width, differences, classes, full):
        """It is the first one in use that holds all components."""
        for earlier in classes:
            if earlier == width:
                return
            if earlier < full:
                held = all(-(1 << earlier >> 1) <= one < max(1, 1 << earlier >> 1) for one in differences)
                check(not held or not self.known(), "a wider form than needed")


EMPTY = Publication(0, NEW, 0, 0)


class SharedDecoder:
    """Reads records that are one for all clients; keeps the keyframes that deltas refer to."""

    def __init__(self, quantization, declared_fields):
        self.levels, self.declared_fields = quantization.levels, declared_fields
        self.keyframes = {}
        self.passed_over = 0

    def decode(self, sequence, tick, zone, data):
        """Records of a packet, and the reason why the rest could not be read, if so."""
        bits, records = Bits(data), []
        try:
            while bits.at < bits.count:
                record = self.record(bits, sequence, tick, zone)
                if record:
                    records.append(record)
        except ValueError as refusal:
            return records, str(refusal)
        return records, None

    def record(self, bits, sequence, tick, zone):
        """One record; None for a delta whose keyframe is not there."""
        kind = bits.take(2)
        if kind == REMOVAL:
            entity = bits.narrowest(ENTITY_WIDTHS)
            bits.pad()
            self.forget(entity, sequence)
            return Publication(entity, REMOVE, zone, tick)
        delta = bits.take(1) == 1 if kind == DECLARED else kind == DELTA
        level, keyframe, low = bits.take(2), bits.take(4), bits.take(8)
        entity = bits.narrowest(ENTITY_WIDTHS)
        check(entity != 0 and level < len(self.levels), "an entity or level that is none")
        publication = Publication(entity, KNOWN if delta else NEW, zone, tick - (tick - low) % 256)
        publication.level, publication.upright, publication.delta = level, bits.take(1) == 1, delta
        stream = self.keyframes.setdefault((zone, entity, level), {})
        reference = stream.get(keyframe, (None, 0))[0] if delta else None
        publication.type = reference.type if reference else 0 if delta else bits.narrowest(TYPE_WIDTHS)
        Fields(bits, publication, self.levels[level], reference).read()
        self.read_declared(bits, kind == DECLARED, publication, reference)
        bits.pad()
        if delta and not reference:
            self.passed_over += 1
            return None
        if not delta and sequence >= stream.get(keyframe, (None, 0))[1]:
            stream[keyframe] = (publication, sequence)
        return publication

    def forget(self, entity, sequence):
        """Ends all streams of an entity; what came in later packets stays."""
        for stream in [stream for stream in self.keyframes if stream[1] == entity]:
            kept = {number: frame for number, frame in self.keyframes[stream].items() if frame[1] > sequence}
            self.keyframes[stream] = kept

    def read_declared(self, bits, told, publication, reference):
        """Declared fields of the type."""
        fields = self.declared_fields.get(publication.type, ())
        publication.declared = reference.declared if reference else initial_values(fields)
        if not told:
            return
        count = bits.narrowest(PART_WIDTHS)
        end = bits.at + count
        check(end <= bits.count, "a part that is cut off")
        if publication.delta and not reference:
            bits.at = end
            return
        check(len(fields) > 0, "declared fields of a type that has none")
        values = list(publication.declared)
        for index in self.indices(bits, len(fields)):
            values[index] = fields[index].read(bits.take)
            check(publication.delta or values[index] != fields[index].initial, "an initial value in an absolute record")
        check(bits.at == end, "a part that is longer or shorter than its values")
        publication.declared = tuple(values)

    @staticmethod
    def indices(bits, count):
        """The fields that are told."""
        if count == 1:
            return [0]
        if bits.take(1):
            mask = bits.take(count)
            told = [i for i in range(count) if mask >> i & 1]
            check(len(told) >= 2, "fewer than two fields in a mask")
            return told
        index = bits.take((count - 1).bit_length())
        check(index < count, "an index beyond the last field")
        return [index]

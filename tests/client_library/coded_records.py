"""A decoder of coded records, written from proto/WIRE.md alone: sections 4a, 5 and 5a.

It is slow and plain, so that it can be read beside the page. Numbers of binary32 are Python floats that `single` has
rounded after each operation."""

import bisect
import functools
import math
import struct

KNOWN, NEW, REMOVE, END, MOVING = range(5)
GAP, AGE, ALONG, UP, TURN = range(17, 22)
(MOTION, POSITION_XZ, POSITION_Y, VELOCITY_XZ, VELOCITY_Y, ACCELERATION_XZ, ACCELERATION_Y, TURN_XZ, TURN_Y, FLOOR_Y,
 YAW, TURN_RATE, LEFT_OUT, SMALLEST_THREE, ANGULAR_XZ, ANGULAR_Y, APPEARANCE) = range(17)
BEGINS = (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 384)  # f(0) to f(16)
GREATEST_MAGNITUDE = 2 ** 24 - 1
KEPT_STATES = 16
XZY = (0, 2, 1)
NONE3 = (0, 0, 0)
SINGLE = struct.Struct("<f")


def single(number):
    """The number rounded to binary32."""
    try:
        return SINGLE.unpack(SINGLE.pack(number))[0]
    except OverflowError:
        return math.copysign(math.inf, number)


def rounded(number):
    """To the nearest whole number; one that is not finite counts as 0."""
    return math.floor(number + 0.5) if math.isfinite(number) else 0


def within(number, limit):
    """The number, or the nearest one from -limit to limit."""
    return max(-limit, min(limit, number))


def check(good, reason):
    """Refuses what a reader must refuse."""
    if not good:
        raise ValueError(reason)


class Level:
    """Steps and limits of one level of detail."""

    def __init__(self, quantization, place, turn):
        self.position = min(single(quantization.position_step_m * 2 ** place), 1.0)
        self.velocity = min(single(quantization.velocity_step_mps * 2 ** place), 1.0)
        self.acceleration = min(single(quantization.acceleration_step_mps2 * 2 ** place), 10.0)
        self.rate = min(single(quantization.angular_velocity_step_rps * 2 ** turn), 10.0)
        self.yaw_bits = max(quantization.yaw_bits - turn, 5)
        self.orientation = 2 ** (max(quantization.orientation_bits - turn, 5) - 1) - 1
        self.velocity_limit = limit_of(quantization.max_speed_mps, self.velocity)
        self.acceleration_limit = limit_of(512, self.acceleration)
        self.rate_limit = limit_of(128, self.rate)
        horizontal = limit_of(quantization.horizontal_extent_m, self.position)
        self.position_limit = (horizontal, limit_of(quantization.vertical_extent_m, self.position), horizontal)


def limit_of(extent, step):
    """Greatest number of steps in a range."""
    return max(1, min(4194303, rounded(extent / step)))


class Quantization:
    """Constants of a world; the defaults are those of the page's examples."""

    def __init__(self, **given):
        self.position_step_m = single(0.01)
        self.velocity_step_mps = 1 / 64
        self.acceleration_step_mps2 = 1 / 32
        self.angular_velocity_step_rps = 1 / 32
        self.orientation_bits = 10
        self.yaw_bits = 10
        self.horizontal_extent_m = 2048.0
        self.vertical_extent_m = 1024.0
        self.max_speed_mps = 256.0
        self.gravity_mps2 = single(9.81)
        self.lod_shift = ((0, 0),) * 4
        self.tick_rate_hz = 30
        self.__dict__.update(given)
        self.tick_s = single(1 / self.tick_rate_hz)
        self.levels = [Level(self, *shift) for shift in self.lod_shift]


class Reader:
    """Places of the range coder, and raw bits, of one code."""

    def __init__(self, code):
        self.bytes = code
        self.number = int.from_bytes((code + bytes(4))[:4], "big")
        self.range = 2 ** 32 - 1
        self.shifts = 0
        self.raw_bits = int.from_bytes(code[::-1], "little")
        self.raw_used = 0

    def place(self):
        """The place that the code is at."""
        return min(self.number // (self.range >> 15), 2 ** 15 - 1)

    def take(self, first, count):
        """The owner of the place was found."""
        step = self.range >> 15
        self.number -= step * first
        self.range = step * count
        while self.range < 2 ** 24:
            following = self.bytes[self.shifts + 4] if self.shifts + 4 < len(self.bytes) else 0
            self.number = (self.number << 8 | following) & 0xFFFFFFFF
            self.range <<= 8
            self.shifts += 1

    def raw(self, count):
        """A number of so many raw bits."""
        self.raw_used += count
        check(self.raw_used <= 8 * len(self.bytes), "raw bits are missing")
        return self.raw_bits >> (self.raw_used - count) & (1 << count) - 1

    def finish(self):
        """After the last record."""
        raw_bytes = (self.raw_used + 7) // 8
        padding = self.raw_bits >> self.raw_used & (1 << 8 * raw_bytes - self.raw_used) - 1
        check(padding == 0, "padding that is not zero")
        coder_bytes = len(self.bytes) - raw_bytes
        check(self.shifts <= coder_bytes <= self.shifts + 4, "a code too short or too long")


def yes_places(model):
    """How many places yes owns."""
    return max(32, min(2 ** 15 - 32, (model[0] + model[1]) // 4))


def learned_decision(model, yes):
    """The model after one more decision."""
    q, s = model
    if yes:
        return q + (65535 - q) // 16, s + (65535 - s) // 128
    return q - q // 16, s - s // 128


def first_symbols(weights):
    """A model of symbols that has learned nothing."""
    total = sum(weights)
    return tuple(8 * i + (2 ** 14 - 128) * sum(weights[:i]) // total for i in range(16))


def learned_symbol(model, symbol):
    """The model after one more symbol; floor((t - p) / 128)."""
    targets = [8 * i if i <= symbol else 2 ** 14 - 8 * (16 - i) for i in range(16)]
    return tuple(p + (target - p) // 128 for p, target in zip(model, targets))


def power(base, exponent):
    """Product of the squares that the exponent needs."""
    result = 1.0
    while exponent:
        if exponent & 1:
            result *= base
        base *= base
        exponent >>= 1
    return result


@functools.lru_cache(None)
def first_magnitudes(magnitude_class):
    """The model of a class's symbols that has learned nothing."""
    m = 2 ** (magnitude_class // 2) * (1.75 if magnitude_class % 2 else 1.25) - 1
    theta = (math.sqrt(1 + m * m) - 1) / m
    shares = [1.0] + [2 * power(theta, BEGINS[j]) / (1 + theta) for j in range(1, 16)] + [0.0]
    return first_symbols([1 + math.floor(60000 * (shares[j] - shares[j + 1])) for j in range(16)])


UNIFORM = first_symbols([1] * 16)


def class_of(expected):
    """Class of an expected magnitude."""
    mantissa, exponent = math.frexp(single(1 + expected))
    return min(27, 2 * (exponent - 1) + (mantissa >= 0.75))


def calm_of(expected):
    """Half the class, at most 7."""
    return min(7, class_of(expected) // 2)


class Publication:
    """State of an entity by a record, with marks that its coding left."""

    def __init__(self, entity, kind, zone, tick):
        self.entity, self.kind, self.zone, self.tick = entity, kind, zone, tick
        self.type = self.upright = self.level = self.motion = self.floor = self.left_out = self.appearance = 0
        self.position = self.velocity = self.acceleration = self.turn = NONE3
        self.orientation = self.angular_velocity = NONE3
        self.declared = ()
        self.plain = False
        self.errors = (0.0, 0.0, 0.0)
        self.turn_error = 0.0

    def moves(self):
        """Whether its motion is static."""
        return self.kind != REMOVE and self.motion == 1


class Packet:
    """A decoded packet and all that learning it takes."""

    def __init__(self, number, tick, zone):
        self.number, self.tick, self.zone = number, tick, zone
        self.log = []
        self.publications = []
        self.shares = {}
        self.courses = {}


class Knowledge:
    """All that was learned up to a packet."""

    def __init__(self):
        self.learned = ()
        self.looks = ()
        self.decisions, self.symbols, self.means = {}, {}, {}
        self.shares, self.courses, self.entities = {}, {}, {}

    def copy(self):
        """One that can learn on."""
        other = Knowledge()
        other.learned, other.looks = self.learned, self.looks
        for name in ("decisions", "symbols", "means", "shares", "courses", "entities"):
            setattr(other, name, dict(getattr(self, name)))
        return other

    def decision(self, key):
        """Model of a decision."""
        return self.decisions.get(key) or ((4096, 4096) if key[0] == "plain" else (57344, 57344))

    def symbol(self, key):
        """Model of a symbol."""
        return self.symbols.get(key) or (first_magnitudes(key[2]) if key[0] == "magnitude" else UNIFORM)

    def mean(self, kind, reach):
        """Mean magnitude of a kind."""
        return self.means.get((kind, reach), 256.0 if reach == 4 else 4.0)

    def share(self, axis):
        """Share of the residual of the position that a velocity is expected to have."""
        return self.shares[axis == 1][2] if (axis == 1) in self.shares else 1.0

    def weights(self, course, calm):
        """Weights of a course's features."""
        return self.courses[course, calm][2] if (course, calm) in self.courses else FIRST_WEIGHTS[course]

    def base(self, entity, zone):
        """Newest publication of the entity in the zone."""
        history = self.entities.get(entity)
        newest = history[-1][1] if history else None
        return newest if newest and newest.kind != REMOVE and newest.zone == zone else None

    def learn(self, packet):
        """One more packet."""
        for key, value, reach in packet.log:
            if isinstance(value, bool):
                self.decisions[key] = learned_decision(self.decision(key), value)
                continue
            self.symbols[key] = learned_symbol(self.symbol(key), value)
            if reach is not None:
                self.learn_mean(key[1], reach, value)
        self.learn_shares(packet)
        self.learn_courses(packet)
        self.learn_publications(packet)

    def learn_mean(self, kind, reach, symbol):
        """Mean of a magnitude's reach."""
        mean = self.mean(kind, reach)
        middle = (BEGINS[symbol] + BEGINS[symbol + 1] - 1) / 2
        self.means[kind, reach] = single(mean + single(single(middle - mean) / 32))

    def learn_shares(self, packet):
        """Shares by the velocities of a packet."""
        for upwards, (a, b) in packet.shares.items():
            before = self.shares.get(upwards, (0.0, 0.0, 1.0))
            a, b = 63 / 64 * before[0] + a, 63 / 64 * before[1] + b
            k = 0.01 * a + 1e-6
            root = math.sqrt(a + k)
            self.shares[upwards] = (a, b, (b + k) / root / root)

    def learn_courses(self, packet):
        """Weights by the courses of a packet."""
        for key, (products, values) in packet.courses.items():
            first = FIRST_WEIGHTS[key[0]]
            count = range(len(first))
            before = self.courses.get(key) or ([[0.0] * len(first) for _ in count], [0.0] * len(first), first)
            products = [[63 / 64 * before[0][i][j] + products[i][j] for j in count] for i in count]
            values = [63 / 64 * before[1][i] + values[i] for i in count]
            self.courses[key] = (products, values, solved(products, values, first))

    def learn_publications(self, packet):
        """Histories of a packet's entities, and the looks."""
        self.learned += ((packet.number, packet.tick),)
        kept = [look for look in self.looks if look[1] != packet.tick]
        self.looks = tuple(kept + [(packet.number, packet.tick)])[-7:]
        for publication in packet.publications:
            history = self.entities.get(publication.entity, ()) + ((packet.number, publication),)
            while len(history) > 1 and history[1][0] <= self.looks[0][0]:
                history = history[1:]
            self.entities[publication.entity] = history

    def look_packets(self):
        """Number and tick of the packets of looks 0 to 4."""
        return [self.looks[max(0, len(self.looks) - 1 - back)] for back in (0, 1, 2, 3, 6)]

    def look(self, base):
        """Publications of looks 0 to 4 of an entity."""
        history = self.entities[base.entity]
        at, seen = len(history) - 1, []
        for number, _ in self.look_packets():
            while at > 0 and history[at][0] > number and leads_back(*(one for _, one in history[at - 1:at + 1])):
                at -= 1
            found = history[at][1]
            seen.append(found if found.upright == base.upright else seen[-1])
        return seen

    def moving(self, zone):
        """The moving entities in ascending order, each with its pace."""
        found = []
        for entity in sorted(self.entities):
            base = self.base(entity, zone)
            if base and base.moves() and self.looks[-1][1] - base.tick <= 12:
                found.append((entity, self.pace(base)))
        return found

    def pace(self, base):
        """How an entity moved of late."""
        seen = self.look(base)
        far = sum(abs(a - b) for a, b in zip(seen[0].position, seen[4].position))
        others = [look is not seen[0] for look in seen]
        return others[1] + 2 * others[3] + 4 * others[4] + 8 * min(7, far.bit_length())


def leads_back(older, newer):
    """Whether a look may go on from a publication to the one before it."""
    return newer.moves() and not newer.plain and older.kind != REMOVE and older.zone == newer.zone


FIRST_WEIGHTS = {"xz": (0.8, 0.2, 1.0, 0.4), "y": (0.8, 0.2, 1.0, 0.4), "turn": (0.3, 0.7, 0.5)}


def cholesky(matrix):
    """The lower factor, column by column; None where a root is not of a number above 0."""
    count = range(len(matrix))
    lower = [[0.0] * len(matrix) for _ in count]
    for j in count:
        for i in count[j:]:
            left = matrix[i][j]
            for n in range(j):
                left -= lower[i][n] * lower[j][n]
            if i == j and not left > 0:
                return None
            lower[i][j] = math.sqrt(left) if i == j else left / lower[j][j]
    return lower


def solved(products, values, first):
    """Weights that the sums of a course say, or the first ones."""
    count = range(len(first))
    k = [0.01 * products[i][i] + 1e-6 for i in count]
    lower = cholesky([[products[i][j] + (k[i] if i == j else 0.0) for j in count] for i in count])
    if not lower:
        return first
    z = [values[i] + k[i] * first[i] for i in count]
    for i in count:
        for n in range(i):
            z[i] -= lower[i][n] * z[n]
        z[i] /= lower[i][i]
    for i in reversed(count):
        for n in count[i + 1:]:
            z[i] -= lower[n][i] * z[n]
        z[i] /= lower[i][i]
    return tuple(z)


def mul(a, b):
    """Product of two quaternions in binary32, components in the order of the page."""
    p = [[single(x * y) for y in b] for x in a]

    def total(first, *rest):
        for term in rest:
            first = single(first + term)
        return first
    return (total(p[0][0], -p[1][1], -p[2][2], -p[3][3]), total(p[0][1], p[1][0], p[2][3], -p[3][2]),
            total(p[0][2], -p[1][3], p[2][0], p[3][1]), total(p[0][3], p[1][2], -p[2][1], p[3][0]))


def series(terms):
    """Coefficients in binary32."""
    return [single(term) for term in terms]


ROOT2 = single(math.sqrt(2))
HALF_PI = single(math.pi / 2)
TURN_SINE = series([1, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800])
TURN_COSINE = series([1, -1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800, 1 / 479001600])
ARCSINE = series([1, 1 / 6, 3 / 40, 5 / 112, 35 / 1152, 63 / 2816, 231 / 13312, 143 / 10240, 6435 / 557056,
                  12155 / 1245184])


def horner(coefficients, q, few_up_to):
    """A polynomial in binary32; up to q^3 alone where q is small."""
    if q <= few_up_to:
        coefficients = coefficients[:4]
    value = coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        value = single(single(value * q) + coefficient)
    return value


def sum_of_squares(vector):
    """In binary32, from left to right."""
    total = single(vector[0] * vector[0])
    for component in vector[1:]:
        total = single(total + single(component * component))
    return total


def turned(quaternion, turn):
    """The orientation turned about a vector's axis by its length, in binary32."""
    q = single(0.25 * sum_of_squares(turn))
    if not math.isfinite(q):
        return quaternion
    most = single(HALF_PI * HALF_PI)
    m = 0.5
    if q > most:
        m = single(0.5 * single(math.sqrt(single(most / q))))
        q = most
    factor = single(m * horner(TURN_SINE, q, 1 / 16))
    return mul((horner(TURN_COSINE, q, 1 / 16),) + tuple(single(factor * part) for part in turn), quaternion)


def turn_between(a, b):
    """Axis times angle from orientation a to b, in binary32."""
    r = mul(b, (a[0], -a[1], -a[2], -a[3]))
    sign = -1 if r[0] < 0 else 1
    w = sign * r[0]
    q = sum_of_squares(r[1:])
    ww = single(w * w)
    if q <= 0.25:
        factor = horner(ARCSINE, q, 1 / 64)
    elif ww <= 0.25:
        angle = single(HALF_PI - single(w * horner(ARCSINE, ww, 1 / 64)))
        factor = single(angle / single(math.sqrt(q)))
    else:
        v = min(1.0, single(math.sqrt(q)))
        u = single(0.5 * single(1 - v))
        angle = single(HALF_PI - single(single(2 * single(math.sqrt(u))) * horner(ARCSINE, u, 1 / 64)))
        factor = single(angle / v)
    return tuple(single(single(factor * (2 * sign)) * part) for part in r[1:])


def quaternion_of(publication, limit):
    """Orientation of a publication in binary32."""
    unit = single(1 / single(limit * ROOT2))
    parts = [single(part * unit) for part in publication.orientation]
    left = 1.0
    for part in parts:
        left = single(left - single(part * part))
    parts.insert(publication.left_out, single(math.sqrt(max(0.0, left))))
    return tuple(parts)


def greatest_of(quaternion):
    """Its greatest component in magnitude, the first of those."""
    magnitudes = [abs(part) for part in quaternion]
    return magnitudes.index(max(magnitudes))


def components_beside(quaternion, left_out, limit):
    """The other three components as expected steps."""
    sign = -1.0 if quaternion[left_out] < 0 else 1.0
    others = quaternion[:left_out] + quaternion[left_out + 1:]
    steps = [single(single(sign * part * ROOT2) * limit) for part in others]
    return [within(math.floor(single(step + 0.5)), limit) for step in steps]


class Neighbours:
    """Records on a course that were coded before in the packet."""

    def __init__(self):
        self.noted = []

    def note(self, place, moved, turned_more, turn, errors, turn_error):
        """One more record."""
        origin = self.noted[0][0] if self.noted else place
        arm = tuple(single(a - b) for a, b in zip(place, origin))
        values = (*moved, *turned_more, *turn, *errors, turn_error, *cross(turned_more, arm))
        self.noted.append((place, values))

    def means(self, place):
        """Means for a place; None without neighbours."""
        if not self.noted:
            return None
        weights = [self.weight(place, other) for other, _ in self.noted]
        least = max(weights) / 64
        near = [(weight, values) for weight, (_, values) in zip(weights, self.noted) if weight >= least]
        inverse = single(1 / summed(weight for weight, _ in near))
        sums = [summed(single(weight * values[i]) for weight, values in near) for i in range(16)]
        return Means([single(total * inverse) for total in sums],
                     tuple(single(a - b) for a, b in zip(place, self.noted[0][0])))

    @staticmethod
    def weight(place, other):
        """By distance."""
        s = single(sum_of_squares([single(a - b) for a, b in zip(place, other)]) + 1)
        return single(1 / single(s * s))


def summed(numbers):
    """Sum in binary32."""
    total = 0.0
    for number in numbers:
        total = single(total + number)
    return total


def mean_of(numbers):
    """Mean over the axes in binary32."""
    return single(summed(numbers) / 3)


def cross(a, b):
    """In binary32."""
    return tuple(single(single(a[i] * b[j]) - single(a[j] * b[i])) for i, j in ((1, 2), (2, 0), (0, 1)))


class Means:
    """Common values of the neighbours of a place."""

    def __init__(self, values, arm):
        self.moved, turned_more, self.turn, self.errors = values[0:3], values[3:6], values[6:9], values[9:12]
        self.turn_error = values[12]
        self.carried = tuple(single(a - b) for a, b in zip(cross(turned_more, arm), values[13:16]))


def blended(expected, errors):
    """An expected magnitude, brought nearer to the mean of the errors before."""
    if not errors:
        return expected
    mean = single(summed(errors) / len(errors))
    return single(single(single(0.8) * expected) + single(single(0.2) * mean))


class Course:
    """Expectations of one record on a course."""

    def __init__(self, knowledge, levels, neighbours, publication, base):
        self.knowledge, self.levels, self.publication = knowledge, levels, publication
        self.level = levels[publication.level]
        self.looks = knowledge.look(base)
        packets = knowledge.look_packets()
        self.g = max(0, publication.tick - packets[0][1])
        self.per_tick = single(1 / self.g) if self.g else 0.0
        self.l1, self.l2, self.l3 = [self.factor(packets[a][1] - packets[b][1]) for a, b in ((0, 1), (1, 2), (0, 3))]
        self.places = [self.place(look) for look in self.looks]
        self.ratio = levels[0].position / self.level.position
        self.origin = tuple(float(math.trunc(part / self.ratio)) for part in self.places[0])
        self.means = neighbours.means(self.origin)
        self.magnitudes = [0.0] * 3
        self.measure_own()
        self.position_features()

    def factor(self, ticks):
        """Ticks on from look 0 per ticks between two looks."""
        return self.g * (1 / ticks) if ticks > 0 else 0.0

    def place(self, look):
        """Place of a look in steps of the record's level."""
        return [self.scale(look) * part for part in look.position]

    def measure_own(self):
        """Errors expected by those of the looks."""
        fresh = [self.looks[k] for k in range(3) if self.looks[k + 1] is not self.looks[k]]
        self.own = [self.own_error(single(look.errors[axis] * self.scale(look)) for look in fresh) for axis in range(3)]
        self.own_turn = self.own_error(look.turn_error for look in fresh)
        self.m = mean_of(self.own)
        self.calm = calm_of(self.m)

    def own_error(self, errors):
        """Of errors per tick."""
        return single(summed(errors) * single(self.g / 3))

    def scale(self, look):
        """A step of a look's level in steps of the record's."""
        return self.levels[look.level].position / self.level.position

    def position_features(self):
        """Features, continued and moves, by axis."""
        p = self.places
        self.features, self.continued, self.moves = [], [], []
        for axis in range(3):
            f = [self.l1 * (p[0][axis] - p[1][axis]), self.l2 * (p[1][axis] - p[2][axis]), 0.0, 0.0]
            if self.means:
                f[2:] = [self.means.moved[axis] * self.ratio, self.means.carried[axis] * self.ratio]
            h = self.knowledge.weights("y" if axis == 1 else "xz", self.calm)
            continued = 0.8 * f[0] + 0.2 * f[1]
            moves = h[0] * f[0] + h[1] * f[1] + h[2] * f[2] + h[3] * f[3]
            self.features.append(f)
            self.continued.append(continued)
            self.moves.append(moves if abs(moves) <= 2 ** 23 else continued)

    def expected_error(self, axis):
        """Expected magnitude of an axis, by itself."""
        if not self.means:
            return single(single(single(0.85) * self.own[axis]) + single(single(0.15) * self.m))
        mine = single(single(single(0.35) * self.own[axis]) + single(single(0.15) * self.m))
        n = mean_of(self.means.errors)
        theirs = single(single(single(0.3) * self.means.errors[axis]) + single(single(0.2) * n))
        return single(mine + single(theirs * single(self.ratio)))

    def turn_features(self):
        """Features of the turn, and the turn expected of look 0."""
        orientations = [quaternion_of(look, self.levels[look.level].orientation) for look in self.looks]
        w1, w3 = [turn_between(orientations[k], orientations[0]) for k in (1, 3)]
        self.look0 = orientations[0]
        h = self.knowledge.weights("turn", self.turn_calm())
        self.turns, self.turn_continued, self.turn_expected = [], [], []
        for axis in range(3):
            f = [self.l1 * w1[axis], self.l3 * w3[axis], 0.0]
            continued = 0.3 * f[0] + 0.7 * f[1]
            if self.means:
                f[2] = self.means.turn[axis] - continued
            turn = h[0] * f[0] + h[1] * f[1] + h[2] * f[2]
            self.turns.append(f)
            self.turn_continued.append(continued)
            self.turn_expected.append(single(turn) if abs(turn) <= 4 else 0.0)
        return turned(self.look0, self.turn_expected)

    def turn_unit(self):
        """Steps of a component per radian."""
        return single(single(0.5 * ROOT2) * self.level.orientation)

    def turn_calm(self):
        """Calm of the turn."""
        return calm_of(single(self.turn_unit() * self.own_turn))

    def expected_turn_error(self):
        """Expected magnitude of a component, by itself."""
        own = self.own_turn
        if self.means:
            own = single(single(0.5 * own) + single(0.5 * self.means.turn_error))
        return single(self.turn_unit() * own)


def expected_orientation(base, ticks, tick_s, levels, level):
    """Orientation of a base that turned on, in binary32."""
    step = single(levels[base.level].rate * (ticks * tick_s))
    turn = tuple(single(step * part) for part in base.angular_velocity)
    return turned(quaternion_of(base, levels[base.level].orientation), turn)


class Body:
    """Reads the records of one packet."""

    def __init__(self, decoder, reader, knowledge, packet):
        self.quantization, self.declared_fields = decoder.quantization, decoder.declared_fields
        self.levels = self.quantization.levels
        self.reader, self.knowledge, self.packet = reader, knowledge, packet
        self.moving = knowledge.moving(packet.zone)
        self.neighbours = Neighbours()
        self.kind_before = self.level_before = self.entity = 0
        self.place_before = (0.0, 0.0, 0.0)

    def decide(self, *key):
        """A decision."""
        yes = yes_places(self.knowledge.decision(key))
        answer = self.reader.place() < yes
        self.reader.take(*((0, yes) if answer else (yes, 2 ** 15 - yes)))
        self.packet.log.append((key, answer, None))
        return answer

    def symbol(self, *key, reach=None):
        """A symbol."""
        model = self.knowledge.symbol(key)
        found = bisect.bisect_right(model, self.reader.place() // 2) - 1
        end = model[found + 1] if found < 15 else 2 ** 14
        self.reader.take(2 * model[found], 2 * (end - model[found]))
        self.packet.log.append((key, found, reach))
        return found

    def magnitude(self, kind, expected, reach=None):
        """A magnitude of a kind."""
        symbol = self.symbol("magnitude", kind, class_of(expected), reach=reach)
        if symbol < 4:
            return symbol
        if symbol < 15:
            return BEGINS[symbol] + self.reader.raw(1 + (symbol - 4) // 2)
        bits = min(24, self.reader.raw(5))
        upper = self.reader.raw(bits - 12) << 12 if bits > 12 else 0
        return min(GREATEST_MAGNITUDE, 191 + (1 << bits) + upper + self.reader.raw(min(12, bits)))

    def residual(self, kind, expected, reach=None):
        """A magnitude with its sign."""
        magnitude = self.magnitude(kind, expected, reach)
        return -magnitude if magnitude and self.reader.raw(1) else magnitude

    def records(self):
        """All records of the packet."""
        while True:
            kind = self.symbol("kind", self.kind_before)
            check(kind <= MOVING, "an unknown kind")
            self.kind_before = kind
            if kind == END:
                return self.packet.publications
            check(len(self.packet.publications) < 1024, "more than 1,024 records")
            self.packet.publications.append(self.record(kind))

    def record(self, kind):
        """One record of a kind."""
        self.entity = self.moving_entity() if kind == MOVING else self.entity_behind()
        if kind == REMOVE:
            return Publication(self.entity, kind, self.packet.zone, self.packet.tick)
        base = None if kind == NEW else self.knowledge.base(self.entity, self.packet.zone)
        check(kind == NEW or base, "a known record without a base")
        publication = self.head_of(kind, base)
        Fields(self, publication, base).read()
        fields = self.declared_fields.get(publication.type)
        publication.declared = base.declared if base else initial_values(fields or ())
        if fields:
            self.declared(publication, fields, base)
        step = self.levels[publication.level].position
        self.place_before = tuple(part * step for part in publication.position)
        return publication

    def moving_entity(self):
        """The first of the moving entities that is the one."""
        for entity, pace in self.moving:
            if entity > self.entity and self.decide("moving", pace):
                return entity
        raise ValueError("none of the moving entities")

    def entity_behind(self):
        """An entity by its distance from the one before."""
        gap = self.magnitude(GAP, self.knowledge.mean(GAP, 0), 0)
        if gap == GREATEST_MAGNITUDE:
            gap = self.reader.raw(16) | self.reader.raw(16) << 16
        entity = self.entity + gap + 1
        check(entity < 2 ** 32, "an entity beyond 2^32 - 1")
        return entity

    def head_of(self, kind, base):
        """A publication up to its fields."""
        age = self.magnitude(AGE, self.knowledge.mean(AGE, 0), 0)
        check(age <= min(4095, self.packet.tick), "an age beyond its range")
        publication = Publication(self.entity, kind, self.packet.zone, self.packet.tick - age)
        check(not base or publication.tick >= base.tick, "a publication older than its base")
        publication.level = self.level_before = self.symbol("level", self.level_before)
        check(publication.level < 4, "an unknown level")
        if base:
            publication.upright, publication.type = base.upright, base.type
        else:
            publication.upright = self.decide("upright")
            publication.type = self.reader.raw(16)
        return publication

    def declared(self, publication, fields, base):
        """Declared fields that are told."""
        if self.decide("declared"):
            return
        raw, last = self.reader.raw, len(fields) - 1
        if last == 0:
            told = [0]
        elif raw(1):
            mask = raw(len(fields))
            told = [i for i in range(len(fields)) if mask >> i & 1]
            check(len(told) >= 2, "fewer than two fields in a mask")
        else:
            told = [raw(last.bit_length())]
        check(told[-1] <= last, "an index beyond the last field")
        values = list(publication.declared)
        for index in told:
            values[index] = fields[index].read(raw)
            check(base or values[index] != fields[index].initial, "an initial value in a new record")
        publication.declared = tuple(values)


class DeclaredField:
    """A field that a game declared: its greatest code, or None for a text."""

    def __init__(self, greatest, initial=0):
        self.greatest, self.initial = greatest, initial

    def read(self, raw):
        """A value in raw bits."""
        if self.greatest is not None:
            code = raw(self.greatest.bit_length())
            check(code <= self.greatest, "a code beyond the greatest")
            return code
        text = bytes(raw(8) for _ in range(raw(5))).decode("utf-8")
        check(not any(ord(c) < 32 or 127 <= ord(c) < 160 for c in text), "a control character")
        return text


def initial_values(fields):
    """Values that fields have at first."""
    return tuple(field.initial for field in fields)


class Fields:
    """Reads the fields of one record."""

    def __init__(self, body, publication, base):
        self.body, self.publication, self.base = body, publication, base
        self.knowledge, self.raw = body.knowledge, body.reader.raw
        self.levels, self.level = body.levels, body.levels[publication.level]
        self.ticks = publication.tick - base.tick if base else 0
        self.t = self.ticks * body.quantization.tick_s
        self.reach = 4 if not base else bisect.bisect_left((2, 8, 32), self.ticks)

    def read(self):
        """All fields that are present, in the order of the table."""
        base, publication = self.base, self.publication
        publication.motion = self.body.symbol("motion", base.motion if base else 6)
        check(publication.motion <= 5, "an unknown motion")
        self.course = None
        if base and base.motion <= 1 and (publication.motion == 1 or publication.motion == 0 and base.moves()):
            self.course = Course(self.knowledge, self.levels, self.body.neighbours, publication, base)
            CourseFields(self, self.course).read_position()
        else:
            self.read_position()
        if publication.motion >= 2:
            self.read_velocity()
        if publication.motion in (3, 5):
            self.read_acceleration()
        self.read_floor()
        self.read_rotation()
        if publication.motion >= 2:
            self.read_rates()
        publication.appearance = self.read_appearance()
        self.check_state()

    def component(self, kind, expected, limit, before=None):
        """One component by its residual."""
        mean = self.knowledge.mean(kind, self.reach)
        if before is not None:
            mean = single(single(single(0.6) * mean) + single(single(0.4) * abs(before)))
        residual = self.body.residual(kind, mean, self.reach)
        value = within(expected, limit) + residual
        check(abs(value) <= limit, "a field beyond its range")
        return value, residual

    def vector(self, kinds, expected, limits):
        """A field of x and z, then one of y; returns values and residuals by axis."""
        x, rx = self.component(kinds[0], expected[0], limits[0])
        z, rz = self.component(kinds[0], expected[2], limits[2], rx)
        y, ry = self.component(kinds[1], expected[1], limits[1])
        return (x, y, z), (rx, ry, rz)

    def base_vector(self, name):
        """A vector of the base times its step; zero without a base."""
        step = {"position": "position", "velocity": "velocity", "acceleration": "acceleration"}.get(name, "rate")
        if not self.base:
            return (0.0, 0.0, 0.0)
        return [part * getattr(self.levels[self.base.level], step) for part in getattr(self.base, name)]

    def base_acceleration(self):
        """Acceleration of the base; falling where it is ballistic."""
        if self.base and self.base.motion == 4:
            return (0.0, -self.body.quantization.gravity_mps2, 0.0)
        return self.base_vector("acceleration")

    def steps(self, values, step, limits):
        """Metres and the like in whole steps within limits."""
        return [within(rounded(value / step), limit) for value, limit in zip(values, limits)]

    def read_position(self):
        """Position off a course."""
        expected = self.body.place_before
        if self.base:
            p, v, a = self.base_vector("position"), self.base_vector("velocity"), self.base_acceleration()
            expected = [p[i] + (v[i] + 0.5 * a[i] * self.t) * self.t for i in range(3)]
            if self.base.motion == 4:
                expected[1] = max(expected[1], self.base.floor * self.levels[self.base.level].position)
        expected = self.steps(expected, self.level.position, self.level.position_limit)
        values = self.vector((POSITION_XZ, POSITION_Y), expected, self.level.position_limit)
        self.publication.position, self.position_residual = values
        self.expected_y = expected[1]

    def read_velocity(self):
        """Velocity, with its share of the position's residual."""
        v, a = self.base_vector("velocity"), self.base_acceleration()
        limits = [self.level.velocity_limit] * 3
        s = self.level.velocity
        plain = self.steps([v[i] + a[i] * self.t for i in range(3)], s, limits)
        if not self.t:
            self.publication.velocity, _ = self.vector((VELOCITY_XZ, VELOCITY_Y), plain, limits)
            return
        d = [residual * self.level.position / self.t for residual in self.position_residual]
        more = [within(rounded(self.knowledge.share(i) * d[i] / s), 2 ** 22) for i in range(3)]
        expected = [a + b for a, b in zip(plain, more)]
        self.publication.velocity, _ = self.vector((VELOCITY_XZ, VELOCITY_Y), expected, limits)
        if self.base.motion >= 2:
            self.teach_shares(d, [(value - a) * s for value, a in zip(self.publication.velocity, plain)])

    def teach_shares(self, d, e):
        """Notes what this record says of the shares."""
        for axis in XZY:
            a, b = self.body.packet.shares.get(axis == 1, (0.0, 0.0))
            self.body.packet.shares[axis == 1] = (a + d[axis] * d[axis], b + d[axis] * e[axis])

    def read_acceleration(self):
        """Acceleration and the rate at which it turns."""
        limits = [self.level.acceleration_limit] * 3
        expected = self.steps(self.base_acceleration(), self.level.acceleration, limits)
        self.publication.acceleration, _ = self.vector((ACCELERATION_XZ, ACCELERATION_Y), expected, limits)
        if self.publication.motion == 5:
            limits = [self.level.rate_limit] * 3
            expected = self.steps(self.base_vector("turn"), self.level.rate, limits)
            self.publication.turn, _ = self.vector((TURN_XZ, TURN_Y), expected, limits)

    def read_floor(self):
        """Floor of a ballistic publication."""
        publication, base, step = self.publication, self.base, self.level.position
        if publication.motion != 4:
            return
        expected = self.expected_y
        if base and base.motion == 4:
            expected = rounded(base.floor * self.levels[base.level].position / step)
        limit = self.level.position_limit[1]
        publication.floor, _ = self.component(FLOOR_Y, within(expected, limit), limit)

    def read_rotation(self):
        """Yaw, or an orientation that turns freely."""
        if self.publication.upright:
            self.read_yaw()
        elif self.course:
            CourseFields(self, self.course).read_orientation()
        else:
            self.read_orientation()

    def read_yaw(self):
        """Yaw, the short way round."""
        base, size = self.base, 1 << self.level.yaw_bits
        expected = 0
        if base:
            w = self.base_vector("angular_velocity")[1]
            u = base.orientation[0] / (1 << self.levels[base.level].yaw_bits) + w * self.t / (2 * math.pi)
            expected = rounded((u - math.floor(u)) * size) % size
        residual = self.body.residual(YAW, self.knowledge.mean(YAW, self.reach), self.reach)
        check(-size // 2 <= residual < size // 2, "a difference of yaw beyond its range")
        self.publication.orientation = ((expected + residual) % size, 0, 0)

    def read_orientation(self):
        """Orientation off a course."""
        limit, publication = self.level.orientation, self.publication
        expected, steps = 0, NONE3
        if self.base:
            quaternion = expected_orientation(self.base, self.ticks, self.body.quantization.tick_s, self.levels,
                                              self.level)
            expected = greatest_of(quaternion)
            steps = components_beside(quaternion, expected, limit)
        publication.left_out = expected
        if not self.body.decide("left_out"):
            publication.left_out, steps = self.raw(2), NONE3
        values, before = [], None
        for step in steps:
            value, before = self.component(SMALLEST_THREE, step, limit, before)
            values.append(value)
        publication.orientation = tuple(values)

    def read_rates(self):
        """Angular velocity."""
        limits = [self.level.rate_limit] * 3
        expected = self.steps(self.base_vector("angular_velocity"), self.level.rate, limits)
        if self.publication.upright:
            rate, _ = self.component(TURN_RATE, expected[1], limits[1])
            self.publication.angular_velocity = (0, rate, 0)
        else:
            self.publication.angular_velocity, _ = self.vector((ANGULAR_XZ, ANGULAR_Y), expected, limits)

    def read_appearance(self):
        """As it was, or raw."""
        if self.body.decide("appearance"):
            return self.base.appearance if self.base else 0
        return self.raw(16)

    def check_state(self):
        """Refuses a state that no record of section 4 can have."""
        publication = self.publication
        check(publication.motion != 4 or publication.floor <= publication.position[1], "a floor above its body")
        if not publication.upright:
            parts = list(publication.orientation)
            left = 2 * self.level.orientation ** 2 - sum(part * part for part in parts)
            check(left >= 0, "an orientation that is none")
            parts.insert(publication.left_out, rounded(math.sqrt(left)))
            check(greatest_of(parts) == publication.left_out, "not the greatest component left out")


class CourseFields:
    """Reads position and orientation of a record on a course."""

    def __init__(self, fields, course):
        self.fields, self.course, self.body, self.level = fields, course, fields.body, fields.level
        self.publication, self.raw = fields.publication, fields.raw

    def read_position(self):
        """`plain`, x, z, y."""
        course, publication = self.course, self.publication
        publication.plain = self.body.decide("plain", course.m >= 192)
        self.values, errors, sums = [0, 0, 0], [0.0, 0.0, 0.0], []
        for axis in XZY:
            course.magnitudes[axis] = blended(course.expected_error(axis), sums)
            if publication.plain:
                self.values[axis] = self.raw_within(self.level.position_limit[axis])
            else:
                self.values[axis] = self.read_axis(axis)
            moved = self.values[axis] - course.places[0][axis]
            errors[axis] = single(abs(moved - course.moves[axis]))
            sums.append(errors[axis])
        publication.position = tuple(self.values)
        course.errors = errors
        publication.errors = tuple(single(error * course.per_tick) for error in errors)
        if publication.upright:
            self.finish()

    def raw_within(self, limit):
        """A number by its distance from the least."""
        value = self.raw((2 * limit).bit_length()) - limit
        check(value <= limit, "a raw field beyond its range")
        return value

    def read_axis(self, axis):
        """A coordinate by its residual."""
        course, limit = self.course, self.level.position_limit[axis]
        expected = within(rounded(course.places[0][axis] + course.moves[axis]), limit)
        value = expected + self.body.residual(UP if axis == 1 else ALONG, course.magnitudes[axis])
        check(abs(value) <= limit, "a coordinate beyond its range")
        return value

    def read_orientation(self):
        """`left_out` and the other three."""
        course, publication = self.course, self.publication
        quaternion = course.turn_features()
        if publication.plain:
            publication.left_out = self.raw(2)
            publication.orientation = tuple(self.raw_within(self.level.orientation) for _ in range(3))
        else:
            self.read_components(quaternion)
        self.finish()

    def read_components(self, quaternion):
        """By their residuals."""
        course, limit = self.course, self.level.orientation
        greatest = greatest_of(quaternion)
        sizes = sorted((abs(part) for part in quaternion), reverse=True)
        clear = min(7, math.floor(single(30 * single(sizes[0] - sizes[1]))))
        left_out = greatest if self.body.decide("course left_out", clear) else self.raw(2)
        values, residuals = [], []
        for step in components_beside(quaternion, left_out, limit):
            residual = self.body.residual(TURN, blended(course.expected_turn_error(), residuals))
            residuals.append(float(abs(residual)))
            values.append(step + residual)
            check(abs(values[-1]) <= limit, "a component beyond its range")
        self.publication.left_out, self.publication.orientation = left_out, tuple(values)

    def finish(self):
        """Notes the record and what it teaches."""
        course, publication = self.course, self.publication
        course.turn, turn_error = NONE3, 0.0
        if not publication.upright:
            course.turn = turn_between(course.look0, quaternion_of(publication, self.level.orientation))
            off = [abs(single(a - b)) for a, b in zip(course.turn, course.turn_expected)]
            turn_error = summed(single(part / 3) for part in off)
        if publication.plain:
            return
        publication.turn_error = single(turn_error * course.per_tick)
        self.note(turn_error)
        if (publication.entity + self.body.packet.tick) % 2 == 0:
            self.teach()

    def note(self, turn_error):
        """Makes the record a neighbour of those that follow."""
        course, ratio = self.course, self.course.ratio
        displacement = [value - place for value, place in zip(self.publication.position, course.places[0])]
        moved = [single(single(a - b) / ratio) for a, b in zip(displacement, course.continued)]
        turned_more = NONE3
        if not self.publication.upright:
            turned_more = [single(a - b) for a, b in zip(course.turn, course.turn_continued)]
        errors = [single(error / ratio) for error in course.errors]
        self.body.neighbours.note(course.origin, moved, turned_more, course.turn, errors, turn_error)

    def teach(self):
        """Notes what the record says of the weights."""
        course = self.course
        for axis in XZY:
            value = self.publication.position[axis] - course.places[0][axis]
            key = ("y" if axis == 1 else "xz", course.calm)
            self.teach_axis(key, course.features[axis], value, course.magnitudes[axis])
        if not self.publication.upright:
            for axis in range(3):
                key = ("turn", course.turn_calm())
                self.teach_axis(key, course.turns[axis], course.turn[axis], course.expected_turn_error())

    def teach_axis(self, key, features, value, expected):
        """One axis."""
        weight = single(1 / single(1 + single(expected * expected)))
        count = range(len(features))
        products, values = self.body.packet.courses.setdefault(
            key, ([[0.0] * len(features) for _ in count], [0.0] * len(features)))
        for i in count:
            weighted = weight * features[i]
            values[i] += weighted * value
            for j in count:
                products[i][j] += weighted * features[j]


class Decoder:
    """Reads the coded records of a session's state packets."""

    def __init__(self, quantization=None, declared_fields=None):
        self.quantization = quantization or Quantization()
        self.declared_fields = declared_fields or {}
        self.epoch = self.newest = 0
        self.packets = {}
        self.states = [Knowledge()]

    def decode(self, packet_number, tick, zone, code_bytes):
        """Records of a packet; a ValueError says why it must be refused."""
        reader = Reader(code_bytes)
        epoch, gap = reader.raw(2), reader.raw(8)
        begins = epoch != self.epoch
        check(packet_number not in self.packets, "a packet that was decoded before")
        check(not begins or gap == 0 and packet_number > self.newest, "a packet of another epoch")
        check(gap < packet_number, "a gap that is not smaller than the packet's number")
        states = [Knowledge()] if begins or gap == 0 else self.known(reader, packet_number - gap)
        packet = Packet(packet_number, tick, zone)
        records = Body(self, reader, states[-1], packet).records()
        reader.finish()
        if begins:
            self.epoch, self.packets, self.states = epoch, {}, states
        self.remember(packet, states)
        return records

    def remember(self, packet, states):
        """Keeps a decoded packet, and the newest states of knowledge."""
        self.packets[packet.number] = packet
        self.newest = max(self.newest, packet.number)
        self.states += [state for state in states if state not in self.states]
        self.states = self.states[-KEPT_STATES:]
        for number in [number for number in self.packets if number < self.newest - 512]:
            del self.packets[number]

    def known(self, reader, newest):
        """States of knowledge up to the newest learned packet; the last one is that of the packet."""
        named, model = {newest}, (64512, 64512)
        models = {True: model, False: (16384, 16384)}
        after = True
        for back in range(1, 65):
            yes = yes_places(models[after])
            answer = reader.place() < yes
            reader.take(*((0, yes) if answer else (yes, 2 ** 15 - yes)))
            models[after] = learned_decision(models[after], answer)
            after = answer
            if answer:
                named.add(newest - back)
        check(all(number in self.packets for number in named), "a packet that was not decoded is named")
        return self.learn(named, newest)

    def learn(self, named, newest):
        """From the newest state that fits, learns the rest of the named packets."""
        for state in reversed(self.states):
            learned = [number for number, _ in state.learned if number >= newest - 64]
            last = state.learned[-1][0] if state.learned else 0
            if last <= newest and learned == sorted(number for number in named if number <= last):
                break
        else:
            raise ValueError("the state of knowledge was given up")
        states = [state]
        for number in sorted(number for number in named if number > last):
            state = state.copy()
            state.learn(self.packets[number])
            states.append(state)
        return states

"""What a client of proto/WIRE.md knows: others by dead reckoning, and the own avatar by prediction and correction."""

import bisect
import collections
import math

import coded_records
import wire_datagrams
import wire_motion
from coded_records import REMOVE, DeclaredField, Quantization, single
from wire_motion import AvatarState, Command
from wire_records import SharedDecoder

KEPT_TICKS = 600
DECLARED_NUMBER, DECLARED_ENUM, DECLARED_BOOL, DECLARED_TEXT = range(4)
STEPS = ("position_step_m", "velocity_step_mps", "acceleration_step_mps2", "angular_velocity_step_rps",
         "orientation_bits", "yaw_bits", "horizontal_extent_m", "vertical_extent_m", "max_speed_mps", "gravity_mps2")


def quantization_of(world):
    """Steps of a world."""
    told = world.quantization
    shifts = [(shift.place, shift.turn) for shift in told.lod_shift]
    shifts += [(0, 0)] * (len(world.lods) - len(shifts))
    return Quantization(lod_shift=tuple(shifts), tick_rate_hz=world.tick_rate_hz,
                        **{name: getattr(told, name) for name in STEPS})


def declared_field(told):
    """A declared field of Welcome."""
    if told.kind == DECLARED_TEXT:
        data = b"".join(word.to_bytes(4, "little") for word in told.initial)
        return DeclaredField(None, data[1:1 + data[0]].decode() if data else "")
    greatest = {DECLARED_NUMBER: told.steps, DECLARED_ENUM: len(told.values) - 1, DECLARED_BOOL: 1}[told.kind]
    return DeclaredField(greatest, told.initial[0] if told.initial else 0)


def declared_of(world):
    """Declared fields by type."""
    types = enumerate(world.types)
    return {index: [declared_field(one) for one in told.fields] for index, told in types if told.fields}


class View:
    """What was heard of entities: of each, the publications in the order of their packets.

    Of two publications of one stream the one with the later tick counts, of two streams that of the later packet."""

    def __init__(self, world, quantization):
        self.origins = {zone.id: zone.origin for zone in world.zones}
        self.quantization = quantization
        self.histories = {}

    def put(self, sequence, packet_tick, record):
        """A record of a packet."""
        history = self.histories.setdefault(record.entity, [])
        bisect.insort(history, (sequence, packet_tick, record), key=lambda one: one[0])
        while len(history) > 1 and history[1][1] < packet_tick - KEPT_TICKS:
            history.pop(0)

    def at(self, entity, tick=math.inf):
        """The publication that counts at a tick, by the packets up to it."""
        found = None
        for _, packet_tick, record in self.histories.get(entity, ()):
            if packet_tick <= tick and not (found and same_stream(found, record) and record.tick < found.tick):
                found = record
        return found if found and found.kind != REMOVE else None

    def entities(self, tick=math.inf):
        """All that are known."""
        return [entity for entity in self.histories if self.at(entity, tick)]

    def level(self, publication):
        """Steps of a publication."""
        return self.quantization.levels[publication.level]

    def seconds(self, publication, tick):
        """Age of a publication at a tick."""
        return max(0.0, (tick - publication.tick) * self.quantization.tick_s)

    def position(self, publication, tick):
        """World coordinates at a tick."""
        place = wire_motion.predict_position(publication, self.level(publication), self.quantization.gravity_mps2,
                                             self.seconds(publication, tick))
        return [a + b for a, b in zip(self.origins[publication.zone], place)]

    def orientation(self, publication, tick):
        """Quaternion at a tick."""
        return wire_motion.predict_orientation(publication, self.level(publication), self.quantization.gravity_mps2,
                                               self.seconds(publication, tick))


def same_stream(a, b):
    """Whether two records belong to one stream of an entity; a removal belongs to none."""
    return REMOVE not in (a.kind, b.kind) and (a.zone, a.level) == (b.zone, b.level)


class Sample:
    """The server's own state beside the one predicted for the same tick; positions of the world.

    `crossed` says that it is the first one in another zone."""

    def __init__(self, own, told, predicted, crossed):
        self.tick, self.missing, self.grounded = own.tick, own.missing, own.grounded
        self.told, self.predicted, self.crossed = told, predicted, crossed
        self.error = math.dist(told, predicted)


class Prediction:
    """The own avatar: commands that were made, states that they lead to, and how far those were off."""

    def __init__(self, world, tick_s):
        self.limits = next(one for one in world.types if one.character).limits
        self.origins = {zone.id: zone.origin for zone in world.zones}
        self.ground_height, self.tick_s = world.ground_height_m, single(tick_s)
        self.commands, self.states = {}, {}
        self.zone = self.newest = None
        self.samples, self.corrections = [], 0

    def make(self, tick, command):
        """Up to one more tick; no command for it is what the server takes for a missing one."""
        if command:
            self.commands[tick] = command
            self.commands.pop(tick - KEPT_TICKS, None)
        if self.newest is not None:
            self.step_to(tick)

    def step_to(self, tick):
        """The states up to a tick."""
        while self.newest < tick:
            self.newest += 1
            command = self.commands.get(self.newest) or self.repeated(self.newest)
            ground = single(self.ground_height - self.origins[self.zone][1])
            before = self.states[self.newest - 1]
            self.states[self.newest] = wire_motion.apply_command(before, command, self.limits, self.tick_s, ground)
            self.states.pop(self.newest - KEPT_TICKS, None)

    def repeated(self, tick):
        """What the server takes where no command came."""
        last = max((one for one in self.commands if one < tick), default=None)
        return wire_motion.missing_command(self.commands[last], tick, self.tick_s) if last else Command(tick)

    def enter(self, zone):
        """The avatar is in another zone now, whose coordinates begin elsewhere."""
        if self.zone is not None:
            shift = [a - b for a, b in zip(self.origins[self.zone], self.origins[zone])]
            for tick, state in self.states.items():
                place = tuple(single(a + b) for a, b in zip(state.position, shift))
                self.states[tick] = AvatarState(place, state.velocity, state.grounded)
        self.zone = zone

    def world_position(self, place):
        """Of a place in the present zone."""
        return [a + b for a, b in zip(self.origins[self.zone], place)]

    def correct(self, own, zone):
        """The server's state after a tick: later ones are worked out again from it."""
        crossed = zone != self.zone
        if crossed:
            self.enter(zone)
        state, predicted = AvatarState(own.position, own.velocity, own.grounded), self.states.get(own.tick)
        if predicted and self.commands and own.tick > min(self.commands):
            self.samples.append(Sample(own, self.world_position(state.position),
                                       self.world_position(predicted.position), crossed))
        if crossed or predicted != state:
            self.corrections += 1
            newest = max(own.tick, self.newest or 0)
            self.states[own.tick], self.newest = state, own.tick
            self.step_to(newest)

    def state(self):
        """After the newest command; None before the first own state."""
        return self.states.get(self.newest)


class Player:
    """Reads the bodies of state packets, and takes the ticks for which commands were made or left out."""

    def __init__(self, world):
        self.world, self.quantization = world, quantization_of(world)
        self.view = View(world, self.quantization)
        self.shared = SharedDecoder(self.quantization, declared_of(world))
        self.coded = coded_records.Decoder(self.quantization, declared_of(world))
        self.prediction = Prediction(world, self.quantization.tick_s)
        self.own = None
        self.packets, self.widened, self.late = {}, {}, set()
        self.counts, self.troubles = collections.Counter(), []

    def take_packet(self, sequence, body):
        """Its head, and whether it counts as accepted."""
        head = wire_datagrams.Head(body)
        self.counts["coded" if head.coded else "shared"] += 1
        self.widened[head.tick] = head.widened
        if head.own and (not self.own or head.own.tick > self.own.tick):
            self.own = head.own
            self.prediction.correct(head.own, head.zone)
        accepted = self.read_records(sequence, head)
        if accepted:
            self.packets[sequence] = head.tick
        return head, accepted

    def read_records(self, sequence, head):
        """Records of either code; whether the packet counts as accepted."""
        if not head.coded:
            records, trouble = self.shared.decode(sequence, head.tick, head.zone, head.records)
            if trouble:
                self.troubles.append(trouble)
        else:
            try:
                records = self.coded.decode(sequence & 0xFFFFFFFF, head.tick, head.zone, head.records)
            except ValueError as refusal:
                self.refuse(sequence, str(refusal))
                return False
        for record in records:
            self.counts["records"] += 1
            self.view.put(sequence, head.tick, record)
        return True

    def refuse(self, sequence, reason):
        """A coded packet that could not be decoded; a late one may be so."""
        if sequence < self.coded.newest:
            self.counts["late"] += 1
        else:
            self.troubles.append(reason)

    def take_tick(self, tick, wanted, late):
        """A command of a tick, or None where it is left out. One that is made late may be missing on the server."""
        self.prediction.make(tick, wanted and Command(tick, *wanted))
        if late:
            self.late.add(tick)

"""The truth of the server's audits against what a client made of its packets.

Where the newest news of an entity is in hand, its prediction is off by no more than its level's bound and half a step
of position along each axis, at every tick: the server runs the same prediction, and publishes when it leaves the bound.
So ticks are judged afterwards, by all packets up to them. Ticks shortly after a lost packet say nothing."""

import math

import wire_motion
from wire_datagrams import UNBOUNDED

RESENT_WITHIN_TICKS = 10  # a round trip of 0.1 s, four times its variation, and a tick
ANGLE_ROUNDING_RAD = 1e-3  # of an angle by the cosine of its half in binary32: sqrt(8 2^-24) = 0.7e-3
FLOAT_M = 1e-5             # binary32 within 64 m
REACH_M = 2.0              # radii of two bodies, and what they walk between two own states


class Judge:
    """`findings` are sentences; errors are in metres."""

    def __init__(self, player):
        self.player, self.view = player, player.view
        self.lods = len(player.world.lods)
        self.findings, self.errors, self.ratios, self.passed_over = [], [], [], 0
        self.exact = self.words = 0
        ticks, received = player.packets, sorted(player.packets)
        self.losses = [(ticks[a], ticks[b] + RESENT_WITHIN_TICKS) for a, b in zip(received, received[1:]) if b > a + 1]

    def find(self, audit, entity, text):
        """One more finding."""
        self.findings.append(f"tick {audit.tick}, entity {entity.entity}: {text}")

    def factor(self, level, tick):
        """By how much the bound of a level is wider at a tick; None where there is none."""
        told = [self.player.widened[one] for one in self.player.widened if tick - RESENT_WITHIN_TICKS <= one <= tick]
        steps = max(told, default=0)
        if steps == UNBOUNDED:
            return None
        return 2 ** sum(1 for i in range(steps) if self.lods - 1 - i % self.lods == level)

    def after_loss(self, tick):
        """Whether news of it may have been lost."""
        return any(first <= tick <= last for first, last in self.losses)

    def judge(self, audit):
        """All entities of one audit."""
        for entity in audit.entities:
            publication = self.view.at(entity.entity, audit.tick)
            if audit.frozen:
                self.compare_exactly(audit, entity)
            elif self.after_loss(audit.tick):
                self.passed_over += 1
            elif publication:
                self.compare(audit, entity, publication)
            elif entity.must_know:
                self.find(audit, entity, "is missing")

    def compare(self, audit, entity, publication):
        """Position, orientation and declared fields at a tick."""
        factor = self.factor(publication.level, audit.tick)
        if factor is None:
            self.passed_over += 1
            return
        level = self.view.level(publication)
        error = math.dist(self.view.position(publication, audit.tick), entity.position)
        allowed = entity.bound_m * factor + 0.5 * math.sqrt(3) * level.position
        self.errors.append(error)
        self.ratios.append(error / allowed)
        if error > allowed:
            self.find(audit, entity, f"{error:.4f} m off, {allowed:.4f} allowed")
        angle = wire_motion.angle_between(self.view.orientation(publication, audit.tick), entity.orientation)
        quantum = math.pi / (1 << level.yaw_bits) if publication.upright else 2.5 / level.orientation
        if angle > entity.bound_rad * factor + quantum + ANGLE_ROUNDING_RAD:
            self.find(audit, entity, f"{angle:.4f} rad off")
        self.compare_fields(audit, entity, publication)

    def compare_fields(self, audit, entity, publication):
        """Declared fields that have not changed of late."""
        told = self.player.world.types[entity.type].fields
        for index, value in enumerate(publication.declared):
            if audit.tick > entity.field_ticks[index] + RESENT_WITHIN_TICKS + told[index].interval_ticks:
                self.words += 1
                if value != entity.field_words[index]:
                    self.find(audit, entity, f"field {index} is {value} for {entity.field_words[index]}")

    def compare_exactly(self, audit, entity):
        """In a frozen world the newest publication has the server's own steps, which are told in those of level 0."""
        publication = self.view.at(entity.entity)
        if not publication:
            if entity.must_know:
                self.find(audit, entity, "is missing in the frozen world")
            return
        level = self.view.level(publication)
        found = [*publication.position, publication.left_out, *publication.orientation, publication.appearance]
        place = self.view.position(publication, audit.tick)
        off = max(abs(a - b) for a, b in zip(place, entity.position))
        same_steps = vars(level) == vars(self.view.quantization.levels[0])
        self.exact += same_steps
        if same_steps and found != entity.quantized or off > 0.5 * level.position + FLOAT_M:
            self.find(audit, entity, f"frozen at {entity.quantized} {entity.position}, seen at {found} {place}")


def clean_samples(player):
    """Samples of the own avatar before which nothing came near it and no command was late; the number of the others."""
    clean, before = [], None
    for sample in player.prediction.samples:
        ticks = range(before + 1, sample.tick + 1) if before is not None else ()
        before = sample.tick
        late = sample.missing and sample.tick in player.prediction.commands or player.late.intersection(ticks)
        if ticks and not late and not any(touched(player, tick, sample) for tick in ticks):
            clean.append(sample)
    return clean, len(player.prediction.samples) - len(clean)


def touched(player, tick, sample):
    """Whether an entity is within reach at a tick; worlds with declared fields tell of the own avatar, too."""
    for entity in player.view.entities(tick):
        place = player.view.position(player.view.at(entity, tick), tick)
        if entity != player.own.avatar and math.dist(place[::2], sample.told[::2]) < REACH_M:
            return True
    return False


def percentiles(values):
    """p50, p99 and max as a text."""
    ordered = sorted(values) or [math.nan]
    return ", ".join(f"{name} {ordered[min(len(ordered) - 1, int(share * len(ordered)))]:.6f}"
                     for name, share in (("p50", 0.5), ("p99", 0.99), ("max", 1.0)))

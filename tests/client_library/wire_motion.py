"""Motion by proto/WIRE.md: prediction of publications (section 5), and what commands do (sections 6 and 6a)."""

import dataclasses
import math

from coded_records import single

FULL_SPEED = 127
JUMP, SPRINT = 1, 2
FEW = 1e-4


def cross(a, b):
    """Cross product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def turning_move(a, w, t):
    """What a turning acceleration adds to p + v t."""
    x = math.hypot(*w) * t
    if x < FEW:
        one, two, three = 0.5, 1 / 6, 1 / 24
    else:
        one, two = (1 - math.cos(x)) / x ** 2, (x - math.sin(x)) / x ** 3
        three = (x ** 2 / 2 - 1 + math.cos(x)) / x ** 4
    across, along = cross(w, a), sum(i * j for i, j in zip(w, a))
    return [t ** 2 * (one * a[i] + t * two * across[i] + t ** 2 * three * along * w[i]) for i in range(3)]


def landing_time(p_y, v_y, floor_y, gravity):
    """When a ballistic entity comes down to its floor, in s."""
    return (v_y + math.sqrt(v_y ** 2 + 2 * gravity * max(0.0, p_y - floor_y))) / gravity


def predict_position(publication, level, gravity, t):
    """Zone-local metres, t seconds after the publication."""
    p = [part * level.position for part in publication.position]
    v = [part * level.velocity for part in publication.velocity]
    a = [part * level.acceleration for part in publication.acceleration]
    if publication.motion <= 1:
        return p
    if publication.motion == 5:
        more = turning_move(a, [part * level.rate for part in publication.turn], t)
        return [p[i] + v[i] * t + more[i] for i in range(3)]
    if publication.motion == 4:
        a = [0.0, -gravity, 0.0]
        t = min(t, landing_time(p[1], v[1], publication.floor * level.position, gravity))
    return [p[i] + v[i] * t + 0.5 * a[i] * t * t for i in range(3)]


def product(a, b):
    """Of two quaternions (w, x, y, z)."""
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])


def rotation(vector):
    """Quaternion of a turn about a vector by its length."""
    angle = math.hypot(*vector)
    scale = math.sin(angle / 2) / angle if angle > 0 else 0.0
    return (math.cos(angle / 2), *[part * scale for part in vector])


def orientation_of(publication, level):
    """Quaternion of a publication."""
    if publication.upright:
        return rotation((0.0, 2 * math.pi * publication.orientation[0] / (1 << level.yaw_bits), 0.0))
    unit = 1 / (level.orientation * math.sqrt(2))
    parts = [part * unit for part in publication.orientation]
    parts.insert(publication.left_out, math.sqrt(max(0.0, 1 - sum(part * part for part in parts))))
    return tuple(parts)


def predict_orientation(publication, level, gravity, t):
    """Quaternion, t seconds after the publication."""
    quaternion = orientation_of(publication, level)
    if publication.motion <= 1:
        return quaternion
    if publication.motion == 4:
        step = level.position
        t = min(t, landing_time(publication.position[1] * step, publication.velocity[1] * level.velocity,
                                publication.floor * step, gravity))
    turn = [part * level.rate * t for part in publication.angular_velocity]
    return product(rotation(turn), quaternion)


def angle_between(a, b):
    """Angle of the turn from one orientation to another."""
    dot = abs(sum(i * j for i, j in zip(a, b))) / math.hypot(*a) / math.hypot(*b)
    return 2 * math.acos(min(1.0, dot))


@dataclasses.dataclass(frozen=True)
class Command:
    """What the player wants of one tick."""
    tick: int
    move_x: int = 0
    move_z: int = 0
    yaw: int = 0
    pitch: int = 0
    buttons: int = 0


NO_COMMAND = Command(0)


class BitWriter:
    """A bit stream, the least significant bit of the first byte first."""

    def __init__(self):
        self.number = self.count = 0

    def put(self, value, width):
        """A number, or a two's complement one, in so many bits."""
        self.number |= (value & (1 << width) - 1) << self.count
        self.count += width

    def bytes(self):
        """All of it, padded with zeros."""
        return self.number.to_bytes((self.count + 7) // 8, "little")


def short_difference(value, before):
    """Modulo 2^16, the short way round."""
    return (value - before + 0x8000) % 0x10000 - 0x8000


def write_commands(commands):
    """Body of an input packet: 1..8 commands for consecutive ticks, oldest first."""
    bits, before = BitWriter(), NO_COMMAND
    bits.put(len(commands) - 1, 3)
    bits.put(commands[0].tick, 32)
    for command in commands:
        same = dataclasses.replace(before, tick=command.tick) == command
        bits.put(not same, 1)
        if not same:
            write_command(bits, command, before)
        before = command
    return bits.bytes()


def write_command(bits, command, before):
    """One that differs from the one before it."""
    for value, old in ((command.move_x, before.move_x), (command.move_z, before.move_z)):
        bits.put(value != old, 1)
        if value != old:
            bits.put(value, 8)
    for value, old in ((command.yaw, before.yaw), (command.pitch, before.pitch)):
        bits.put(value != old, 1)
        if value != old:
            difference = short_difference(value, old)
            short = -256 <= difference < 256
            bits.put(short, 1)
            bits.put(difference if short else value, 9 if short else 16)
    bits.put(command.buttons != before.buttons, 1)
    if command.buttons != before.buttons:
        bits.put(command.buttons < 16, 1)
        bits.put(command.buttons, 4 if command.buttons < 16 else 16)


@dataclasses.dataclass(frozen=True)
class AvatarState:
    """The own avatar after a tick, in binary32."""
    position: tuple
    velocity: tuple
    grounded: bool


def length(vector):
    """Of a vector in the plane, in binary32."""
    return single(math.sqrt(single(single(vector[0] * vector[0]) + single(vector[1] * vector[1]))))


def scaled(vector, factor):
    """In binary32."""
    return [single(part * factor) for part in vector]


def plus(a, b):
    """In binary32."""
    return [single(i + j) for i, j in zip(a, b)]


def minus(a, b):
    """In binary32."""
    return [single(i - j) for i, j in zip(a, b)]


def wanted_velocity(command, limits):
    """Of x and z."""
    d = [single(command.move_x / FULL_SPEED), single(command.move_z / FULL_SPEED)]
    size = length(d)
    if size > 1:
        d = [single(part / size) for part in d]
    speed = limits.speed
    if command.buttons & SPRINT:
        speed = single(speed * limits.sprint_factor)
    return scaled(d, speed)


def accelerate(v, wanted, a, dt):
    """New velocity and move of x and z."""
    change, most = minus(wanted, v), single(a * dt)
    size = length(change)
    if size <= most:
        time = single(size / a)
        move = plus(scaled(plus(v, wanted), single(0.5 * time)), scaled(wanted, single(dt - time)))
        return wanted, move
    after = plus(v, scaled(change, single(most / size)))
    return after, scaled(plus(v, after), single(0.5 * dt))


def apply_command(state, command, limits, dt, ground):
    """State after one tick on level ground; nothing stands in the way. A jump ends on ground of the height given."""
    dt = single(dt)
    jumps = state.grounded and command.buttons & JUMP
    airborne = not state.grounded or jumps
    a = limits.air_acceleration if airborne else limits.acceleration
    v = [state.velocity[0], state.velocity[2]]
    after, move = accelerate(v, wanted_velocity(command, limits), a, dt)
    if not airborne:
        return AvatarState(moved(state.position, (move[0], 0.0, move[1])), (after[0], 0.0, after[1]), True)
    rise = limits.jump_speed if jumps else state.velocity[1]
    fall = single(single(rise - single(single(0.5 * limits.gravity) * dt)) * dt)
    v_y = single(rise - single(limits.gravity * dt))
    return land(state.position, (move[0], fall, move[1]), (after[0], v_y, after[1]),
                single(ground + single(limits.radius + limits.half_segment)))


def moved(place, move):
    """In binary32."""
    return tuple(plus(place, move))


def land(place, move, velocity, rest):
    """State after a move through the air, which ends on the ground if it leads below the height of rest."""
    gap = single(place[1] - rest)
    if not (move[1] < 0 and gap < -move[1]):
        return AvatarState(moved(place, move), velocity, False)
    share = single(max(gap, 0.0) / -move[1])
    place = moved(place, scaled(move, share))
    place = moved(place, scaled((move[0], 0.0, move[2]), single(1 - share)))
    return AvatarState((place[0], rest, place[2]), (velocity[0], 0.0, velocity[2]), True)


def missing_command(last, tick, dt):
    """The command of a tick for which none came, by the last one that did."""
    if tick - last.tick <= round(1 / dt):
        return dataclasses.replace(last, tick=tick, buttons=last.buttons & ~JUMP)
    return dataclasses.replace(last, tick=tick, move_x=0, move_z=0, buttons=0)

"""zoned_client: joins a zoned server from Python.

A thin layer over libzoned_client.so; zoned_client.h beside it says what each field means, in which
unit and frame. The library is looked for beside this file, then where the system keeps libraries;
the environment variable ZONED_CLIENT_LIBRARY names another one.

    client = Client(name="ann")
    client.connect("127.0.0.1", 7777)
    while client.poll() != State.CLOSED:
        client.set_input(move_z=1.0)
        for entity in client.entities():
            print(entity.id, list(entity.position))
"""

import ctypes
import enum
import math
import os
import pathlib
import time

ABI = 1 << 16 | 4  # of zoned_client.h: major version 1, minor version 4
NAME_BYTES = 64


class State(enum.IntEnum):
    IDLE = 0
    CONNECTING = 1
    ONLINE = 2
    WAITING = 3
    CLOSED = 4


class Trust(enum.IntEnum):
    DEFAULT = 0
    PIN = 1
    ANYONE = 2
    AUTHORITIES = 3


class StreamWish(enum.IntEnum):
    NOTHING = 0
    OPEN = 1
    CLOSE = 2


class View(enum.IntEnum):
    EXTRAPOLATE = 0
    INTERPOLATE = 1


TOO_SMALL = -3


class Error(Exception):
    """A call that the library refused."""


class Sized(ctypes.Structure):
    """A struct that begins with its size."""

    def __init__(self, **fields):
        super().__init__(**fields)
        self.size = ctypes.sizeof(self)


class SocketKind(enum.IntEnum):
    STREAM = 0
    DATAGRAMS = 1


SOCKET_ENDED = -1
SOCKET_FAILED = -2


class Allocator(Sized):
    """Memory of the game's own, by functions of C: Python's would take memory themselves."""

    _fields_ = [
        ("size", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
        ("context", ctypes.c_void_p),
        ("allocate", ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t)),
        ("release", ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)),
    ]


class Sockets(Sized):
    """Sockets of the game's own. Keep it as long as its client."""

    _fields_ = [
        ("size", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
        ("context", ctypes.c_void_p),
        ("open", ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p,
                                  ctypes.c_uint16)),
        ("send", ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p,
                                  ctypes.c_size_t)),
        ("receive", ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_int,
                                     ctypes.c_void_p, ctypes.c_size_t)),
        ("close", ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int)),
    ]


class Settings(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("view", ctypes.c_uint32),
        ("name", ctypes.c_char_p),
        ("team", ctypes.c_char_p),
        ("ticket", ctypes.c_char_p),
        ("ticket_size", ctypes.c_size_t),
        ("config_digest", ctypes.c_char_p),
        ("trust", ctypes.c_uint32),
        ("measure", ctypes.c_uint32),
        ("pin", ctypes.c_char_p),
        ("ca_file", ctypes.c_char_p),
        ("world", ctypes.c_char_p),
        ("allocator", ctypes.POINTER(Allocator)),
        ("sockets", ctypes.POINTER(Sockets)),
        ("server_name", ctypes.c_char_p),
        ("no_threads", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
    ]


class Input(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("buttons", ctypes.c_uint32),
        ("move_x", ctypes.c_float),
        ("move_z", ctypes.c_float),
        ("yaw", ctypes.c_float),
        ("pitch", ctypes.c_float),
    ]


class Entity(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("id", ctypes.c_uint32),
        ("type", ctypes.c_uint32),
        ("zone", ctypes.c_uint32),
        ("position", ctypes.c_double * 3),
        ("orientation", ctypes.c_float * 4),
        ("velocity", ctypes.c_float * 3),
        ("appearance", ctypes.c_uint32),
        ("at_rest", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
    ]


class FieldKind(enum.IntEnum):
    NUMBER = 0
    ENUM = 1
    BOOL = 2
    TEXT = 3


class FieldInfo(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("kind", ctypes.c_uint32),
        ("minimum", ctypes.c_double),
        ("maximum", ctypes.c_double),
        ("quantum", ctypes.c_double),
        ("values", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
        ("name", ctypes.c_char * NAME_BYTES),
    ]


class FieldValue(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("kind", ctypes.c_uint32),
        ("number", ctypes.c_double),
        ("text", ctypes.c_char * NAME_BYTES),
    ]


class Avatar(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("id", ctypes.c_uint32),
        ("zone", ctypes.c_uint32),
        ("grounded", ctypes.c_uint32),
        ("carried", ctypes.c_uint32),
        ("yaw", ctypes.c_float),
        ("position", ctypes.c_double * 3),
        ("eye", ctypes.c_double * 3),
        ("velocity", ctypes.c_float * 3),
        ("reserved", ctypes.c_uint32),
        ("tick", ctypes.c_int64),
    ]


class Event(Sized):
    """`payload` is added by Client.next_event()."""

    _fields_ = [
        ("size", ctypes.c_uint32),
        ("kind", ctypes.c_uint32),
        ("tick", ctypes.c_int64),
        ("id", ctypes.c_uint64),
        ("payload_size", ctypes.c_size_t),
        ("history", ctypes.c_uint32),
        ("topic", ctypes.c_char * NAME_BYTES),
        ("reserved", ctypes.c_uint32),
    ]


class World(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("types", ctypes.c_uint32),
        ("zones", ctypes.c_uint32),
        ("rights", ctypes.c_uint32),
        ("tick_s", ctypes.c_double),
        ("server_time", ctypes.c_double),
        ("tick", ctypes.c_int64),
    ]


class TypeInfo(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("upright", ctypes.c_uint32),
        ("character", ctypes.c_uint32),
        ("seats", ctypes.c_uint32),
        ("radius", ctypes.c_float),
        ("half_segment", ctypes.c_float),
        ("speed", ctypes.c_float),
        ("sprint_factor", ctypes.c_float),
        ("jump_speed", ctypes.c_float),
        ("gravity", ctypes.c_float),
        ("name", ctypes.c_char * NAME_BYTES),
    ]


class ZoneInfo(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("id", ctypes.c_uint32),
        ("lower", ctypes.c_double * 2),
        ("upper", ctypes.c_double * 2),
        ("ground_height", ctypes.c_double),
        ("boxes", ctypes.c_uint32),
        ("triangles", ctypes.c_uint32),
    ]


class Box(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("door", ctypes.c_uint32),
        ("centre", ctypes.c_double * 3),
        ("half_extents", ctypes.c_float * 3),
        ("orientation", ctypes.c_float * 4),
        ("shut", ctypes.c_uint32),
        ("platform", ctypes.c_uint32),
    ]


class Sight(ctypes.Structure):
    _fields_ = [
        ("entity", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
        ("publication", ctypes.c_int64),
        ("position", ctypes.c_double * 3),
    ]


class Aim(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("past", ctypes.c_uint32),
        ("tick", ctypes.c_int64),
        ("fraction", ctypes.c_double),
        ("hit", ctypes.c_uint32),
        ("sights", ctypes.c_uint32),
        ("distance", ctypes.c_double),
        ("sight", Sight * 8),
    ]


class Particle(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("age", ctypes.c_float),
        ("position", ctypes.c_double * 3),
        ("velocity", ctypes.c_float * 3),
        ("reserved", ctypes.c_uint32),
    ]


class Stats(Sized):
    _fields_ = [
        ("size", ctypes.c_uint32),
        ("tunnelled", ctypes.c_uint32),
        ("rtt_ms", ctypes.c_double),
        ("input_lead_ms", ctypes.c_double),
        ("packets_in", ctypes.c_uint64),
        ("packets_out", ctypes.c_uint64),
        ("bytes_in", ctypes.c_uint64),
        ("bytes_out", ctypes.c_uint64),
        ("malformed", ctypes.c_uint64),
        ("resumed", ctypes.c_uint64),
        ("inputs", ctypes.c_uint64),
        ("inputs_missing", ctypes.c_uint64),
        ("events_dropped", ctypes.c_uint64),
        ("corrections", ctypes.c_uint64),
        ("correction_last_m", ctypes.c_double),
        ("correction_p99_m", ctypes.c_double),
        ("correction_max_m", ctypes.c_double),
        ("compared", ctypes.c_uint64),
        ("displayed_error_p50_m", ctypes.c_double),
        ("displayed_error_p99_m", ctypes.c_double),
        ("own_error_p99_m", ctypes.c_double),
    ]


def _load():
    beside = pathlib.Path(__file__).resolve().parent / "libzoned_client.so.1"
    named = os.environ.get("ZONED_CLIENT_LIBRARY") or (str(beside) if beside.exists() else None)
    library = ctypes.CDLL(named or "libzoned_client.so.1")
    client, index = ctypes.c_void_p, ctypes.c_uint32
    vector = ctypes.POINTER(ctypes.c_double)

    def declare(name, result, *arguments):
        function = getattr(library, "zoned_client_" + name)
        function.restype = result
        function.argtypes = arguments

    declare("abi_version", ctypes.c_uint32)
    declare("create", client, ctypes.c_uint32, ctypes.POINTER(Settings), ctypes.c_char_p,
            ctypes.c_size_t)
    declare("destroy", None, client)
    declare("connect", ctypes.c_int, client, ctypes.c_char_p, ctypes.c_uint16)
    declare("begin", ctypes.c_int, client)
    declare("stream_wish", ctypes.c_int, client)
    declare("stream_opened", ctypes.c_int, client)
    declare("stream_frame", ctypes.c_int, client, ctypes.c_char_p, ctypes.c_size_t)
    declare("stream_closed", ctypes.c_int, client, ctypes.c_char_p)
    declare("next_frame", ctypes.c_size_t, client, ctypes.c_char_p, ctypes.c_size_t)
    declare("quit", None, client)
    declare("poll", ctypes.c_int, client, ctypes.c_double)
    declare("get_state", ctypes.c_int, client)
    declare("trouble", ctypes.c_char_p, client)
    declare("set_input", ctypes.c_int, client, ctypes.POINTER(Input))
    declare("command", ctypes.c_int, client, ctypes.c_uint32, ctypes.c_char_p, ctypes.c_size_t)
    declare("next_event", ctypes.c_int, client, ctypes.POINTER(Event), ctypes.c_char_p,
            ctypes.c_size_t)
    declare("entities", ctypes.c_size_t, client, ctypes.POINTER(Entity), ctypes.c_size_t)
    declare("get_entity", ctypes.c_int, client, ctypes.c_uint32, ctypes.POINTER(Entity))
    declare("fields", ctypes.c_int, client, index)
    declare("field", ctypes.c_int, client, index, index, ctypes.POINTER(FieldInfo))
    declare("field_at", ctypes.c_int, client, ctypes.c_uint32, index, ctypes.POINTER(FieldValue))
    declare("field_named", ctypes.c_int, client, ctypes.c_uint32, ctypes.c_char_p,
            ctypes.POINTER(FieldValue))
    declare("deform", ctypes.c_int, client, ctypes.c_uint32, ctypes.POINTER(ctypes.c_float),
            ctypes.c_size_t)
    declare("own", ctypes.c_int, client, ctypes.POINTER(Avatar))
    declare("get_world", ctypes.c_int, client, ctypes.POINTER(World))
    declare("type", ctypes.c_int, client, index, ctypes.POINTER(TypeInfo))
    declare("zone", ctypes.c_int, client, index, ctypes.POINTER(ZoneInfo))
    declare("aim", ctypes.c_int, client, vector, vector, ctypes.c_double, ctypes.POINTER(Aim))
    declare("stats", ctypes.c_int, client, ctypes.POINTER(Stats))
    declare("shared_value", ctypes.c_int, client, ctypes.c_char_p, vector)
    declare("server_time", ctypes.c_double, client)
    declare("boxes", ctypes.c_size_t, client, index, ctypes.POINTER(Box), ctypes.c_size_t)
    declare("triangles", ctypes.c_size_t, client, index, vector, ctypes.c_size_t)
    declare("particles", ctypes.c_size_t, client, ctypes.POINTER(Particle), ctypes.c_size_t)
    return library


_library = _load()


def _bytes(text):
    return text.encode() if isinstance(text, str) else text


class Client:
    """One session with a server. Not for several threads at a time."""

    def __init__(self, name, team="", ticket=b"", trust=Trust.DEFAULT, pin="", ca_file="",
                 config_digest="", view=View.EXTRAPOLATE, abi=ABI, world="", allocator=None,
                 sockets=None, server_name="", no_threads=False):
        settings = Settings(view=view, name=_bytes(name), team=_bytes(team), ticket=ticket,
                            ticket_size=len(ticket), config_digest=_bytes(config_digest),
                            trust=trust, pin=_bytes(pin), ca_file=_bytes(ca_file),
                            world=_bytes(world), server_name=_bytes(server_name),
                            no_threads=no_threads)
        if allocator:
            settings.allocator = ctypes.pointer(allocator)
        if sockets:
            settings.sockets = ctypes.pointer(sockets)
        error = ctypes.create_string_buffer(512)
        self._client = _library.zoned_client_create(abi, settings, error, len(error))
        if not self._client:
            raise Error(error.value.decode(errors="replace"))
        self._entities = self._array(Entity, 256)
        self._payload = ctypes.create_string_buffer(4096)

    def close(self):
        """Says goodbye and frees the client."""
        _library.zoned_client_destroy(self._client)
        self._client = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __del__(self):
        if getattr(self, "_client", None):
            self.close()

    def connect(self, host, port):
        self._check(_library.zoned_client_connect(self._client, _bytes(host), port))

    def begin(self):
        """In place of connect(): the session goes over a WebSocket of the caller."""
        self._check(_library.zoned_client_begin(self._client))

    def stream_wish(self):
        return StreamWish(self._check(_library.zoned_client_stream_wish(self._client)))

    def stream_opened(self):
        self._check(_library.zoned_client_stream_opened(self._client))

    def stream_frame(self, frame):
        self._check(_library.zoned_client_stream_frame(self._client, frame, len(frame)))

    def stream_closed(self, reason):
        self._check(_library.zoned_client_stream_closed(self._client, _bytes(reason)))

    def next_frame(self):
        """The oldest frame to send as one binary message; None: none waits."""
        size = _library.zoned_client_next_frame(self._client, None, 0)
        if size == 0:
            return None
        frame = ctypes.create_string_buffer(size)
        _library.zoned_client_next_frame(self._client, frame, size)
        return frame.raw

    def quit(self):
        _library.zoned_client_quit(self._client)

    def poll(self, now_s=None):
        """All work of a frame; the clock is time.monotonic() where none is given."""
        now_s = time.monotonic() if now_s is None else now_s
        return State(_library.zoned_client_poll(self._client, now_s))

    @property
    def state(self):
        return State(_library.zoned_client_get_state(self._client))

    @property
    def trouble(self):
        return _library.zoned_client_trouble(self._client).decode(errors="replace")

    @property
    def server_time(self):
        return _library.zoned_client_server_time(self._client)

    def set_input(self, move_x=0.0, move_z=0.0, yaw=0.0, pitch=0.0, buttons=0):
        wanted = Input(buttons=buttons, move_x=move_x, move_z=move_z, yaw=yaw, pitch=pitch)
        self._check(_library.zoned_client_set_input(self._client, wanted))

    def walk(self, angle, speed=1.0, buttons=0):
        """Walks and looks along a yaw, in radians."""
        self.set_input(speed * math.sin(angle), speed * math.cos(angle), angle, 0.0, buttons)

    def command(self, kind, payload=b""):
        self._check(_library.zoned_client_command(self._client, kind, payload, len(payload)))

    def next_event(self):
        """The next event with its `payload`, or None."""
        event = Event()
        got = self._fetch(event)
        if got == TOO_SMALL:
            self._payload = ctypes.create_string_buffer(event.payload_size)
            got = self._fetch(event)
        if self._check(got) == 0:
            return None
        event.payload = self._payload.raw[: event.payload_size]
        return event

    def events(self):
        """All events that wait."""
        return iter(self.next_event, None)

    def entities(self):
        """The displayed entities; good until the next call."""
        count = _library.zoned_client_entities(self._client, self._entities, len(self._entities))
        if count > len(self._entities):
            self._entities = self._array(Entity, 2 * count)
            return self.entities()
        return self._entities[:count]

    def entity(self, identity):
        return self._maybe("get_entity", Entity(), identity)

    def fields(self, type_index):
        """The fields that a type declares, as FieldInfo."""
        count = self._check(_library.zoned_client_fields(self._client, type_index))
        return [self._filled("field", FieldInfo(), type_index, index) for index in range(count)]

    def field(self, identity, name):
        """The newest value of an entity's field, by name or index: a float, a bool or a str (a text,
        or the name of an enum's value); None where the entity is not known or has no such field."""
        by_name = isinstance(name, (str, bytes))
        value = self._maybe("field_named" if by_name else "field_at", FieldValue(), identity,
                            _bytes(name) if by_name else name)
        if value is None:
            return None
        if value.kind == FieldKind.NUMBER:
            return value.number
        return value.number != 0 if value.kind == FieldKind.BOOL else value.text.decode()

    def deform(self, identity, places):
        """Where places of three numbers on the undeformed soft body are now, before the entity's
        pose; None where the entity is not known or has no deformation."""
        places = list(places)
        numbers = (ctypes.c_float * (3 * len(places)))(*(x for place in places for x in place))
        if self._check(_library.zoned_client_deform(self._client, identity, numbers, len(places))) == 0:
            return None
        return [tuple(numbers[3 * i : 3 * i + 3]) for i in range(len(places))]

    def own(self):
        return self._maybe("own", Avatar())

    def world(self):
        return self._filled("get_world", World())

    def type(self, index):
        return self._filled("type", TypeInfo(), index)

    def zone(self, index):
        return self._filled("zone", ZoneInfo(), index)

    def stats(self):
        return self._filled("stats", Stats())

    def shared_value(self, name):
        value = ctypes.c_double()
        self._check(_library.zoned_client_shared_value(self._client, _bytes(name), value))
        return value.value

    def aim(self, eye, direction, range_m):
        vector = ctypes.c_double * 3
        return self._filled("aim", Aim(), vector(*eye), vector(*direction), range_m)

    def boxes(self, zone):
        return self._all("boxes", Box, zone)

    def particles(self):
        return self._all("particles", Particle)

    def triangles(self, zone):
        """Nine numbers for each triangle."""
        count = _library.zoned_client_triangles(self._client, zone, None, 0)
        numbers = (ctypes.c_double * (9 * count))()
        _library.zoned_client_triangles(self._client, zone, numbers, count)
        return [tuple(numbers[9 * i : 9 * i + 9]) for i in range(count)]

    def _fetch(self, event):
        return _library.zoned_client_next_event(self._client, event, self._payload,
                                                len(self._payload))

    def _check(self, result):
        if result < 0:
            raise Error(self.trouble or f"refused with {result}")
        return result

    def _maybe(self, function, out, *arguments):
        call = getattr(_library, "zoned_client_" + function)
        return out if call(self._client, *arguments, out) == 1 else None

    def _filled(self, function, out, *arguments):
        self._check(getattr(_library, "zoned_client_" + function)(self._client, *arguments, out))
        return out

    @staticmethod
    def _array(kind, count):
        array = (kind * count)()
        array[0].size = ctypes.sizeof(kind)
        return array

    def _all(self, function, kind, *arguments):
        call = getattr(_library, "zoned_client_" + function)
        count = call(self._client, *arguments, None, 0)
        array = self._array(kind, max(count, 1))
        return array[: call(self._client, *arguments, array, count)]

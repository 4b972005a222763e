"""Messages of a `.proto` file as Python objects, without a library for protobuf.

Reads what the files in proto/ use of proto3: messages, enums, oneofs, and repeated fields of all types."""

import re
import struct

VARINTS = ("uint32", "uint64", "int32", "int64", "bool")
ZIGZAGS = ("sint32", "sint64")
FIXED = {"float": "<f", "double": "<d", "fixed32": "<I", "fixed64": "<Q"}
TEXTS = ("bytes", "string")
TOKEN = re.compile(r'"[^"]*"|[\w.]+|[{}=;\[\],<>-]')


class Message:
    """Values of a message: one attribute for each field, `which` for the fields that were present."""

    def __init__(self):
        self.which = []


class Field:
    """A field of a message."""

    def __init__(self, name, kind, repeated):
        self.name, self.kind, self.repeated = name, kind, repeated


class Schema:
    """Messages and enums of one file: `messages` by full name within it, `enums` by the names of values."""

    def __init__(self, path):
        text = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
        self.messages, self.enums = {}, {}
        self.tokens = TOKEN.findall(text)
        self.at = 0
        while self.at < len(self.tokens):
            word = self.next()
            if word == "message":
                self.read_message("")
            elif word == "enum":
                self.read_enum()
            else:
                self.skip_statement()

    def next(self):
        """The next word."""
        self.at += 1
        return self.tokens[self.at - 1]

    def skip_statement(self):
        """Up to the next semicolon."""
        while self.next() != ";":
            pass

    def read_enum(self):
        """An enum: its values have names of their own."""
        self.next()
        self.next()
        while (name := self.next()) != "}":
            self.next()
            self.enums[name] = int(self.next())
            self.skip_statement()

    def read_message(self, outer):
        """A message with those inside it."""
        name = outer + self.next()
        fields = self.messages[name] = {}
        self.read_fields(name, fields)

    def read_fields(self, name, fields):
        """Fields up to the closing brace; a oneof's are like all others."""
        self.next()
        while (word := self.next()) != "}":
            if word == "message":
                self.read_message(name + ".")
            elif word == "enum":
                self.read_enum()
            elif word == "oneof":
                self.next()
                self.read_fields(name, fields)
            elif word in ("reserved", "option"):
                self.skip_statement()
            else:
                repeated = word == "repeated"
                kind = self.next() if repeated else word
                field = Field(self.next(), kind, repeated)
                self.next()
                fields[int(self.next())] = field
                self.skip_statement()

    def full_name(self, kind, scope):
        """The message that a field's type names, from the innermost scope outwards; None for an enum."""
        while True:
            name = f"{scope}.{kind}" if scope else kind
            if name in self.messages:
                return name
            if not scope:
                return None
            scope = scope.rpartition(".")[0]

    def encode(self, name, values):
        """Bytes of a message from a dict; a value that is a dict is a message of its own."""
        parts = []
        for number, field in self.messages[name].items():
            if field.name in values:
                value = values[field.name]
                for one in value if field.repeated else [value]:
                    parts.append(self.encode_field(number, field.kind, one, name))
        unknown = set(values) - {field.name for field in self.messages[name].values()}
        if unknown:
            raise KeyError(f"{name} has no {unknown}")
        return b"".join(parts)

    def encode_field(self, number, kind, value, scope):
        """One value with its tag."""
        if kind in FIXED:
            return varint(number << 3 | (5 if kind in ("float", "fixed32") else 1)) + struct.pack(FIXED[kind], value)
        if kind in ZIGZAGS:
            return varint(number << 3) + varint(value << 1 if value >= 0 else -value * 2 - 1)
        inner = None if kind in TEXTS or kind in VARINTS else self.full_name(kind, scope)
        if kind in TEXTS or inner:
            body = self.encode(inner, value) if inner else value.encode() if isinstance(value, str) else value
            return varint(number << 3 | 2) + varint(len(body)) + body
        return varint(number << 3) + varint(value & 2 ** 64 - 1)

    def decode(self, name, data):
        """A message from its bytes; a ValueError where they are none."""
        message, fields = Message(), self.messages[name]
        for field in fields.values():
            setattr(message, field.name, self.default(field, name))
        at = 0
        while at < len(data):
            tag, at = read_varint(data, at)
            value, at = read_wire(data, at, tag & 7)
            field = fields.get(tag >> 3)
            if field:
                self.put(message, field, value, name)
        return message

    def default(self, field, scope):
        """Value of a field that is absent."""
        if field.repeated:
            return []
        if field.kind in TEXTS:
            return b""
        if field.kind in FIXED or field.kind in VARINTS or field.kind in ZIGZAGS:
            return 0
        return None if self.full_name(field.kind, scope) else 0

    def put(self, message, field, value, scope):
        """A value that came."""
        message.which.append(field.name)
        packed = field.repeated and isinstance(value, bytes) and field.kind not in TEXTS
        inner = self.full_name(field.kind, scope)
        if packed and not inner:
            getattr(message, field.name).extend(self.unpack(field.kind, value))
            return
        if inner:
            value = self.decode(inner, value)
        elif field.kind not in TEXTS:
            value = scalar(field.kind, value)
        if field.repeated:
            getattr(message, field.name).append(value)
        else:
            setattr(message, field.name, value)

    @staticmethod
    def unpack(kind, data):
        """Values that stand in one field behind each other."""
        if kind in FIXED:
            return [value for value, in struct.iter_unpack(FIXED[kind], data)]
        values, at = [], 0
        while at < len(data):
            value, at = read_varint(data, at)
            values.append(scalar(kind, value))
        return values


def scalar(kind, value):
    """A number by its wire value, which is the raw bytes of those with a fixed width."""
    if kind in FIXED:
        return struct.unpack(FIXED[kind], value)[0]
    if kind in ZIGZAGS:
        return value >> 1 ^ -(value & 1)
    if kind in ("int32", "int64") and value >= 2 ** 63:
        return value - 2 ** 64
    return value


def varint(value):
    """LEB128: 7 bits a byte, low bits first."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)


def read_varint(data, at):
    """A varint and the place behind it."""
    value = shift = 0
    while True:
        if at >= len(data) or shift > 63:
            raise ValueError("a varint that does not end")
        value |= (data[at] & 127) << shift
        shift += 7
        at += 1
        if data[at - 1] < 128:
            return value, at


def read_wire(data, at, wire):
    """A value of a wire type and the place behind it."""
    if wire == 0:
        return read_varint(data, at)
    if wire not in (1, 2, 5):
        raise ValueError(f"an unknown wire type {wire}")
    size = {1: 8, 5: 4}.get(wire)
    if wire == 2:
        size, at = read_varint(data, at)
    if at + size > len(data):
        raise ValueError("a field beyond the end")
    return data[at:at + size], at + size

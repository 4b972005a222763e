// encode and decode: protobuf messages of clients as tables. A schema lists the fields:
// "1 int tick, 2 float dx". Kinds: int, sint, bool, float, double, bytes, and ints for a list.
#include "server/scripting/api/arguments.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <optional>
#include <string>

namespace zoned::scripting {

namespace {

constexpr std::size_t kMaxSchemaBytes = 512;
constexpr std::size_t kMaxFields = 32;
constexpr std::size_t kMessageBytesPerUnit = 4;
constexpr unsigned kMaxVarintBits = 64;

enum class FieldKind : std::uint8_t {
    kInt,
    kSint,
    kBool,
    kFloat,
    kDouble,
    kBytes,
    kInts
};

constexpr std::array<std::string_view, 7>
    kFieldKinds{"int", "sint", "bool", "float", "double", "bytes", "ints"};

enum WireType : std::uint32_t {
    kVarint = 0,
    kFixed64 = 1,
    kLength = 2,
    kFixed32 = 5
};

struct MessageField {
    std::uint32_t number = 0;
    FieldKind kind = FieldKind::kInt;
    std::string_view name;
};

struct MessageSchema {
    std::array<MessageField, kMaxFields> fields;
    std::size_t count = 0;
};

WireType wire_type(FieldKind kind) {
    switch (kind) {
        case FieldKind::kFloat:
            return kFixed32;
        case FieldKind::kDouble:
            return kFixed64;
        case FieldKind::kBytes:
        case FieldKind::kInts:
            return kLength;
        case FieldKind::kInt:
        case FieldKind::kSint:
        case FieldKind::kBool:
            break;
    }
    return kVarint;
}

std::string_view next_word(std::string_view& rest) {
    constexpr std::string_view kBetween = " ,\n";
    rest.remove_prefix(std::min(rest.find_first_not_of(kBetween), rest.size()));
    const std::string_view word = rest.substr(0, rest.find_first_of(kBetween));
    rest.remove_prefix(word.size());
    return word;
}

MessageSchema schema_argument(lua_State* lua, int index) {
    std::string_view rest = text_argument(lua, index, "schema", kMaxSchemaBytes);
    MessageSchema schema;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
        luaL_argcheck(lua, schema.count < kMaxFields, index, "schema: more than 32 fields");
        MessageField& field = schema.fields[schema.count++];
        const auto number = std::from_chars(word.data(), word.data() + word.size(), field.number);
        const auto kind = std::find(kFieldKinds.begin(), kFieldKinds.end(), next_word(rest));
        field.name = next_word(rest);
        luaL_argcheck(lua,
                      number.ec == std::errc() && field.number > 0 && kind != kFieldKinds.end() &&
                          !field.name.empty(),
                      index,
                      "schema: fields read like '1 int tick, 2 float dx'");
        field.kind = static_cast<FieldKind>(kind - kFieldKinds.begin());
    }
    Interpreter::charge(lua, schema.count * 2);
    return schema;
}

std::int64_t from_zigzag(std::uint64_t bits) {
    return static_cast<std::int64_t>(bits >> 1U) ^ -static_cast<std::int64_t>(bits & 1U);
}

std::uint64_t to_zigzag(std::int64_t number) {
    return (static_cast<std::uint64_t>(number) << 1U) ^ static_cast<std::uint64_t>(number >> 63);
}

/// Reads a message; every step says whether the bytes were good.
class WireReader {
  public:
    explicit WireReader(std::string_view bytes) : bytes_(bytes) {}

    [[nodiscard]] bool done() const { return bytes_.empty(); }

    std::optional<std::uint64_t> varint() {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < kMaxVarintBits && !bytes_.empty(); shift += 7) {
            const auto byte = static_cast<std::uint8_t>(bytes_[0]);
            bytes_.remove_prefix(1);
            value |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
            if (byte < 0x80) {
                return value;
            }
        }
        return std::nullopt;
    }

    std::optional<std::string_view> take(std::uint64_t count) {
        if (count > bytes_.size()) {
            return std::nullopt;
        }
        const std::string_view some = bytes_.substr(0, count);
        bytes_.remove_prefix(count);
        return some;
    }

    /// The content of a field of that type: its bytes, or a number for a varint.
    std::optional<std::string_view> payload(std::uint64_t type, std::uint64_t& number) {
        switch (type) {
            case kVarint:
                if (const auto value = varint()) {
                    number = *value;
                    return std::string_view();
                }
                return std::nullopt;
            case kFixed64:
                return take(8);
            case kFixed32:
                return take(4);
            case kLength:
                if (const auto length = varint()) {
                    return take(*length);
                }
                return std::nullopt;
            default:
                return std::nullopt;
        }
    }

  private:
    std::string_view bytes_;
};

template <class Bits>
Bits little_endian(std::string_view bytes) {
    Bits bits = 0;
    for (std::size_t i = 0; i < sizeof(Bits); ++i) {
        bits |= static_cast<Bits>(static_cast<std::uint8_t>(bytes[i])) << (8U * i);
    }
    return bits;
}

void push_default(lua_State* lua, FieldKind kind) {
    switch (kind) {
        case FieldKind::kInt:
        case FieldKind::kSint:
            lua_pushinteger(lua, 0);
            return;
        case FieldKind::kBool:
            lua_pushboolean(lua, 0);
            return;
        case FieldKind::kFloat:
        case FieldKind::kDouble:
            lua_pushnumber(lua, 0);
            return;
        case FieldKind::kBytes:
            lua_pushliteral(lua, "");
            return;
        case FieldKind::kInts:
            lua_newtable(lua);
            return;
    }
}

/// Appends to the list at the top of the stack; false where the bytes are bad.
bool append_ints(lua_State* lua, std::string_view bytes) {
    WireReader reader(bytes);
    for (auto at = static_cast<lua_Integer>(lua_rawlen(lua, -1)); !reader.done();) {
        const auto value = reader.varint();
        if (!value) {
            return false;
        }
        lua_pushinteger(lua, static_cast<lua_Integer>(*value));
        lua_rawseti(lua, -2, ++at);
    }
    return true;
}

/// Sets a field of the table at the top; false where the bytes are bad.
bool decode_field(lua_State* lua,
                  const MessageField& field,
                  std::string_view bytes,
                  std::uint64_t number) {
    push_text(lua, field.name);
    switch (field.kind) {
        case FieldKind::kInt:
            lua_pushinteger(lua, static_cast<lua_Integer>(number));
            break;
        case FieldKind::kSint:
            lua_pushinteger(lua, from_zigzag(number));
            break;
        case FieldKind::kBool:
            lua_pushboolean(lua, number != 0 ? 1 : 0);
            break;
        case FieldKind::kFloat:
            lua_pushnumber(
                lua,
                static_cast<lua_Number>(std::bit_cast<float>(little_endian<std::uint32_t>(bytes))));
            break;
        case FieldKind::kDouble:
            lua_pushnumber(lua, std::bit_cast<double>(little_endian<std::uint64_t>(bytes)));
            break;
        case FieldKind::kBytes:
            push_text(lua, bytes);
            break;
        case FieldKind::kInts:
            lua_pushvalue(lua, -1);
            lua_rawget(lua, -3);
            if (!append_ints(lua, bytes)) {
                return false;
            }
            break;
    }
    lua_rawset(lua, -3);
    return true;
}

bool decode_message(lua_State* lua, const MessageSchema& schema, std::string_view bytes) {
    WireReader reader(bytes);
    while (!reader.done()) {
        const auto tag = reader.varint();
        std::uint64_t number = 0;
        const auto payload = tag ? reader.payload(*tag & 7U, number) : std::nullopt;
        if (!payload) {
            return false;
        }
        for (std::size_t i = 0; i < schema.count; ++i) {
            const MessageField& field = schema.fields[i];
            if (field.number == *tag >> 3U && (wire_type(field.kind) != (*tag & 7U) ||
                                               !decode_field(lua, field, *payload, number))) {
                return false;
            }
        }
    }
    return true;
}

/// decode(payload, schema): a table with a value for each field; nil where the bytes are no such
/// message. Unknown fields are left out.
int decode(lua_State* lua) {
    const std::string_view bytes = text_argument(lua, 1, "payload", kMaxTextBytes);
    const MessageSchema schema = schema_argument(lua, 2);
    Interpreter::charge(
        lua, bytes.size() / kMessageBytesPerUnit * std::max<std::size_t>(schema.count, 1));
    lua_createtable(lua, 0, static_cast<int>(schema.count));
    const int message = lua_gettop(lua);
    for (std::size_t i = 0; i < schema.count; ++i) {
        push_text(lua, schema.fields[i].name);
        push_default(lua, schema.fields[i].kind);
        lua_rawset(lua, message);
    }
    if (!decode_message(lua, schema, bytes)) {
        lua_pushnil(lua);
        return 1;
    }
    lua_settop(lua, message);
    return 1;
}

void put_varint(std::string& out, std::uint64_t value) {
    for (; value >= 0x80; value >>= 7U) {
        out.push_back(static_cast<char>(value | 0x80U));
    }
    out.push_back(static_cast<char>(value));
}

template <class Bits>
void put_little_endian(std::string& out, Bits bits) {
    for (std::size_t i = 0; i < sizeof(Bits); ++i) {
        out.push_back(static_cast<char>(bits >> (8U * i)));
    }
}

std::string packed_ints(lua_State* lua, int list) {
    std::string packed;
    const auto count = static_cast<lua_Integer>(luaL_len(lua, list));
    for (lua_Integer i = 1; i <= count && packed.size() <= kMaxTextBytes; ++i) {
        Interpreter::charge(lua, 1);
        lua_geti(lua, list, i);
        put_varint(packed, static_cast<std::uint64_t>(luaL_checkinteger(lua, -1)));
        lua_pop(lua, 1);
    }
    return packed;
}

/// The value at the top of the stack.
void encode_field(lua_State* lua, const MessageField& field, std::string& out) {
    const int value = lua_gettop(lua);
    put_varint(out, field.number << 3U | wire_type(field.kind));
    switch (field.kind) {
        case FieldKind::kInt:
            put_varint(out, static_cast<std::uint64_t>(luaL_checkinteger(lua, value)));
            return;
        case FieldKind::kSint:
            put_varint(out, to_zigzag(luaL_checkinteger(lua, value)));
            return;
        case FieldKind::kBool:
            put_varint(out, lua_toboolean(lua, value) != 0 ? 1 : 0);
            return;
        case FieldKind::kFloat:
            put_little_endian(
                out,
                std::bit_cast<std::uint32_t>(static_cast<float>(luaL_checknumber(lua, value))));
            return;
        case FieldKind::kDouble:
            put_little_endian(out, std::bit_cast<std::uint64_t>(luaL_checknumber(lua, value)));
            return;
        case FieldKind::kBytes: {
            const std::string_view text = text_argument(lua, value, "bytes", kMaxTextBytes);
            put_varint(out, text.size());
            out.append(text);
            return;
        }
        case FieldKind::kInts: {
            const std::string packed = packed_ints(lua, value);
            put_varint(out, packed.size());
            out.append(packed);
            return;
        }
    }
}

/// encode(fields, schema): the bytes. Fields that are nil are left out.
int encode(lua_State* lua) {
    luaL_argcheck(
        lua, lua_istable(lua, 1) || lua_isuserdata(lua, 1), 1, "fields: a table is wanted");
    const MessageSchema schema = schema_argument(lua, 2);
    std::string out;
    for (std::size_t i = 0; i < schema.count && out.size() <= kMaxTextBytes; ++i) {
        push_text(lua, schema.fields[i].name);
        if (lua_gettable(lua, 1) != LUA_TNIL) {
            encode_field(lua, schema.fields[i], out);
        }
        lua_pop(lua, 1);
    }
    Interpreter::charge(lua, out.size() / kMessageBytesPerUnit);
    push_text(lua, out);
    return 1;
}

}  // namespace

void open_messages(lua_State* lua) {
    constexpr luaL_Reg kFunctions[] = {{"encode", encode}, {"decode", decode}, {nullptr, nullptr}};
    luaL_setfuncs(lua, kFunctions, 0);
}

}  // namespace zoned::scripting

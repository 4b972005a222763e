#include "server/recording/frequent_records.h"

#include <array>
#include <bit>
#include <cstdint>
#include <span>

namespace zoned::recording {

namespace {

/// Numbers of proto::RecordedInputs and proto::RecordedItem.
constexpr unsigned kItems = 1;
constexpr unsigned kInput = 3;
constexpr unsigned kAcks = 4;
constexpr unsigned kSessionProgress = 116;
constexpr unsigned kInputCommands = 2;

constexpr unsigned kVarint = 0;
constexpr unsigned kLength = 2;
constexpr unsigned kFixed32 = 5;

/// A number; left out where it is zero.
struct WireField {
    unsigned number = 0;
    std::uint64_t value = 0;
    unsigned type = kVarint;
};

std::size_t varint_bytes(std::uint64_t value) {
    return static_cast<std::size_t>(std::bit_width(value | 1U) + 6) / 7;
}

std::size_t tag_bytes(unsigned number) {
    return varint_bytes(std::uint64_t{number} << 3U);
}

std::size_t bytes_of(std::span<const WireField> fields) {
    std::size_t bytes = 0;
    for (const WireField& field : fields) {
        if (field.value != 0) {
            bytes +=
                tag_bytes(field.number) + (field.type == kFixed32 ? 4 : varint_bytes(field.value));
        }
    }
    return bytes;
}

/// A message within another: its tag, its length, and itself.
std::size_t nested_bytes(unsigned number, std::size_t body) {
    return tag_bytes(number) + varint_bytes(body) + body;
}

char* put_varint(char* at, std::uint64_t value) {
    for (; value >= 0x80U; value >>= 7U) {
        *at++ = static_cast<char>(value | 0x80U);
    }
    *at++ = static_cast<char>(value);
    return at;
}

char* put_tag(char* at, unsigned number, unsigned type) {
    return put_varint(at, std::uint64_t{number} << 3U | type);
}

char* put_nested(char* at, unsigned number, std::size_t body) {
    return put_varint(put_tag(at, number, kLength), body);
}

char* put(char* at, std::span<const WireField> fields) {
    for (const WireField& field : fields) {
        if (field.value == 0) {
            continue;
        }
        at = put_tag(at, field.number, field.type);
        if (field.type == kVarint) {
            at = put_varint(at, field.value);
            continue;
        }
        for (unsigned shift = 0; shift < 32; shift += 8) {
            *at++ = static_cast<char>(field.value >> shift);
        }
    }
    return at;
}

/// Room for an entry of `items` whose message of that number has `body` bytes; where they begin.
char* begin_item(std::string& out, unsigned number, std::size_t body) {
    const std::size_t item = nested_bytes(number, body);
    const std::size_t begin = out.size();
    out.resize(begin + nested_bytes(kItems, item));
    return put_nested(put_nested(out.data() + begin, kItems, item), number, body);
}

void append_message(std::string& out, unsigned number, std::span<const WireField> fields) {
    put(begin_item(out, number, bytes_of(fields)), fields);
}

/// Small numbers of either sign as small ones without.
std::uint64_t zigzag(std::int32_t value) {
    return static_cast<std::uint32_t>(value) << 1U ^ static_cast<std::uint32_t>(value >> 31);
}

std::array<WireField, 6> fields_of(const motion::InputCommand& command) {
    return {{{1, static_cast<std::uint64_t>(command.tick)},
             {2, zigzag(command.move_x)},
             {3, zigzag(command.move_z)},
             {4, command.yaw},
             {5, zigzag(command.pitch)},
             {6, command.buttons}}};
}

void append_input(const mailbox::Input& input, std::string& out) {
    const std::array<WireField, 1> head{{{1, input.client.value}}};
    std::size_t body = bytes_of(head);
    for (const motion::InputCommand& command : input.commands) {
        body += nested_bytes(kInputCommands, bytes_of(fields_of(command)));
    }
    char* at = put(begin_item(out, kInput, body), head);
    for (const motion::InputCommand& command : input.commands) {
        const auto fields = fields_of(command);
        at = put(put_nested(at, kInputCommands, bytes_of(fields)), fields);
    }
}

}  // namespace

bool append_frequent_record(const mailbox::InboxItem& item, std::string& out) {
    if (const auto* input = std::get_if<mailbox::Input>(&item)) {
        append_input(*input, out);
        return true;
    }
    if (const auto* acks = std::get_if<mailbox::Acks>(&item)) {
        const std::array<WireField, 6> fields{{{1, acks->client.value},
                                               {2, acks->newest},
                                               {3, acks->bits, kFixed32},
                                               {4, acks->rtt_us},
                                               {5, acks->rate_bytes_per_s},
                                               {6, acks->rtt_variation_us}}};
        append_message(out, kAcks, fields);
        return true;
    }
    if (const auto* progress = std::get_if<mailbox::SessionProgress>(&item)) {
        const std::array<WireField, 3> fields{
            {{1, progress->client.value}, {2, progress->commands}, {3, progress->events}}};
        append_message(out, kSessionProgress, fields);
        return true;
    }
    return false;
}

}  // namespace zoned::recording

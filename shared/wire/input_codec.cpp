#include "shared/wire/bit_stream.h"
#include "shared/wire/packet.h"

namespace zoned::wire {
namespace {

using motion::InputCommand;

constexpr int kAngleDeltaBits = 9;  // Turning by up to 1.4 degrees a tick.
constexpr int kFewButtonsBits = 4;
constexpr int kPitchLimit = 16384;
constexpr int kMoveLimit = 127;

bool in_range(const InputCommand& c) {
    return c.move_x >= -kMoveLimit && c.move_z >= -kMoveLimit && c.pitch >= -kPitchLimit &&
           c.pitch <= kPitchLimit;
}

/// A bit says whether an 8-bit field changed; if so the new value follows.
void write_byte(BitWriter& writer, std::int8_t value, std::int8_t before) {
    writer.write(value != before ? 1 : 0, 1);
    if (value != before) {
        writer.write(static_cast<std::uint8_t>(value), 8);
    }
}

/// Change bit, then a bit for "small" and either a difference of 9 bits or the new 16 bits.
/// Differences wrap.
void write_angle(BitWriter& writer, std::uint16_t value, std::uint16_t before) {
    writer.write(value != before ? 1 : 0, 1);
    if (value == before) {
        return;
    }
    const auto difference = static_cast<std::int16_t>(value - before);
    const bool small = difference == sign_extend(static_cast<std::uint32_t>(difference) &
                                                     low_mask(kAngleDeltaBits),
                                                 kAngleDeltaBits);
    writer.write(small ? 1 : 0, 1);
    writer.write(small ? static_cast<std::uint32_t>(difference) : value,
                 small ? kAngleDeltaBits : 16);
}

/// Change bit, then a bit for "few" (only the lowest four are pressed) and the new value.
void write_buttons(BitWriter& writer, std::uint16_t value, std::uint16_t before) {
    writer.write(value != before ? 1 : 0, 1);
    if (value == before) {
        return;
    }
    const bool few = value <= low_mask(kFewButtonsBits);
    writer.write(few ? 1 : 0, 1);
    writer.write(value, few ? kFewButtonsBits : 16);
}

void write_command(BitWriter& writer, const InputCommand& c, const InputCommand& before) {
    InputCommand same = before;
    same.tick = c.tick;
    writer.write(c == same ? 0 : 1, 1);
    if (c == same) {
        return;
    }
    write_byte(writer, c.move_x, before.move_x);
    write_byte(writer, c.move_z, before.move_z);
    write_angle(writer, c.yaw, before.yaw);
    write_angle(
        writer, static_cast<std::uint16_t>(c.pitch), static_cast<std::uint16_t>(before.pitch));
    write_buttons(writer, c.buttons, before.buttons);
}

/// Reads commands and notes in `canonical` whether each was written as shortly as it could be.
struct CommandReader {
    BitReader& bits;
    bool canonical = true;

    std::int8_t read_byte(std::int8_t before) {
        if (bits.read(1) == 0) {
            return before;
        }
        const auto value = static_cast<std::int8_t>(bits.read(8));
        canonical = canonical && value != before;
        return value;
    }

    std::uint16_t read_angle(std::uint16_t before) {
        if (bits.read(1) == 0) {
            return before;
        }
        const bool small = bits.read(1) != 0;
        const std::uint32_t raw = bits.read(small ? kAngleDeltaBits : 16);
        const auto value = static_cast<std::uint16_t>(
            small ? before + static_cast<std::uint32_t>(sign_extend(raw, kAngleDeltaBits)) : raw);
        const auto difference = static_cast<std::int16_t>(value - before);
        constexpr int kSmall = 1 << (kAngleDeltaBits - 1);
        const bool fits = difference >= -kSmall && difference < kSmall;
        canonical = canonical && difference != 0 && fits == small;
        return value;
    }

    std::uint16_t read_buttons(std::uint16_t before) {
        if (bits.read(1) == 0) {
            return before;
        }
        const bool few = bits.read(1) != 0;
        const auto value = static_cast<std::uint16_t>(bits.read(few ? kFewButtonsBits : 16));
        canonical = canonical && value != before && few == (value <= low_mask(kFewButtonsBits));
        return value;
    }

    InputCommand read(const InputCommand& before) {
        InputCommand c = before;
        if (bits.read(1) == 0) {
            return c;
        }
        c.move_x = read_byte(before.move_x);
        c.move_z = read_byte(before.move_z);
        c.yaw = read_angle(before.yaw);
        c.pitch = static_cast<std::int16_t>(read_angle(static_cast<std::uint16_t>(before.pitch)));
        c.buttons = read_buttons(before.buttons);
        canonical = canonical && in_range(c) && c != before;
        return c;
    }
};

}  // namespace

void write_commands(std::span<const InputCommand> commands, std::vector<std::uint8_t>& out) {
    if (commands.empty()) {
        return;
    }
    ZONED_ASSERT(commands.size() <= kMaxCommandsPerPacket, "too many commands for a packet");
    BitWriter writer;
    writer.write(static_cast<std::uint32_t>(commands.size() - 1), 3);
    writer.write(static_cast<std::uint32_t>(commands.front().tick), 32);
    InputCommand before;
    for (std::size_t i = 0; i < commands.size(); ++i) {
        ZONED_ASSERT(commands[i].tick == commands.front().tick + static_cast<Tick>(i),
                     "commands of a packet must be consecutive");
        ZONED_ASSERT(in_range(commands[i]), "a command outside its ranges");
        write_command(writer, commands[i], before);
        before = commands[i];
    }
    writer.finish(out);
}

core::Result<std::size_t> read_commands(std::span<const std::uint8_t> body,
                                        std::vector<InputCommand>& commands) {
    using Count = core::Result<std::size_t>;
    commands.clear();
    if (body.empty()) {
        return std::size_t{0};
    }
    BitReader bits(body);
    const std::size_t count = bits.read(3) + 1;
    const Tick first = bits.read(32);
    CommandReader reader{bits};
    InputCommand command;
    for (std::size_t i = 0; i < count; ++i) {
        command = reader.read(command);
        commands.push_back(command);
        commands.back().tick = first + static_cast<Tick>(i);
    }
    bits.align();
    if (bits.failed() || !bits.at_end() || !reader.canonical) {
        commands.clear();
        return Count::failure("malformed commands");
    }
    return count;
}

}  // namespace zoned::wire

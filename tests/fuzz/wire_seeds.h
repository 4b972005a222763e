// Wire seeds: valid inputs of all kinds for the fuzzer of the wire format.
#pragma once

#include "tests/fuzz/wire_input.h"

namespace zoned::wire::fuzz {

/// A valid input of the fuzzer, of any of its kinds.
inline Bytes valid_input(core::Rng& rng) {
    Bytes out{static_cast<std::uint8_t>(rng.below(32))};
    if (out[0] % 4 == 0) {
        const auto choice = static_cast<std::uint8_t>(out[0] / 4);
        const Quantization q = quantization_for(choice);
        const FieldSchema& fields = fields_for(choice);
        std::vector<std::uint32_t> words(fields.initial().begin(), fields.initial().end());
        for (std::uint32_t n = 1 + rng.below(5); n > 0; --n) {
            const bool upright = rng.below(2) != 0;
            RecordHead head;
            head.entity = EntityId(1 + rng.below(10'000));
            head.type = static_cast<TypeIndex>(rng.below(20));
            head.lod = static_cast<std::uint8_t>(rng.below(2));
            const Quantization level = at_lod(q, head.lod);
            const auto state = testing::random_quantized(rng, upright, level);
            const std::uint32_t kind = rng.below(5);
            const DeclaredField& changed =
                fields.fields()[rng.below(static_cast<std::uint32_t>(fields.fields().size()))];
            testing::change_field(rng, changed, words);
            DeclaredPart part;
            if (rng.below(2) != 0) {
                part = {&fields, words, changed_from_initial(fields, words)};
            }
            if (kind == 0) {
                encode_remove(head.entity, out);
            } else if (kind < 3) {
                encode_absolute(head, state, upright, q, out, part);
            } else {
                encode_delta(head, state, keyframe_for(upright, level), upright, q, out, part);
            }
        }
    } else if (out[0] % 4 == 1) {
        std::vector<motion::InputCommand> commands(1 + rng.below(8));
        for (std::size_t i = 0; i < commands.size(); ++i) {
            commands[i].tick = 1'000 + static_cast<Tick>(i);
            commands[i].move_x = static_cast<std::int8_t>(rng.below(2) * 100);
            commands[i].yaw = static_cast<std::uint16_t>(rng.below(300));
            commands[i].buttons = static_cast<std::uint16_t>(rng.below(40));
        }
        write_commands(commands, out);
    } else if (out[0] % 4 == 2) {
        DownHead head;
        head.tick = rng.next();
        head.zone = ZoneId(static_cast<std::uint16_t>(rng.below(300)));
        head.has_own = rng.below(2) != 0;
        head.own.avatar = EntityId(1 + rng.below(1'000));
        head.own.input_tick = std::max<Tick>(0, head.tick - rng.below(3));
        head.own.state.position = testing::random_vector(rng, 100.0F);
        write_down_head(head, out);
    } else {
        out.resize(30);
    }
    return out;
}

}  // namespace zoned::wire::fuzz

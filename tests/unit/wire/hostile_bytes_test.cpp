// The entry of the fuzzer is compiled into this test, so that it runs on every build.
#include "tests/fuzz/wire_fuzz.cpp"
#include "tests/unit/wire/wire_samples.h"

#include <gtest/gtest.h>

#include <memory>

namespace zoned::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Runs the fuzzer's entry on an exact copy of the bytes on the heap, so that the address sanitizer
/// sees the first byte beyond.
std::size_t feed(const Bytes& bytes) {
    const auto exact = std::make_unique<std::uint8_t[]>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), exact.get());
    return fuzz::try_wire({exact.get(), bytes.size()});
}

/// A valid input of the fuzzer, of any of its kinds.
Bytes valid_input(core::Rng& rng) {
    Bytes out{static_cast<std::uint8_t>(rng.below(16))};
    if (out[0] % 4 == 0) {
        const Quantization q = fuzz::quantization_for(static_cast<std::uint8_t>(out[0] / 4));
        for (std::uint32_t n = 1 + rng.below(5); n > 0; --n) {
            const bool upright = rng.below(2) != 0;
            RecordHead head;
            head.entity = EntityId(1 + rng.below(10'000));
            head.type = static_cast<TypeIndex>(rng.below(20));
            const auto state = testing::random_quantized(rng, upright, q);
            const std::uint32_t kind = rng.below(5);
            if (kind == 0) {
                encode_remove(head.entity, out);
            } else if (kind < 3) {
                encode_absolute(head, state, upright, q, out);
            } else {
                encode_delta(head, state, fuzz::keyframe_for(upright, q), upright, q, out);
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

void mutate(core::Rng& rng, Bytes& bytes) {
    for (std::uint32_t n = 1 + rng.below(3); n > 0; --n) {
        const std::size_t at = rng.below(static_cast<std::uint32_t>(bytes.size()));
        switch (rng.below(5)) {
            case 0:
                bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1u << rng.below(8)));
                break;
            case 1:
                bytes[at] = static_cast<std::uint8_t>(rng.below(256));
                break;
            case 2:
                bytes.resize(at + 1);
                break;
            case 3:
                bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                             static_cast<std::uint8_t>(rng.below(256)));
                break;
            default:
                bytes[at] = rng.below(2) != 0 ? 0xFF : 0x00;
                break;
        }
    }
}

TEST(HostileBytes, AreRefusedOrEncodeToThemselvesWhenTheyAreRandom) {
    core::Rng rng(1);
    std::size_t accepted = 0;
    Bytes bytes;
    for (int i = 0; i < 1'000'000; ++i) {
        bytes.resize(rng.below(48));
        for (std::uint8_t& b : bytes) {
            b = static_cast<std::uint8_t>(rng.next() >> 24);
        }
        accepted += feed(bytes);
    }
    EXPECT_GT(accepted, 0u) << "nothing got past the first checks: the test shows little";
}

TEST(HostileBytes, AreRefusedOrEncodeToThemselvesWhenTheyAreDamagedRecords) {
    core::Rng rng(2);
    std::size_t intact = 0;
    std::size_t damaged = 0;
    for (int i = 0; i < 40'000; ++i) {
        const Bytes valid = valid_input(rng);
        const std::size_t accepted = feed(valid);
        // Choice bit 3 skips deltas, so nothing may be counted then.
        ASSERT_TRUE(accepted > 0 || (valid[0] & 8) != 0);
        intact += accepted;
        for (int m = 0; m < 8; ++m) {
            Bytes bad = valid;
            mutate(rng, bad);
            damaged += feed(bad);
        }
    }
    EXPECT_GT(intact, 40'000u);
    EXPECT_GT(damaged, 40'000u) << "some damage must pass as other values";
}

}  // namespace
}  // namespace zoned::wire

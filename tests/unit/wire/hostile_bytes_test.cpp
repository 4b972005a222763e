// The entry of the fuzzer is compiled into this test, so that it runs on every build.
#include "tests/fuzz/wire_fuzz.cpp"
#include "tests/fuzz/wire_seeds.h"

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
        const Bytes valid = fuzz::valid_input(rng);
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

// Snapshots: positions and orientations of a fixed list of bodies at one moment, as integers.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::wire::snapshot {

/// One body, in steps of the format.
struct BodySample {
    std::array<std::int32_t, 3> position{};
    std::array<std::int16_t, 3> orientation{};  ///< smallest three, 0..2^orientation_bits - 1
    std::uint8_t left_out = 0;  ///< component of the quaternion not sent, 0..3: w, x, y, z
    std::uint8_t mark = 0;      ///< 0 or 1: a bit for the application

    /// Most bodies are compared and found the same: five words, no branches.
    friend bool operator==(const BodySample& a, const BodySample& b) {
        using Words = std::array<std::uint32_t, 5>;
        const auto x = std::bit_cast<Words>(a);
        const auto y = std::bit_cast<Words>(b);
        return ((x[0] ^ y[0]) | (x[1] ^ y[1]) | (x[2] ^ y[2]) | (x[3] ^ y[3]) | (x[4] ^ y[4])) == 0;
    }
};

/// Bodies by index.
using Snapshot = std::vector<BodySample>;

/// Constants of all snapshots, known to both sides.
struct SnapshotFormat {
    std::uint32_t bodies = 0;               ///< of every snapshot
    int orientation_bits = 9;               ///< of a smallest-three component, 2..15
    std::array<std::int32_t, 3> minimum{};  ///< of positions
    std::array<std::int32_t, 3> maximum{};  ///< minimum..maximum within -2^22..2^22
};

}  // namespace zoned::wire::snapshot

// Widening: the order and factors by which a client's bounds widen when its network path or budget
// is too narrow.
#pragma once

#include <cstddef>
#include <cstdint>

namespace zoned::wire {

/// Steps: 0 is the promise itself; each step doubles the bound of one more level of detail, the
/// farthest first; when all are doubled, the farthest is the first again.
inline constexpr std::uint8_t kMostWidening = 40;
/// No bound at all: some entity is predicted from an update that is too old for any bound.
inline constexpr std::uint8_t kNoBound = 63;

/// Factor on the bounds of `lod` (0: nearest) of `lods` (1..4) at `step` (0..kMostWidening).
constexpr double widening(std::uint8_t step, std::size_t lod, std::size_t lods) {
    const std::size_t rounds = step / lods;
    const std::size_t doubled = step % lods;  // that many of the farthest are a round ahead
    const std::size_t exponent = rounds + (lod + doubled >= lods ? 1 : 0);
    return static_cast<double>(std::uint64_t{1} << exponent);
}

/// The least step at which the bound of `lod` is at least `factor` times as wide; kNoBound where
/// none is.
constexpr std::uint8_t widening_for(double factor, std::size_t lod, std::size_t lods) {
    for (std::uint8_t step = 0; step <= kMostWidening; ++step) {
        if (widening(step, lod, lods) >= factor) {
            return step;
        }
    }
    return kNoBound;
}

/// The bounds in force, as a packet states them.
struct Widened {
    std::uint8_t step = 0;    ///< 0..kMostWidening, or kNoBound
    bool incomplete = false;  ///< some entities that the client should know have not been sent yet

    friend bool operator==(const Widened&, const Widened&) = default;
};

}  // namespace zoned::wire

// Rng: seeded random numbers, small, fast and the same on every computer (unlike <random>'s
// distributions).
#pragma once

#include <cmath>
#include <cstdint>

namespace zoned::core {

/// SplitMix64's mixing step (Steele, Lea, Flood, "Fast splittable pseudorandom number generators",
/// OOPSLA 2014): turns a counter or a pair of ids into well spread bits.
constexpr std::uint64_t mix(std::uint64_t z) {
    z += 0x9E3779B97F4A7C15ull;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
}

/// PCG-XSH-RR 64/32 (O'Neill, "PCG: A family of simple fast space-efficient statistically good
/// algorithms for random number generation", 2014). The whole state is two words, so it can be part
/// of snapshots, handoffs and hashes.
struct Rng {
    std::uint64_t state = 0x853C49E6748FEA9Bull;
    std::uint64_t stream = 0xDA3E39CB94B95BDBull;  // always odd

    Rng() = default;

    /// A generator for (seed, sequence); different sequences never overlap.
    explicit Rng(std::uint64_t seed, std::uint64_t sequence = 0)
        : state(0),
          stream((mix(sequence) << 1) | 1u) {
        next();
        state += mix(seed);
        next();
    }

    /// 32 uniform bits.
    std::uint32_t next() {
        const std::uint64_t old = state;
        state = old * 6364136223846793005ull + stream;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        const auto rot = static_cast<std::uint32_t>(old >> 59);
        return (shifted >> rot) | (shifted << ((32u - rot) & 31u));
    }

    /// Uniform integer in [0, bound), unbiased; bound > 0.
    std::uint32_t below(std::uint32_t bound) {
        // Lemire, "Fast random integer generation in an interval", TOMACS 29 (2019), algorithm 5.
        std::uint64_t m = static_cast<std::uint64_t>(next()) * bound;
        if (static_cast<std::uint32_t>(m) < bound) {
            const std::uint32_t threshold = (0u - bound) % bound;
            while (static_cast<std::uint32_t>(m) < threshold) {
                m = static_cast<std::uint64_t>(next()) * bound;
            }
        }
        return static_cast<std::uint32_t>(m >> 32);
    }

    /// Uniform in [0, 1) with 24 bits.
    float unit() { return static_cast<float>(next() >> 8) * 0x1.0p-24f; }

    /// Uniform in [lo, hi).
    float range(float lo, float hi) { return lo + (hi - lo) * unit(); }
};

}  // namespace zoned::core

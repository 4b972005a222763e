// Scenarios with fixed inputs, whose state hashes must be the same for any number of threads, any
// compiler and any optimisation.
#pragma once

#include <string>
#include <vector>

namespace zoned::determinism {

/// One line of the program's output.
struct Line {
    std::string scenario;
    std::string moment;  ///< when in the scenario
    std::string hash;    ///< 16 hex digits, or another exact figure

    bool operator==(const Line&) const = default;
};

/// The elementary functions, which all else stands on.
std::vector<Line> elementary_lines();

/// Rigid bodies alone: piles, pyramids, columns and chains, hashed once a second.
std::vector<Line> physics_lines(unsigned threads);

/// A world of config/ with bots on a bad virtual network: each zone's hash every 60 ticks, and at
/// the end what the clients measured.
std::vector<Line> world_lines(const std::string& name, std::size_t bot_count, unsigned threads);

/// Networks that are bred and fitted: what the first rounds of each method give.
std::vector<Line> training_lines(unsigned threads);

/// 16 hex digits.
std::string hex(unsigned long long value);

}  // namespace zoned::determinism

// Cell: one combination of network faults, and a run of bots on it with its verdict.
#pragma once

#include "client-sim/link/conditioner.h"
#include "client-sim/measure/run_report.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace zoned::harness {
class VirtualServer;
}

namespace zoned::network_matrix {

/// Probabilities are per datagram in each direction; times are one direction's.
struct Cell {
    double loss = 0.0;      ///< 0..1
    double jitter_s = 0.0;  ///< the delay is this and 20 ms more, so that jitter is symmetrical
    double duplicate = 0.0;
    double reorder = 0.0;
    bool outages = false;  ///< 250 ms in every 2 s
};

/// Every combination: losses of 0, 1, 5, 10, 20 and 30 %, jitter of 0, 33 and 100 ms, and without
/// and with 5 % duplicates, 10 % reordering, outages: 144 cells.
[[nodiscard]] std::vector<Cell> all_cells();

/// Rows in which each pair of settings of any two factors stands together at least once (an
/// orthogonal array of strength two over them): 18 cells.
[[nodiscard]] std::vector<Cell> pairwise_cells();

[[nodiscard]] link::ConditionerSettings network_of(const Cell& cell, std::uint64_t seed);
[[nodiscard]] std::string name_of(const Cell& cell);

/// How long views may take to be exact once the network is good again, s.
inline constexpr double kHealS = 1.0;

struct CellSettings {
    std::string config;  ///< file
    std::vector<std::string> sets;
    std::size_t bots = 6;
    double seconds = 6.0;
    std::uint64_t seed = 1;
    double heal_s = kHealS;                                  ///< that views have to be exact again
    unsigned threads = 1;                                    ///< of the server
    std::function<void(harness::VirtualServer&)> each_step;  ///< looks on; empty: nobody does
};

struct CellResult {
    measure::RunReport report;
    double healed_s = 0.0;  ///< from the end of all trouble until every view equals the server's
    bool healed = false;    ///< they did within CellSettings::heal_s
};

/// Bots play on the bad network; then it becomes good and the world stands still.
[[nodiscard]] CellResult run_cell(const Cell& cell, const CellSettings& settings);

}  // namespace zoned::network_matrix

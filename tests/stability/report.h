// Report: rows of the stability suite, with measured values and bounds, and how they are written.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::stability {

/// One figure against its bound: good when value <= bound (never for NaN).
struct Check {
    std::string what;  ///< with its unit, e.g. "depth_m"
    double value = 0.0;
    double bound = 0.0;

    [[nodiscard]] bool good() const { return value <= bound; }
};

/// How far a check is known to miss its bound at most.
struct KnownBound {
    std::string what;
    double bound = 0.0;
};

struct Row {
    std::string name;       ///< of the case
    std::string parameter;  ///< which of its worlds
    double max_speed_mps = 0.0;
    double energy_share = 0.0;  ///< most energy gained, as a share of the initial energy
    double depth_m = 0.0;       ///< deepest overlap; 0 where it was not looked for
    double drift_m = 0.0;       ///< farthest that a body went, where it should stay
    std::uint64_t quarantined = 0;
    std::uint64_t steps = 0;
    double ms_per_step = 0.0;
    std::vector<Check> checks;
    /// Why the engine is known to miss bounds of this row, and how far at most.
    std::string known;
    std::vector<KnownBound> known_bounds;

    [[nodiscard]] bool passed() const;

    /// A check fails that is not known to, or is worse than it is known to be. Other rows that fail
    /// are shown, and do not fail the run.
    [[nodiscard]] bool fails_run() const;

    void check(std::string what, double value, double bound);
    void know(std::string reason, std::vector<KnownBound> bounds);
};

struct Results {
    std::string machine;
    std::string commit;
    std::uint64_t seed = 0;
    bool quick = false;
    std::vector<Row> rows;
};

/// A line per row and, below a row that failed, the checks that did.
std::string to_table(const Results& results);

/// {"machine", "commit", "seed", "quick", "passed", "rows": [{..., "checks": [...]}]}.
std::string to_json(const Results& results);

}  // namespace zoned::stability

// Run: the work that the command line asks of a case, and where its rows go.
#pragma once

#include "tests/stability/report.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace zoned::stability {

/// Deliberate faults, put into the values that the checks read: each kind must make rows fail.
enum class Fault : std::uint8_t {
    kNone,
    kNan,       ///< a coordinate is not a number
    kEnergy,    ///< a body is ten times as fast and 1000 m/s faster
    kFloor,     ///< a body stands a metre lower
    kEscape,    ///< a body is far away
    kDrift,     ///< a body stands aside
    kMomentum,  ///< a body is a little faster
    kJoint,     ///< a joint is ten metres or radians farther, and gone
    kTime,      ///< steps take a hundred seconds longer
    kHull,      ///< a hull does not match its points
    kAwake,     ///< bodies never sleep
};

/// Names as on the command line, in the order of the kinds.
const std::vector<std::string>& fault_names();

class Run {
  public:
    bool quick = false;  ///< small worlds, few seconds
    std::uint64_t seed = 1;
    Fault fault = Fault::kNone;
    bool talk = false;  ///< progress on standard error
    Results results;

    /// `full`, or `brief` in a quick run.
    template <class T>
    [[nodiscard]] T pick(T brief, T full) const {
        return quick ? brief : full;
    }

    void add(Row row);
    /// A line about the current work, at most about one a second on long work.
    void progress(const std::string& what) const;
};

struct Case {
    std::string name;
    std::string purpose;  ///< its subject and the source of its bounds
    std::function<void(Run&)> run;
};

/// Each file of cases has one such function; all_cases() joins them.
std::vector<Case> stack_cases();
std::vector<Case> mass_cases();
std::vector<Case> speed_cases();
std::vector<Case> press_cases();
std::vector<Case> world_cases();
std::vector<Case> input_cases();
std::vector<Case> filter_cases();
std::vector<Case> motor_cases();
std::vector<Case> anchor_cases();
std::vector<Case> hull_cases();
std::vector<Case> crowd_cases();

std::vector<Case> all_cases();

}  // namespace zoned::stability

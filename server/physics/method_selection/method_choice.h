// MethodChoice: the cheapest of several methods that keeps an error budget, and the reasons against
// the others.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace zoned::physics::method_selection {

/// The outcome of trying a method.
struct MethodTrial {
    double error = 0.0;     ///< in the budget's unit; infinity where it exploded
    double cost_ns = 0.0;   ///< of a tick, by the table (cost_table.h)
    double spent_ns = 0.0;  ///< the cost of the trial itself by the table
};

/// A method with a number of pieces that a tick is cut into.
struct MethodOption {
    int code = 0;  ///< the caller's: an enumerator
    std::string method;
    int pieces = 1;
    double least_cost_ns = 0.0;  ///< of a tick, known before it is tried
    std::string refused;         ///< not empty: why it must not be tried
    std::function<MethodTrial()> attempt;
};

struct MethodCandidate {
    int code = 0;
    std::string method;
    int pieces = 1;
    double cost_ns = 0.0;  ///< of a tick; where it was not tried, at least
    double error = std::numeric_limits<double>::quiet_NaN();  ///< NaN: not tried
    std::string refused;                                      ///< empty: this one is chosen
    bool keeps = false;                                       ///< tried, and within the budget
};

struct MethodChoice {
    std::string subject;  ///< "bodies", "soft type curtain"
    std::string unit;     ///< "m", "of its size"
    double budget = 0.0;
    std::string basis;                        ///< how errors were found, a sentence
    std::vector<MethodCandidate> candidates;  ///< in the order in which they were tried
    std::optional<std::size_t> chosen;

    /// The candidate that comes nearest to keeping the budget; null where none was tried.
    [[nodiscard]] const MethodCandidate* best() const;
};

/// "rk4 x 2": the method and its pieces a tick; the method alone where pieces are 0.
std::string name_of(const MethodCandidate& candidate);

/// "1.2 us", "340 ns".
std::string time_text(double ns);

/// So much may all trials of a choice cost by the table, ns: start-up waits for them.
inline constexpr double kMostSpent = 5.0e8;

/// Tries options in the order of their least possible cost, and in the given order where costs are
/// equal. Stops when no other can be cheaper than the cheapest that keeps `choice.budget`. Fills
/// `candidates` and `chosen`. Depends on its arguments alone: no clock.
void choose(MethodChoice& choice, const std::vector<MethodOption>& options);

}  // namespace zoned::physics::method_selection

#include "server/physics/method_selection/method_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace zoned::physics::method_selection {

namespace {

std::string print(const char* format, double a, double b = 0.0) {
    std::array<char, 120> text{};
    std::snprintf(text.data(), text.size(), format, a, b);
    return text.data();
}

/// Tries one option and puts the result into the candidate.
void attempt(const MethodOption& option, double budget, MethodCandidate& candidate, double& spent) {
    const MethodTrial trial = option.attempt();
    spent += trial.spent_ns;
    candidate.cost_ns = trial.cost_ns;
    candidate.error = trial.error;
    candidate.keeps = trial.error <= budget;  // false for NaN
    if (!std::isfinite(trial.error)) {
        candidate.refused = "does not stay finite";
    } else if (!candidate.keeps) {
        candidate.refused = print("off by %.3g: more than %.3g", trial.error, budget);
    }
}

}  // namespace

const MethodCandidate* MethodChoice::best() const {
    const MethodCandidate* least = nullptr;
    for (const MethodCandidate& c : candidates) {
        if (std::isfinite(c.error) && (least == nullptr || c.error < least->error)) {
            least = &c;
        }
    }
    return least;
}

std::string name_of(const MethodCandidate& candidate) {
    return candidate.pieces > 0 ? candidate.method + " x " + std::to_string(candidate.pieces)
                                : candidate.method;
}

std::string time_text(double ns) {
    if (ns < 1.0e3) {
        return print("%.3g ns", ns);
    }
    return ns < 1.0e6 ? print("%.3g us", 1.0e-3 * ns) : print("%.3g ms", 1.0e-6 * ns);
}

void choose(MethodChoice& choice, const std::vector<MethodOption>& options) {
    std::vector<std::size_t> order(options.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        const double one = options[a].least_cost_ns;
        const double other = options[b].least_cost_ns;
        return one != other ? one < other : a < b;
    });
    double spent = 0.0;
    const auto dearer = [](double than) {
        return "dearer than " + time_text(than);
    };
    for (const std::size_t next : order) {
        const MethodOption& option = options[next];
        MethodCandidate candidate;
        candidate.code = option.code;
        candidate.method = option.method;
        candidate.pieces = option.pieces;
        candidate.cost_ns = option.least_cost_ns;
        MethodCandidate* winner = choice.chosen ? &choice.candidates[*choice.chosen] : nullptr;
        if (!option.refused.empty()) {
            candidate.refused = option.refused;
        } else if (winner != nullptr && option.least_cost_ns >= winner->cost_ns) {
            candidate.refused = dearer(winner->cost_ns);
        } else if (spent >= kMostSpent) {
            candidate.refused = "not tried: start-up would wait too long for it";
        } else {
            attempt(option, choice.budget, candidate, spent);
            if (candidate.keeps && winner != nullptr && candidate.cost_ns >= winner->cost_ns) {
                candidate.refused = dearer(winner->cost_ns);
            } else if (candidate.keeps) {
                if (winner != nullptr) {
                    winner->refused = dearer(candidate.cost_ns);
                }
                choice.chosen = choice.candidates.size();
            }
        }
        choice.candidates.push_back(std::move(candidate));
    }
}

}  // namespace zoned::physics::method_selection

#include "server/ai/decision/state_machine/state_flapping.h"

#include <algorithm>
#include <utility>

namespace zoned::ai::state_machine {

namespace {

constexpr std::size_t kPairs = 64;

}  // namespace

void FlappingDetector::watch(Trace& last, const StateChange& change, Tick now) {
    const bool back = change.from != change.to && last.from == change.to &&
                      last.to == change.from && now - last.at <= settings_.window;
    const auto streak = static_cast<std::uint16_t>(back ? last.streak + 1 : 1);
    if (streak >= settings_.changes) {
        report(last, change, now);
    }
    // A report closes the streak, but the next change back begins a new one.
    last = {change.from,
            change.to,
            change.transition,
            streak >= settings_.changes ? std::uint16_t{0} : streak,
            now};
}

void FlappingDetector::report(const Trace& last, const StateChange& change, Tick now) {
    const auto pair = std::minmax(change.from, change.to);
    auto at = std::lower_bound(
        found_.begin(), found_.end(), pair, [](const FlappingPair& known, const auto& wanted) {
            return std::pair(known.a, known.b) < std::pair(wanted.first, wanted.second);
        });
    if (at == found_.end() || at->a != pair.first || at->b != pair.second) {
        if (found_.size() == kPairs) {
            ++lost_;
            return;
        }
        at = found_.insert(at, {pair.first, pair.second});
    }
    const bool forth = change.from == pair.first;
    at->a_to_b = forth ? change.transition : last.transition;
    at->b_to_a = forth ? last.transition : change.transition;
    ++at->count;
    at->agent = change.agent;
    at->at = now;
}

}  // namespace zoned::ai::state_machine

// build: hot loops
#include "server/ai/decision/state_machine/coded_state_machine.h"
#include "server/ai/decision/state_machine/flat_state_machine.h"

#include <algorithm>
#include <array>

namespace zoned::ai::state_machine {

namespace {

constexpr std::size_t kNotNamed = ~std::size_t{0};

std::size_t index_of(std::span<const std::string> names, const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? kNotNamed : static_cast<std::size_t>(at - names.begin());
}

/// Empty: the machine has all its parts.
std::string why_incomplete(const CodedMachine& machine) {
    const bool by_objects = !machine.objects.empty();
    if (by_objects == (machine.decision != nullptr)) {
        return "needs either a function or objects";
    }
    if (by_objects && machine.objects.size() != machine.states.size()) {
        return "needs an object for each of its states";
    }
    if (std::find(machine.objects.begin(), machine.objects.end(), nullptr) !=
        machine.objects.end()) {
        return "has a state without an object";
    }
    if (machine.senses.size() > kMaxSenses || machine.states.size() > kMaxLeaves ||
        machine.transitions.size() >= kNone) {
        return "has too many states, senses or transitions";
    }
    for (std::size_t s = 0; s < machine.states.size(); ++s) {
        if (index_of(machine.states, machine.states[s]) != s) {
            return "names state '" + machine.states[s] + "' twice";
        }
    }
    return {};
}

}  // namespace

core::Result<BoundMachine> BoundMachine::bind(const CodedMachine& machine,
                                              std::span<const std::string> leaves,
                                              std::span<const std::string> senses,
                                              float dt) {
    using Bound = core::Result<BoundMachine>;
    const std::string code = "code '" + machine.name + "' ";
    const std::string incomplete = why_incomplete(machine);
    if (!incomplete.empty()) {
        return Bound::failure(code + incomplete);
    }
    BoundMachine out;
    out.name_ = machine.name;
    out.decision_ = machine.decision;
    out.objects_ = machine.objects;
    out.transitions_ = machine.transitions;
    out.dt_ = dt;
    out.state_of_.assign(leaves.size(), kNone);
    for (std::size_t s = 0; s < machine.states.size(); ++s) {
        const std::size_t leaf = index_of(leaves, machine.states[s]);
        if (leaf == kNotNamed) {
            return Bound::failure("has no state named '" + machine.states[s] + "', which " + code +
                                  "uses");
        }
        out.leaf_of_.push_back(static_cast<std::uint16_t>(leaf));
        out.state_of_[leaf] = static_cast<std::uint16_t>(s);
    }
    const auto spare = std::find(out.state_of_.begin(), out.state_of_.end(), kNone);
    if (spare != out.state_of_.end()) {
        return Bound::failure("has a state named '" +
                              leaves[static_cast<std::size_t>(spare - out.state_of_.begin())] +
                              "', which " + code + "does not use");
    }
    for (const std::string& sense : machine.senses) {
        const std::size_t index = index_of(senses, sense);
        if (index == kNotNamed) {
            return Bound::failure("does not sense '" + sense + "', which " + code + "reads");
        }
        out.senses_.push_back(static_cast<SenseIndex>(index));
    }
    return out;
}

std::optional<StateChange> BoundMachine::decide(ActiveState& state,
                                                std::span<const float> values,
                                                Tick now) const {
    std::array<float, kMaxSenses> read;  // written where it is read
    for (std::size_t k = 0; k < senses_.size(); ++k) {
        read[k] = values[senses_[k]];
    }
    const std::span<const float> senses(read.data(), senses_.size());
    CodedTurn turn(state, state_of_[state.leaf], now, dt_);
    if (decision_ != nullptr) {
        decision_(turn, senses);
    } else {
        objects_[turn.state()]->decide(turn, senses);
    }
    const auto entry = turn.end();
    if (!entry) {
        ZONED_ASSERT(state.pending == kNone || state.pending < transitions_.size(),
                     "code holds a transition that it has registered");
        return std::nullopt;
    }
    ZONED_ASSERT(entry->state < leaf_of_.size() && entry->transition < transitions_.size(),
                 "code enters a state by a transition, both of which it has registered");
    const StateChange change{0, state.leaf, leaf_of_[entry->state], entry->transition};
    state.leaf = change.to;
    state.since[0] = now;
    return change;
}

}  // namespace zoned::ai::state_machine

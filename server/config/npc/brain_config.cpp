#include "server/config/npc/brain_config.h"

#include "server/config/npc/blends.h"
#include "server/config/npc/choices.h"
#include "server/config/npc/find_by_name.h"
#include "server/config/npc/fuzzy_config.h"
#include "server/config/npc/poi_config.h"
#include "server/config/text/config_numbers.h"
#include "server/config/types/perceptions.h"
#include "server/config/types/stances.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <set>

namespace zoned::config {

namespace {

using proto::config::Config;

constexpr std::uint16_t kNowhere = 0xFFFE;

struct FuzzyPlace {
    int system = -1;
    int output = -1;
};

FuzzyPlace find_sense(const Config& config, const std::string& sense) {
    // Names may have dots of their own: whatever "SYSTEM.OUTPUT" fits.
    for (int f = 0; f < config.fuzzy_size(); ++f) {
        for (int o = 0; o < config.fuzzy(f).output_size(); ++o) {
            if (config.fuzzy(f).name() + "." + config.fuzzy(f).output(o).name() == sense) {
                return {f, o};
            }
        }
    }
    return {};
}

/// Builds one brain with all that is inside it.
class BrainExpansion {
  public:
    BrainExpansion(const Config& config, int index) : config_(config), index_(index) {
        collect_systems(index);
        std::size_t next =
            ai::kOwnSenses + static_cast<std::size_t>(config.brain(index).variable_size());
        for (const int system : systems_) {
            first_.push_back(next);
            next += static_cast<std::size_t>(config.fuzzy(system).output_size());
        }
        first_place_ = next;
    }

    ai::Brain run() {
        const proto::config::Brain& brain = config_.brain(index_);
        ai::Brain out;
        out.name = brain.name();
        out.coded = brain.coded();
        out.perception_m = narrow(brain.perception_m());
        out.decide_every_s = narrow(brain.decide_every_s());
        for (const auto& variable : brain.variable()) {
            out.variables.push_back({variable.name(),
                                     narrow(variable.start()),
                                     narrow(variable.per_s()),
                                     narrow(variable.low()),
                                     narrow(variable.high())});
        }
        out.states = states(brain, 0);
        out.perception = expand_perception(config_, brain);
        for (const int system : systems_) {
            ai::FuzzySense sense;
            sense.def = expand_fuzzy(config_.fuzzy(system));
            for (const auto& input : config_.fuzzy(system).input()) {
                sense.inputs.push_back(input_sense(input));
            }
            out.fuzzy.push_back(std::move(sense));
        }
        for (const std::string& sense : place_senses_) {
            out.points_of_interest.push_back(*find_poi_sense(config_, sense));
        }
        return out;
    }

  private:
    void collect_systems(int index) {
        if (index < 0 || !seen_.insert(index).second) {
            return;
        }
        const auto use = [this](const std::string& sense) {
            const int system = find_sense(config_, sense).system;
            if (system >= 0) {
                systems_.insert(system);
            } else if (find_variable(config_.brain(index_), sense) < 0 &&
                       find_poi_sense(config_, sense)) {
                place_senses_.insert(sense);
            }
        };
        for (const std::string& sense : config_.brain(index).reads()) {
            use(sense);
        }
        for (const auto& state : config_.brain(index).state()) {
            for (const auto& transition : state.transition()) {
                use(transition.sense());
                for (const auto& condition : transition.also()) {
                    use(condition.sense());
                }
            }
            for_each_choice_condition(config_,
                                      state,
                                      [&use](const proto::config::Condition& condition,
                                             const std::string&) { use(condition.sense()); });
            const int blend = state.has_blend() ? find_blend(config_, state.blend()) : -1;
            for (int i = 0; blend >= 0 && i < config_.blend(blend).input_size(); ++i) {
                use(config_.blend(blend).input(i).sense());
            }
            if (state.has_brain()) {
                collect_systems(find_brain(config_, state.brain()));
            }
        }
    }

    [[nodiscard]] ai::SenseIndex sense(const proto::config::Condition& condition) const {
        const ai::SenseIndex named = named_sense(condition.has_sense(), condition.sense());
        return named != 0 ? named : ai::sense_of(static_cast<ai::Sensor>(condition.sensor()));
    }

    [[nodiscard]] std::uint16_t variable(const std::string& name) const {
        return static_cast<std::uint16_t>(std::max(find_variable(config_.brain(index_), name), 0));
    }

    [[nodiscard]] ai::SenseIndex input_sense(const proto::config::FuzzyInput& input) const {
        return input.has_sense() ? named_sense(true, input.sense())
                                 : ai::sense_of(static_cast<ai::Sensor>(input.sensor()));
    }

    /// 0 where the setting names none.
    [[nodiscard]] ai::SenseIndex named_sense(bool given, const std::string& sense) const {
        if (!given) {
            return 0;
        }
        const int variable = find_variable(config_.brain(index_), sense);
        if (variable >= 0) {
            return static_cast<ai::SenseIndex>(ai::kOwnSenses + variable);
        }
        const FuzzyPlace place = find_sense(config_, sense);
        std::size_t k = 0;
        for (const int system : systems_) {
            if (system == place.system) {
                return static_cast<ai::SenseIndex>(first_[k] +
                                                   static_cast<std::size_t>(place.output));
            }
            ++k;
        }
        const auto of_place = place_senses_.find(sense);
        return of_place == place_senses_.end()
                   ? kNowhere
                   : static_cast<ai::SenseIndex>(
                         first_place_ +
                         static_cast<std::size_t>(std::distance(place_senses_.begin(), of_place)));
    }

    ai::Transition transition(const proto::config::Brain& brain,
                              const proto::config::Transition& from) const {
        ai::Transition out;
        out.to = kNowhere;
        for (int s = 0; s < brain.state_size(); ++s) {
            if (brain.state(s).name() == from.to()) {
                out.to = static_cast<std::uint16_t>(s);
            }
        }
        out.sensor = static_cast<ai::Sensor>(from.sensor());
        out.compare = static_cast<ai::Compare>(from.compare());
        out.threshold = narrow(from.threshold());
        out.hold_s = narrow(from.hold_s());
        out.sense = named_sense(from.has_sense(), from.sense());
        for (const auto& also : from.also()) {
            out.also.push_back(
                {sense(also), static_cast<ai::Compare>(also.compare()), narrow(also.threshold())});
        }
        return out;
    }

    std::vector<ai::BrainState> states(const proto::config::Brain& brain, std::size_t depth) {
        std::vector<ai::BrainState> out;
        for (const auto& state : brain.state()) {
            ai::BrainState s;
            s.name = state.name();
            s.action = static_cast<ai::ActionKind>(state.action());
            s.speed_factor = narrow(state.speed_factor());
            s.sprint = state.sprint();
            s.radius_m = narrow(state.radius_m());
            s.leash_m = narrow(state.has_leash_m() ? state.leash_m() : kLeash * state.radius_m());
            s.stance = static_cast<std::uint8_t>(state.stance());
            if (state.has_named_stance()) {
                const int stance = find_stance(config_, state.named_stance());
                s.stance = static_cast<std::uint8_t>(std::max(stance, 0));
            }
            s.history = static_cast<ai::state_machine::StateHistory>(state.history());
            if (state.has_rubber_band()) {
                const proto::config::RubberBand& band = state.rubber_band();
                s.rubber_band = {narrow(band.gap_m()),
                                 narrow(band.gain()),
                                 narrow(band.least()),
                                 narrow(band.most()),
                                 narrow(band.rate_per_s()),
                                 band.rivals()};
            }
            for (const auto& change : state.change()) {
                s.changes.push_back(expand_change(
                    change, [this](const std::string& name) { return variable(name); }));
            }
            expand_action_details(
                config_, state, [this](const std::string& name) { return variable(name); }, s);
            for (const auto& t : state.transition()) {
                s.transitions.push_back(transition(brain, t));
            }
            const int inside = state.has_brain() ? find_brain(config_, state.brain()) : -1;
            ++states_;
            if (inside >= 0 && depth < ai::state_machine::kMaxLevels && states_ <= kMostStates) {
                s.inside = states(config_.brain(inside), depth + 1);
            } else if (state.has_blend() && find_blend(config_, state.blend()) >= 0) {
                expand_blend(
                    config_,
                    config_.blend(find_blend(config_, state.blend())),
                    [this](const proto::config::FuzzyInput& input) { return input_sense(input); },
                    [this](const std::string& name) { return variable(name); },
                    s);
            } else {
                expand_choice(
                    config_,
                    state,
                    [this](const proto::config::Condition& condition) { return sense(condition); },
                    [this](const std::string& name) { return variable(name); },
                    s);
            }
            out.push_back(std::move(s));
        }
        return out;
    }

    /// A brain with more than this has too many leaves or is too deep. It is refused anyway, so the
    /// rest can be left out.
    static constexpr std::size_t kMostStates =
        ai::state_machine::kMaxLevels * ai::state_machine::kMaxLeaves;

    const Config& config_;
    int index_;
    std::size_t states_ = 0;  ///< so far
    std::set<int> seen_;      ///< brains whose fuzzy systems are known
    std::set<int> systems_;
    std::vector<std::size_t> first_;  ///< sense of the first output of each
    std::set<std::string> place_senses_;
    std::size_t first_place_ = 0;
};

// The enums of the config and of agents have the same numbers, so that casts are exact.
static_assert(static_cast<int>(ai::ActionKind::kReturn) == proto::config::RETURN);
static_assert(static_cast<int>(ai::ActionKind::kFlock) == proto::config::FLOCK);
static_assert(static_cast<int>(ai::ActionKind::kGo) == proto::config::GO);
static_assert(static_cast<int>(ai::Sensor::kRandom) == proto::config::RANDOM);
static_assert(static_cast<int>(ai::Sensor::kTimeOfDay) == proto::config::TIME_OF_DAY);
static_assert(static_cast<int>(ai::ActionKind::kGuard) == proto::config::GUARD);
static_assert(static_cast<int>(ai::ActionKind::kFollowTrack) == proto::config::FOLLOW_TRACK);
static_assert(static_cast<int>(ai::ActionKind::kForage) == proto::config::FORAGE);
static_assert(static_cast<int>(ai::ActionKind::kFormUp) == proto::config::FORM_UP);
static_assert(static_cast<int>(ai::FormationShape::kRing) == proto::config::RING);
static_assert(static_cast<int>(ai::Sensor::kFoes) == proto::config::FOES);
static_assert(static_cast<int>(ai::Sensor::kLeads) == proto::config::LEADS);
static_assert(static_cast<int>(ai::Compare::kAbove) == proto::config::ABOVE);
static_assert(static_cast<int>(ai::state_machine::StateHistory::kShallow) ==
              proto::config::SHALLOW);
static_assert(static_cast<int>(ai::state_machine::StateHistory::kDeep) == proto::config::DEEP);

}  // namespace

ai::Brain expand_brain(const proto::config::Config& config, int index) {
    return BrainExpansion(config, index).run();
}

std::vector<ai::Brain> expand_brains(const proto::config::Config& config) {
    std::vector<ai::Brain> brains;
    const std::vector<int> roots = root_brains(config);
    for (int m = 0; m < config.brain_size(); ++m) {
        brains.push_back(expand_brain(config, m));
        brains.back().inner = !std::binary_search(roots.begin(), roots.end(), m);
    }
    return brains;
}

std::vector<int> root_brains(const proto::config::Config& config) {
    std::set<std::string> held;
    for (const auto& brain : config.brain()) {
        for (const auto& state : brain.state()) {
            if (state.has_brain()) {
                held.insert(state.brain());
            }
        }
    }
    for (const auto& behaviour : config.behaviour()) {
        held.insert(behaviour.brain());
    }
    std::set<std::string> worn;
    for (const auto& type : config.type()) {
        worn.insert(type.brain());
    }
    std::vector<int> roots;
    for (int m = 0; m < config.brain_size(); ++m) {
        const std::string& name = config.brain(m).name();
        if (worn.count(name) != 0 || held.count(name) == 0) {
            roots.push_back(m);
        }
    }
    return roots;
}

std::string why_not_sensed(const proto::config::Config& config,
                           int root,
                           const std::string& sense) {
    const proto::config::Brain& brain = config.brain(root);
    if (find_variable(brain, sense) >= 0) {
        return {};
    }
    const int system = find_sense(config, sense).system;
    if (system < 0 && find_poi_sense(config, sense)) {
        return {};
    }
    if (system < 0) {
        return "agents of brain '" + brain.name() + "' do not sense '" + sense +
               "': it is no variable of theirs, no \"SYSTEM.OUTPUT\" of a fuzzy system, and no "
               "\"PLACE.distance\" or \"PLACE.GOOD\"";
    }
    for (const auto& input : config.fuzzy(system).input()) {
        if (input.has_sense() && find_variable(brain, input.sense()) < 0) {
            return "agents of brain '" + brain.name() + "' do not sense '" + sense +
                   "': it depends on '" + input.sense() + "', which is no variable of theirs";
        }
    }
    return {};
}

}  // namespace zoned::config

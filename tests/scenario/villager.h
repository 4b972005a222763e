// Villager: a state machine of three levels with histories, and senses that lead through it.
#pragma once

#include "tests/scenario/sentry.h"

namespace zoned::scenario {

enum VillagerSense : ai::SenseIndex {
    kAlarm,   ///< 0 or 1
    kFoe,     ///< m
    kHunger,  ///< [0, 1]
    kLoad,    ///< [0, 1]
    kVillagerSenses,
};

/// day { labour { fetch, carry, sell }, eat, sleep }, danger { flee, fight { close_in, strike } }:
/// two transitions for each state.
inline ai::state_machine::StateMachineDef villager_def(
    ai::state_machine::StateHistory labour_history = ai::state_machine::StateHistory::kShallow,
    ai::state_machine::StateHistory day_history = ai::state_machine::StateHistory::kDeep) {
    using ai::Compare;
    using ai::state_machine::StateDef;
    using ai::state_machine::TransitionDef;
    const auto when = [](std::uint16_t to, ai::SenseIndex sense, Compare compare, float threshold) {
        return TransitionDef{to, {{sense, compare, threshold}}, 0.0F};
    };
    const auto below = Compare::kBelow;
    const auto above = Compare::kAbove;
    const StateDef fetch{
        "fetch", 0, {when(1, kLoad, above, 0.8F), when(2, ai::kStateTime, above, 60.0F)}, {}, {}};
    const StateDef carry{
        "carry", 1, {when(0, kLoad, below, 0.3F), when(2, ai::kStateTime, above, 20.0F)}, {}, {}};
    const StateDef sell{
        "sell", 2, {when(0, kLoad, below, 0.1F), when(1, ai::kStateTime, above, 30.0F)}, {}, {}};
    const StateDef labour{"labour",
                          0,
                          {when(1, kHunger, above, 0.7F), when(2, ai::kStateTime, above, 200.0F)},
                          {fetch, carry, sell},
                          labour_history};
    const StateDef eat{
        "eat", 3, {when(0, kHunger, below, 0.2F), when(2, ai::kStateTime, above, 50.0F)}, {}, {}};
    const StateDef sleep{"sleep",
                         4,
                         {when(0, ai::kStateTime, above, 40.0F), when(1, kHunger, above, 0.95F)},
                         {},
                         {}};
    const StateDef day{"day",
                       0,
                       {when(1, kAlarm, above, 0.5F), when(1, kFoe, below, 2.0F)},
                       {labour, eat, sleep},
                       day_history};
    const StateDef flee{
        "flee", 5, {when(1, kFoe, below, 5.0F), when(1, ai::kStateTime, above, 300.0F)}, {}, {}};
    const StateDef close_in{
        "close_in", 6, {when(1, kFoe, below, 2.0F), when(1, ai::kStateTime, above, 10.0F)}, {}, {}};
    const StateDef strike{
        "strike", 7, {when(0, kFoe, above, 3.0F), when(0, ai::kStateTime, above, 5.0F)}, {}, {}};
    const StateDef fight{"fight",
                         0,
                         {when(0, kFoe, above, 8.0F), when(0, kHunger, above, 0.9F)},
                         {close_in, strike},
                         {}};
    const StateDef danger{"danger",
                          0,
                          {TransitionDef{0, {{kAlarm, below, 0.5F}, {kFoe, above, 6.0F}}, 0.0F},
                           when(0, ai::kStateTime, above, 500.0F)},
                          {flee, fight},
                          {}};
    return {"villager", {day, danger}};
}

/// A walk at random. Call it once a tick.
inline void villager_walk(Sensed& sensed, std::size_t count, core::Rng& rng) {
    for (std::size_t i = 0; i < count; ++i) {
        const auto walk = [&](std::size_t sense, float step, float high) {
            float& value = sensed.at(sense, i);
            value = std::min(high, std::max(0.0F, value + rng.range(-step, step)));
        };
        if (rng.below(20) == 0) {
            sensed.at(kAlarm, i) = 1.0F - sensed.at(kAlarm, i);
        }
        walk(kFoe, 3.0F, 20.0F);
        walk(kHunger, 0.15F, 1.0F);
        walk(kLoad, 0.2F, 1.0F);
    }
}

}  // namespace zoned::scenario

// Gunman: planning domains, the well-known one of seven actions, chains, and random ones.
#pragma once

#include "server/ai/decision/goap/domain.h"
#include "shared/core/rng.h"

#include <string>

namespace zoned::scenario {

enum GunmanFact : std::uint8_t {
    kFoeVisible,
    kHasGun,
    kLoaded,
    kLinedUp,
    kFoeAlive,
    kHasBomb,
    kNear,
    kAlive,
    kGunmanFacts,
};

inline constexpr std::uint64_t fact(unsigned index) {
    return std::uint64_t{1} << index;
}

/// Seven actions: the domain on which planners of this kind are usually tried. From gunman_world()
/// the cheapest plan for the goal is scout, load, aim, shoot.
inline ai::goap::Domain gunman_domain() {
    ai::goap::Domain domain;
    domain.facts = {
        "foe_visible", "has_gun", "loaded", "lined_up", "foe_alive", "has_bomb", "near", "alive"};
    domain.actions = {
        {"scout", {fact(kHasGun), 0}, {fact(kFoeVisible), 0}, 1},
        {"approach", {fact(kFoeVisible), 0}, {fact(kNear), 0}, 1},
        {"aim", {fact(kFoeVisible) | fact(kLoaded), 0}, {fact(kLinedUp), 0}, 1},
        {"shoot", {fact(kLinedUp), 0}, {0, fact(kFoeAlive)}, 1},
        {"load", {fact(kHasGun), 0}, {fact(kLoaded), 0}, 1},
        {"detonate", {fact(kHasBomb) | fact(kNear), 0}, {0, fact(kAlive) | fact(kFoeAlive)}, 1},
        {"flee", {fact(kFoeVisible), 0}, {0, fact(kNear)}, 1},
    };
    domain.goals = {{"kill", {fact(kAlive), fact(kFoeAlive)}}};
    return domain;
}

inline constexpr ai::goap::FactSet kGunmanWorld =
    fact(kHasGun) | fact(kFoeAlive) | fact(kHasBomb) | fact(kAlive);

/// 40 actions among 32 facts. Many plans make 31 of the facts true; no action makes the last one.
/// The goal is that fact together with some of the others.
inline ai::goap::Domain unreachable_domain() {
    ai::goap::Domain domain;
    for (int f = 0; f < 32; ++f) {
        domain.facts.push_back("f" + std::to_string(f));
    }
    core::Rng rng(17);
    for (unsigned a = 0; a < 40; ++a) {
        ai::goap::Action action;
        action.name = "a" + std::to_string(a);
        const unsigned made = a % 31;
        action.makes.yes = fact(made);
        // Needs facts that earlier actions make, so that all of them can come true, one layer after
        // the other.
        for (unsigned n = 0; n < 2 && made > 0; ++n) {
            action.needs.yes |= fact(rng.below(made));
        }
        if (a >= 31) {
            action.makes.no = fact(rng.below(31)) & ~action.makes.yes & ~action.needs.yes;
        }
        action.cost = 1 + rng.below(5);
        domain.actions.push_back(std::move(action));
    }
    domain.goals = {{"never", {fact(31) | fact(30) | fact(20), 0}}};
    return domain;
}

/// `facts` facts (at most 8), actions that need and make some of them, costs from 1 to 4.
inline ai::goap::Domain random_domain(unsigned facts, unsigned actions, core::Rng& rng) {
    ai::goap::Domain domain;
    for (unsigned f = 0; f < facts; ++f) {
        domain.facts.push_back("f" + std::to_string(f));
    }
    const auto literals = [&](unsigned least, unsigned most) {
        ai::goap::Literals some;
        for (unsigned n = least + rng.below(most - least + 1); n > 0; --n) {
            const std::uint64_t bit = fact(rng.below(facts));
            if (((some.yes | some.no) & bit) == 0) {
                (rng.below(2) == 0 ? some.yes : some.no) |= bit;
            }
        }
        return some;
    };
    for (unsigned a = 0; a < actions; ++a) {
        ai::goap::Action action{
            "a" + std::to_string(a), literals(1, 3), literals(1, 2), 1 + rng.below(4)};
        domain.actions.push_back(std::move(action));
    }
    ai::goap::GoapGoal goal{"goal", literals(2, 5)};
    domain.goals.push_back(goal);
    return domain;
}

}  // namespace zoned::scenario

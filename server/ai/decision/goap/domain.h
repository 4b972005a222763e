// Domain: the facts, actions and goals of an agent's planner, and the check that finds its defects.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::ai::goap {

inline constexpr std::size_t kMaxFacts = 64;
inline constexpr std::size_t kMaxActions = 64;

/// A set of facts, a bit each.
using FactSet = std::uint64_t;

/// Facts that must be, or become, true or false; other facts do not matter.
struct Literals {
    std::uint64_t yes = 0;
    std::uint64_t no = 0;

    bool operator==(const Literals&) const = default;

    [[nodiscard]] bool hold_in(FactSet world) const {
        return (yes & ~world) == 0 && (no & world) == 0;
    }

    [[nodiscard]] bool empty() const { return (yes | no) == 0; }
};

struct Action {
    std::string name;
    Literals needs;
    Literals makes;
    std::uint32_t cost = 1;  ///< [1, 1,000,000]
};

struct GoapGoal {
    std::string name;
    Literals wants;
};

struct Domain {
    std::vector<std::string> facts;
    std::vector<Action> actions;
    std::vector<GoapGoal> goals;

    [[nodiscard]] FactSet all_facts() const {
        return facts.size() >= kMaxFacts ? ~FactSet{0} : (FactSet{1} << facts.size()) - 1;
    }
};

/// `world` after the action; the action's needs must hold.
inline FactSet after(const Action& action, FactSet world) {
    return (world | action.makes.yes) & ~action.makes.no;
}

enum class GoapDefectKind : std::uint8_t {
    kTooManyFacts,
    kTooManyActions,
    kUnknownFact,    ///< a bit beyond the facts
    kContradiction,  ///< a fact that is both true and false
    kNoEffect,       ///< an action without effect, or with only effects that it already needs
    kBadCost,
    kNeverWanted,     ///< no goal and no action needs what the action makes
    kNothingMakesIt,  ///< a goal needs a fact that no action makes
};

struct GoapDefect {
    GoapDefectKind kind = GoapDefectKind::kNoEffect;
    int action = -1;  ///< index, or -1
    int goal = -1;    ///< index, or -1
    int fact = -1;    ///< the fact in question, or -1
};

std::vector<GoapDefect> defects_of(const Domain& domain);

/// The defect as a sentence for people; names facts.
std::string text_of(const GoapDefect& defect, const Domain& domain);

}  // namespace zoned::ai::goap

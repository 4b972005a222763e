// GoapPlanner: finds the cheapest sequence of actions that makes a goal true (GOAP).
// Source: Orkin, "Three states and a plan: the AI of F.E.A.R.", Game Developers Conference 2006.
#pragma once

#include "server/ai/decision/goap/domain.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::goap {

/// The longest plan, in steps.
inline constexpr std::size_t kMaxSteps = 32;

enum class Verdict : std::uint8_t {
    kPlanned,      ///< found a plan; it has no steps where nothing is left to do
    kUnreachable,  ///< no sequence of actions, of whatever length, makes the goal true
    kCutOff,       ///< the bound on work, or kMaxSteps, was reached before an answer
};

/// Plan: a sequence of actions.
struct Plan {
    Verdict verdict = Verdict::kCutOff;
    std::uint8_t size = 0;      ///< number of steps
    std::uint32_t cost = 0;     ///< sum over the steps
    std::uint32_t created = 0;  ///< nodes that the search created: a measure of its work
    std::array<std::uint8_t, kMaxSteps> action{};
};

/// Actions: a domain compiled for planning.
class Actions {
  public:
    /// `domain` must have no kTooMany..., kUnknownFact, kContradiction and kBadCost defects.
    explicit Actions(const Domain& domain);

  private:
    friend class GoapPlanner;

    struct Flat {
        Literals needs;
        Literals makes;
        std::uint32_t cost = 1;
    };

    FactSet all_facts_ = 0;
    std::vector<Flat> actions_;
    /// By fact: the actions that make it true, and the actions that make it false, a bit each.
    std::array<std::uint64_t, kMaxFacts> makers_yes_{};
    std::array<std::uint64_t, kMaxFacts> makers_no_{};
};

/// Searches backwards from the goal by A*.
/// Once for each plan it finds the cost to reach each fact on its own. That cost starts from the
/// present world and assumes that nothing is ever undone. It shows at once that a goal is out of
/// reach. No goal costs less than the dearest of its facts. This bound guides the search and keeps
/// its plans optimal. Sources: Bonet and Geffner, "Planning as heuristic search: new results", ECP
/// 1999; for h_max, Bonet and Geffner, "Planning as heuristic search", Artificial Intelligence 129,
/// 2001, section 4.
/// The class holds working memory only: a plan depends on nothing before it, and making one
/// allocates nothing.
class GoapPlanner {
  public:
    /// `bound`: the most nodes that a search may create, [1, 65536].
    explicit GoapPlanner(std::uint32_t bound = 1024);

    [[nodiscard]] std::uint32_t bound() const { return bound_; }

    /// Finds the cheapest plan; of equally cheap ones the same each time.
    void plan(const Actions& actions, FactSet from, const Literals& goal, Plan& plan);

  private:
    struct PlanLayer {
        Literals reached;
        std::uint32_t cost = 0;
    };

    struct PlanNode {
        Literals needs;
        std::uint32_t cost = 0;   ///< cost from here to the goal
        std::uint32_t guess = 0;  ///< the least cost from the world to here
        std::uint32_t parent = 0;
        std::uint8_t action = 0;
        std::uint8_t steps = 0;
        bool closed = false;
    };

    struct PlanSlot {
        std::uint32_t search = 0;  ///< the search that filled it
        std::uint32_t node = 0;
    };

    void relax(const Actions& actions, FactSet from);
    [[nodiscard]] std::uint32_t guess(const Literals& needs) const;
    bool search(const Actions& actions, Plan& plan);
    std::uint32_t expand(const Actions& actions, std::uint32_t at);
    [[nodiscard]] std::uint64_t makers(const Actions& actions, const Literals& needs) const;
    PlanSlot& slot_of(const Literals& needs);
    void push(std::uint32_t node);
    std::uint32_t pop();
    void write(std::uint32_t node, Plan& plan) const;

    std::uint32_t bound_;
    std::uint32_t search_ = 0;
    std::array<PlanLayer, kMaxActions + 1> layers_;
    std::size_t layer_count_ = 0;
    std::uint64_t usable_ = 0;  ///< actions whose needs can be met at all, a bit each
    std::vector<PlanNode> nodes_;
    std::uint32_t node_count_ = 0;
    std::vector<PlanSlot> slots_;
    std::vector<std::uint64_t> open_;  ///< heap of guess + cost, guess, node
    bool too_long_ = false;            ///< a path of kMaxSteps steps was cut off
    bool full_ = false;                ///< the heap is full
};

}  // namespace zoned::ai::goap

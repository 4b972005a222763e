#include "server/ai/decision/goap/domain.h"

#include <bit>

namespace zoned::ai::goap {

namespace {

/// Index of the lowest fact, or -1.
int lowest(std::uint64_t facts) {
    return facts == 0 ? -1 : std::countr_zero(facts);
}

class DomainInspection {
  public:
    explicit DomainInspection(const Domain& domain) : domain_(domain) {
        for (const Action& action : domain.actions) {
            made_.yes |= action.makes.yes;
            made_.no |= action.makes.no;
            wanted_.yes |= action.needs.yes;
            wanted_.no |= action.needs.no;
        }
        for (const GoapGoal& goal : domain.goals) {
            wanted_.yes |= goal.wants.yes;
            wanted_.no |= goal.wants.no;
        }
    }

    std::vector<GoapDefect> run() {
        if (domain_.facts.size() > kMaxFacts) {
            found_.push_back({GoapDefectKind::kTooManyFacts});
        }
        if (domain_.actions.size() > kMaxActions) {
            found_.push_back({GoapDefectKind::kTooManyActions});
        }
        for (std::size_t a = 0; a < domain_.actions.size(); ++a) {
            action(static_cast<int>(a), domain_.actions[a]);
        }
        for (std::size_t g = 0; g < domain_.goals.size(); ++g) {
            goal(static_cast<int>(g), domain_.goals[g].wants);
        }
        return std::move(found_);
    }

  private:
    void literals(int action, int goal, const Literals& literals) {
        const std::uint64_t unknown = (literals.yes | literals.no) & ~domain_.all_facts();
        if (unknown != 0) {
            found_.push_back({GoapDefectKind::kUnknownFact, action, goal, lowest(unknown)});
        }
        if ((literals.yes & literals.no) != 0) {
            found_.push_back(
                {GoapDefectKind::kContradiction, action, goal, lowest(literals.yes & literals.no)});
        }
    }

    void action(int index, const Action& action) {
        literals(index, -1, action.needs);
        literals(index, -1, action.makes);
        const bool effect = (action.makes.yes & ~action.needs.yes) != 0 ||
                            (action.makes.no & ~action.needs.no) != 0;
        if (!effect) {
            found_.push_back({GoapDefectKind::kNoEffect, index});
        } else if ((action.makes.yes & wanted_.yes) == 0 && (action.makes.no & wanted_.no) == 0) {
            found_.push_back({GoapDefectKind::kNeverWanted, index});
        }
        if (action.cost < 1 || action.cost > 1000000) {
            found_.push_back({GoapDefectKind::kBadCost, index});
        }
    }

    /// A fact that is true from the start needs no action to make it. Two kinds of facts are
    /// suspicious: a fact that actions undo and none restores, and a fact that no action touches.
    void goal(int index, const Literals& wants) {
        literals(-1, index, wants);
        const std::uint64_t unmade = (wants.yes & ~made_.yes) | (wants.no & ~made_.no);
        const std::uint64_t undone = (wants.yes & made_.no) | (wants.no & made_.yes);
        // Keeping a fact is also a goal: "and stays alive". A goal of only such facts cannot be
        // reached.
        if (unmade == (wants.yes | wants.no) || wants.empty()) {
            found_.push_back({GoapDefectKind::kNothingMakesIt, -1, index, lowest(unmade)});
        } else if ((unmade & ~undone & domain_.all_facts()) != 0) {
            found_.push_back(
                {GoapDefectKind::kNothingMakesIt, -1, index, lowest(unmade & ~undone)});
        }
    }

    const Domain& domain_;
    Literals made_;
    Literals wanted_;
    std::vector<GoapDefect> found_;
};

std::string fact_name(const GoapDefect& defect, const Domain& domain) {
    const auto fact = static_cast<std::size_t>(defect.fact);
    return defect.fact >= 0 && fact < domain.facts.size() ? "'" + domain.facts[fact] + "'"
                                                          : "a fact";
}

}  // namespace

std::vector<GoapDefect> defects_of(const Domain& domain) {
    return DomainInspection(domain).run();
}

std::string text_of(const GoapDefect& defect, const Domain& domain) {
    switch (defect.kind) {
        case GoapDefectKind::kTooManyFacts:
            return "at most " + std::to_string(kMaxFacts) + " facts";
        case GoapDefectKind::kTooManyActions:
            return "at most " + std::to_string(kMaxActions) + " actions";
        case GoapDefectKind::kUnknownFact:
            return "speaks of a fact that is not listed";
        case GoapDefectKind::kContradiction:
            return fact_name(defect, domain) + " cannot be both true and false";
        case GoapDefectKind::kNoEffect:
            return "changes nothing: it makes only what it needs already";
        case GoapDefectKind::kBadCost:
            return "costs 1 to 1000000";
        case GoapDefectKind::kNeverWanted:
            return "makes nothing that a goal or another action needs";
        case GoapDefectKind::kNothingMakesIt:
            return defect.fact < 0 ? "wants nothing"
                                   : "no action makes " + fact_name(defect, domain) +
                                         " what the goal wants it to be";
    }
    return "is wrong";
}

}  // namespace zoned::ai::goap

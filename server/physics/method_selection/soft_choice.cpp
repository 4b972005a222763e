#include "server/physics/method_selection/soft_choice.h"

#include "server/physics/method_selection/cost_table.h"
#include "server/physics/method_selection/soft_probe.h"
#include "server/physics/soft/spring_limit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace zoned::physics::method_selection {

namespace {

using soft::SoftMethod;

/// The state that all trials of a choice share. The reference is made when the first of them asks.
class SoftTrials {
  public:
    SoftTrials(const SoftSubject& subject, double budget)
        : subject_(subject),
          budget_(budget),
          probe_(subject.probe, subject.gravity, subject.tick_s),
          whole_(counts_of(subject.whole)),
          tried_(counts_of(subject.probe)) {}

    [[nodiscard]] MethodOption option(SoftMethod method, int substeps) {
        MethodOption option;
        option.code = static_cast<int>(method);
        option.method = soft::name_of(method);
        option.pieces = substeps;
        soft::SoftDef def = subject_.whole;
        def.solver.method = method;
        def.solver.substeps = substeps;
        option.refused = soft::why_unstable(def, subject_.tick_s);
        option.least_cost_ns = soft_cost_ns(method, whole_, substeps, substeps, substeps);
        option.attempt = [this, method, substeps] {
            return attempt(method, substeps);
        };
        return option;
    }

    [[nodiscard]] std::string basis() const {
        if (!reference_) {
            return {};
        }
        std::array<char, 480> text{};
        std::snprintf(
            text.data(),
            text.size(),
            "mean distance of %zu nodes within 1 s %s from %s, which a halving changed by %.2g of "
            "the size (added to each error)%s",
            subject_.probe.nodes.size(),
            probe_.pinned() ? "as it is pinned, falling," : "after a stretch by a fifth is let go,",
            reference_->how.c_str(),
            reference_->change,
            subject_.coarser > 1 ? "; a coarser lattice stands for the whole one" : "");
        return text.data();
    }

  private:
    MethodTrial attempt(SoftMethod method, int substeps) {
        if (!reference_) {
            reference_ = probe_.reference(budget_);
        }
        soft::SoftSolver solver = subject_.whole.solver;
        solver.method = method;
        const bool sweeps = method == SoftMethod::kXpbd;
        solver.substeps = sweeps ? std::max(1, substeps / subject_.coarser) : substeps;
        const ProbeRun run = probe_.run(solver);
        const double passes = run.gradient_passes / probe_.ticks();
        const double newton = run.newton_steps / probe_.ticks();
        const double most = newton * solver.gradient_iterations;
        MethodTrial trial;
        trial.error = probe_.distance(run, reference_->run) + reference_->change;
        trial.cost_ns = soft_cost_ns(
            method, whole_, substeps, newton, std::min(most, passes * subject_.coarser));
        trial.spent_ns =
            probe_.ticks() * soft_cost_ns(method, tried_, solver.substeps, newton, passes);
        return trial;
    }

    const SoftSubject& subject_;
    double budget_;
    SoftProbe probe_;
    SweepCounts whole_;
    SweepCounts tried_;
    std::optional<ProbeReference> reference_;
};

/// Which substeps are tried, ascending.
std::vector<int> substeps_of(const SoftSubject& subject, SoftMethod method) {
    int least = 1;
    int most = 64;
    if (method == SoftMethod::kXpbd) {
        least = subject.coarser;
        most = soft::kMostSubsteps;
    } else if (method == SoftMethod::kSemiImplicitEuler) {
        const double longest = soft::spring_limit(subject.whole).step_s();
        const double need = std::ceil(static_cast<double>(subject.tick_s) / longest);
        least = static_cast<int>(std::clamp(need, 1.0, double{soft::kMostSubsteps}));
        most = std::min(8 * least, soft::kMostSubsteps);
    }
    std::vector<int> out;
    for (int n = least; n <= most; n *= 2) {
        out.push_back(n);
    }
    return out;
}

}  // namespace

MethodChoice choose_soft(const SoftSubject& subject,
                         double budget,
                         std::span<const SoftMethod> methods,
                         int substeps) {
    MethodChoice choice;
    choice.subject = subject.name;
    choice.unit = "of its size";
    choice.budget = budget;
    SoftTrials trials(subject, budget);
    std::vector<MethodOption> options;
    for (const SoftMethod method : methods) {
        for (const int n : substeps > 0 ? std::vector{substeps} : substeps_of(subject, method)) {
            options.push_back(trials.option(method, n));
        }
    }
    choose(choice, options);
    choice.basis = trials.basis();
    return choice;
}

}  // namespace zoned::physics::method_selection

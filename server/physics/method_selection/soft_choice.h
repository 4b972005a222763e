// Soft choice: the method and its substeps a tick that move a kind of soft body within a budget.
#pragma once

#include "server/physics/method_selection/method_choice.h"
#include "server/physics/soft/soft_def.h"

#include <array>
#include <span>
#include <string>

namespace zoned::physics::method_selection {

/// A kind of soft body, and the probe simulated in its place.
struct SoftSubject {
    std::string name;            ///< for messages
    const soft::SoftDef& whole;  ///< gives the cost, and has to be stable
    const soft::SoftDef&
        probe;  ///< the body for the trial: the whole, or a lattice coarser by `coarser`
    int coarser = 1;
    Vec3 gravity = Vec3(0.0F, -kGravity, 0.0F);  ///< m/s2
    float tick_s = 1.0F / 30.0F;
};

/// More springs are not tried one by one: start-up would take longer than a second a kind. A
/// coarser lattice stands for them.
inline constexpr std::size_t kMostProbeSprings = 3000;

inline constexpr std::array kSoftMethods{soft::SoftMethod::kXpbd,
                                         soft::SoftMethod::kSemiImplicitEuler,
                                         soft::SoftMethod::kImplicitEuler};

/// The cheapest of `methods` and substeps whose error is at most `budget`. The error is the mean
/// distance of nodes from a converged solution over the second of a SoftProbe, as a share of the
/// body's size, plus the error of that solution itself. `substeps` > 0: no others are tried. Codes
/// of candidates are SoftMethods.
///
/// A pass of XPBD hands a load on by about one node. On a lattice coarser by c, n substeps
/// therefore stand for c n on the whole one; a solve of implicit Euler there takes c times the
/// passes. Springs of semi-implicit Euler are judged by the whole body, and tried with its
/// substeps.
MethodChoice choose_soft(const SoftSubject& subject,
                         double budget,
                         std::span<const soft::SoftMethod> methods = kSoftMethods,
                         int substeps = 0);

}  // namespace zoned::physics::method_selection

#include "server/physics/scene/stability_warnings.h"

#include "server/physics/narrowphase/narrowphase.h"
#include "server/physics/shapes/compound/bounds.h"
#include "server/physics/shapes/compound/inertia.h"
#include "server/physics/solver/contact_solver.h"
#include "server/physics/solver/substep_policy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace zoned::physics {

namespace {

constexpr float kMostSubsteps = 1U << (SubstepPolicy::kLevels - 1);

template <class... Values>
std::string sentence(const char* format, Values... values) {
    char text[300];
    std::snprintf(text, sizeof(text), format, static_cast<double>(values)...);
    return text;
}

float substep_of(const PhysicsSettings& settings, float dt) {
    return dt / (settings.substeps > 0 ? static_cast<float>(settings.substeps) : kMostSubsteps);
}

}  // namespace

std::vector<std::string> stability_warnings_of(const BodyDef& def,
                                               const PhysicsSettings& settings,
                                               float dt) {
    std::vector<std::string> out;
    const float far = def.position.cwiseAbs().maxCoeff();
    if (far > farthest_for(settings.error_budget_m)) {
        out.push_back(
            sentence("lies %g m out, where floats are too coarse for error_budget_m %g: "
                     "at most %g m",
                     far,
                     settings.error_budget_m,
                     farthest_for(settings.error_budget_m)));
    }
    const float thick = inner_radius(def.shape);
    const bool full = def.kind == BodyKind::kDynamic;
    if (full && thick > 0.0F && 2.0F * thick < kContactMargin) {
        out.push_back(sentence("is %g m thick, thinner than the contact margin of %g m",
                               2.0F * thick,
                               kContactMargin));
    }
    const float radius = bounding_radius(def.shape);
    const float turn = def.angular_velocity.norm() * dt;
    if (full && def.shape.kind != ShapeKind::kSphere && turn > std::numbers::pi_v<float>) {
        out.push_back(
            sentence("turns by %g rad in a step of %g s: what its ends pass within half "
                     "a turn is not seen",
                     turn,
                     dt));
    }
    const float fall = settings.gravity.norm() * dt * dt;
    if (full && radius > 0.0F && fall > radius) {
        out.push_back(
            sentence("is %g m in radius and falls %g m farther in each step of %g s: the "
                     "step is too long for its size",
                     radius,
                     fall,
                     dt));
    }
    return out;
}

/// A spring that swings by more than half a radian within a substep keeps its frequency to worse
/// than 1 %; from 1 / (pi h) on it is no spring any more.
std::vector<std::string> stability_warnings_of(const JointDef& def,
                                               float mass_a,
                                               float mass_b,
                                               const PhysicsSettings& settings,
                                               float dt) {
    std::vector<std::string> out;
    const float h = substep_of(settings, dt);
    const float most_hz = 0.5F / (2.0F * std::numbers::pi_v<float> * h);
    if (def.kind == JointKind::kSpring && def.spring_hz > most_hz) {
        out.push_back(
            sentence("is a spring of %g Hz; steps of %g s carry %g Hz at most (and none "
                     "from %g Hz on)",
                     def.spring_hz,
                     dt,
                     most_hz,
                     1.0F / (std::numbers::pi_v<float> * h)));
    }
    if (mass_a > 0.0F && mass_b > 0.0F) {
        constexpr float kMostRatio = 1.0e5F;  // the direct joint solver works in floats
        const float ratio = std::max(mass_a, mass_b) / std::min(mass_a, mass_b);
        if (ratio > kMostRatio) {
            out.push_back(sentence("joins masses of ratio %g; at most %g", ratio, kMostRatio));
        }
    }
    return out;
}

/// See SubstepPolicy: a contact gives by F / (m w^2) with w = 2 pi kContactRateShare / h.
std::vector<std::string> stability_warnings_of_load(float light_kg,
                                                    float heavy_kg,
                                                    const PhysicsSettings& settings,
                                                    float dt) {
    const float rate =
        2.0F * std::numbers::pi_v<float> * kContactRateShare / substep_of(settings, dt);
    const float force = settings.gravity.norm() * heavy_kg;
    const float give = force * (1.0F / light_kg + 1.0F / heavy_kg) / (rate * rate);
    if (give <= settings.error_budget_m) {
        return {};
    }
    const float least_kg = heavy_kg / SubstepPolicy::kHeaviest;
    if (settings.substeps == 0 && light_kg < least_kg) {
        return {
            sentence("%g kg on %g kg is too much for steps of %g s: under it contacts may take "
                     "the lighter for %g kg",
                     heavy_kg,
                     light_kg,
                     dt,
                     least_kg)};
    }
    return {sentence("%g kg on %g kg gives way by %g m in steps of %g s; error_budget_m is %g",
                     heavy_kg,
                     light_kg,
                     give,
                     dt,
                     settings.error_budget_m)};
}

std::vector<std::string> stability_warnings_of(const PhysicsSettings& settings, float dt) {
    // A body of one kilogram on another asks for the least that a scene with contacts needs.
    std::vector<std::string> out = stability_warnings_of_load(1.0F, 1.0F, settings, dt);
    for (std::string& text : out) {
        text = "the step is too long for contacts: " + text;
    }
    return out;
}

}  // namespace zoned::physics

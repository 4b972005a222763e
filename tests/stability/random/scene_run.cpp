#include "tests/stability/random/scene_run.h"

#include "tests/bench/cpu_clock.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::stability {

namespace {

/// A fault begins after this step.
constexpr std::uint64_t kFaultAfter = 20;

void observe(const RandomScene& scene, LiveScene& live, Observation& now) {
    now.stats = live.scene.step(scene.dt);
    for (std::size_t i = 0; i < live.bodies.size(); ++i) {
        now.states[i] = live.scene.state(live.bodies[i]);
    }
    for (std::size_t i = 0; i < live.joints.size(); ++i) {
        const bool held = live.scene.contains(live.joints[i]);
        // A joint that broke in this step has no force to ask for; its last one stays.
        now.held[i] = held;
        now.forces[i] = held ? live.scene.joint_force(live.joints[i]) : 0.0F;
    }
    for (const physics::JointBreak& gone : live.scene.joint_breaks()) {
        const auto at = std::find(live.joints.begin(), live.joints.end(), gone.joint);
        now.forces[static_cast<std::size_t>(at - live.joints.begin())] = gone.force_n;
    }
    const auto events = live.scene.contact_events();
    now.contacts.assign(events.begin(), events.end());
}

}  // namespace

bool SceneVerdict::fails(Invariant what) const {
    return std::any_of(breaches.begin(), breaches.end(), [what](const Breach& breach) {
        return breach.what == what && !breach.gave_up;
    });
}

SceneVerdict run_scene(const RandomScene& scene, const SceneRunOptions& options) {
    SceneVerdict verdict;
    verdict.refused = why_unsound(scene);
    if (!verdict.refused.empty()) {
        return verdict;
    }
    auto built = build_live(scene);
    if (!built) {
        verdict.refused = built.error();
        return verdict;
    }
    const std::int64_t before = bench::thread_cpu_ns();
    LiveScene& live = *built;
    SceneInvariants invariants(scene, live);
    Observation now;
    now.states.resize(live.bodies.size());
    now.held.assign(live.joints.size(), true);
    now.forces.assign(live.joints.size(), 0.0F);
    const auto steps = static_cast<std::uint64_t>(std::ceil(scene.seconds / scene.dt - 1.0e-3F));
    while (verdict.steps < steps) {
        observe(scene, live, now);
        if (options.spoil) {
            options.spoil(verdict.steps, now);
        }
        ++verdict.steps;
        verdict.limited_steps += now.stats.substep_limited > 0 ? 1 : 0;
        invariants.look(now);
        verdict.breaches = invariants.breaches();
        if (invariants.broken(Invariant::kFinite) ||
            (options.until && verdict.fails(*options.until))) {
            break;
        }
    }
    verdict.top_speed_mps = invariants.top_speed();
    verdict.cpu_ms = static_cast<double>(bench::thread_cpu_ns() - before) * 1.0e-6;
    return verdict;
}

std::function<void(std::uint64_t, Observation&)> spoil_with(Fault fault) {
    return [fault](std::uint64_t step, Observation& now) {
        if (step < kFaultAfter || now.states.empty()) {
            return;
        }
        physics::BodyState& last = now.states.back();
        switch (fault) {
            case Fault::kNan:
                last.position.y() = std::numeric_limits<float>::quiet_NaN();
                break;
            case Fault::kEnergy:
                last.velocity = 10.0F * last.velocity + Vec3(0.0F, 1000.0F, 0.0F);
                break;
            case Fault::kMomentum:
                last.velocity = 1.5F * last.velocity + Vec3(1.0F, 0.0F, 0.0F);
                break;
            case Fault::kJoint:
            case Fault::kFloor:
                last.position.y() -= 10.0F;
                break;
            case Fault::kAwake:
                for (physics::BodyState& s : now.states) {
                    s.asleep = false;
                }
                break;
            default:
                break;
        }
    };
}

}  // namespace zoned::stability

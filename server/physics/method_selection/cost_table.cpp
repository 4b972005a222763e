#include "server/physics/method_selection/cost_table.h"

namespace zoned::physics::method_selection {

double particle_cost_ns(const ParticleSystemDef& def, int pieces) {
    if (def.flock) {
        return ParticleCost::kFlock_ns;
    }
    double ns = ParticleCost::kGround_ns;
    if (def.linear_drag > 0.0F || def.quadratic_drag > 0.0F) {
        ns += ParticleCost::kDrag_ns;
        ns += def.wind.gust_speed > 0.0F ? ParticleCost::kGusts_ns : 0.0;
    }
    return ns * pieces;
}

SweepCounts counts_of(const soft::SoftDef& def) {
    const auto count = [](const auto& column, bool there) {
        return there ? static_cast<double>(column.size()) : 0.0;
    };
    return {count(def.nodes, true),
            count(def.springs, true),
            count(def.tetrahedra, def.material.bulk_modulus > 0.0F),
            count(def.faces, def.material.gas_pressure > 0.0F)};
}

double soft_cost_ns(soft::SoftMethod method,
                    const SweepCounts& counts,
                    double substeps,
                    double newton_steps,
                    double gradient_passes) {
    switch (method) {
        case soft::SoftMethod::kXpbd:
            return substeps * sweep_cost_ns(kXpbdSubstep, counts);
        case soft::SoftMethod::kSemiImplicitEuler:
            return substeps * sweep_cost_ns(kSemiImplicitSubstep, counts);
        case soft::SoftMethod::kImplicitEuler:
            break;
    }
    return newton_steps * sweep_cost_ns(kNewtonStep, counts) +
           gradient_passes * sweep_cost_ns(kGradientPass, counts);
}

}  // namespace zoned::physics::method_selection

#include "server/config/check/config_checks.h"
#include "server/physics/integrator/stability.h"
#include "proto/config/config.pb.h"

namespace zoned::config {

void check_physics(const proto::config::Config& config, Diagnostics& diagnostics) {
    const auto check = [&](const char* name, proto::config::Physics::Integrator integrator) {
        const std::string reason =
            physics::why_unfit_integrator(static_cast<physics::IntegratorKind>(integrator));
        if (!reason.empty()) {
            diagnostics.add(std::string("physics.") + name, reason);
        }
    };
    check("body_integrator", config.physics().body_integrator());
    check("particle_integrator", config.physics().particle_integrator());
}

}  // namespace zoned::config

#include "server/physics/integrator/free_flight.h"

#include "server/physics/integrator/integrator.h"

namespace zoned::physics {

namespace {

bool fly_adaptively(const FreeFall<float, 3>& fall, float dt, Vec3& way, Vec3& velocity) {
    const FreeFall<double, 3> same(fall.pull(Vec3::Zero(), 0.0F).cast<double>(),
                                   static_cast<double>(fall.drag()));
    Adaptive<Vec3d> method;
    Vec3d x = Vec3d::Zero();
    Vec3d v = velocity.cast<double>();
    method.step(x, v, 0.0, static_cast<double>(dt), same);
    way = x.cast<float>();
    velocity = v.cast<float>();
    return !method.report.gave_up;
}

}  // namespace

bool free_flight_by(IntegratorKind kind,
                    const FreeFall<float, 3>& fall,
                    float dt,
                    Vec3& position,
                    Vec3& velocity) {
    // The pull is the same everywhere: the path is computed from zero, where floats are finest.
    Vec3 way = Vec3::Zero();
    bool done = true;
    if (kind == IntegratorKind::kAdaptive) {
        done = fly_adaptively(fall, dt, way, velocity);
    } else {
        with_integrator<Vec3>(kind, [&](auto method) {
            method.start(way, velocity, 0.0F, dt, fall);
            method.step(way, velocity, 0.0F, dt, fall);
        });
    }
    position += way;
    return done;
}

bool free_flight_in(int pieces,
                    IntegratorKind kind,
                    const FreeFall<float, 3>& fall,
                    float dt,
                    Vec3& position,
                    Vec3& velocity) {
    if (pieces <= 1) {
        return free_flight(kind, fall, dt, position, velocity);
    }
    const float piece = dt / static_cast<float>(pieces);
    Vec3 way = Vec3::Zero();
    bool done = true;
    for (int i = 0; i < pieces; ++i) {
        done = free_flight(kind, fall, piece, way, velocity) && done;
    }
    position += way;
    return done;
}

}  // namespace zoned::physics

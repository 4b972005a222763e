#include "server/physics/method_selection/particle_choice.h"

#include "server/compute/team.h"
#include "server/physics/method_selection/cost_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::physics::method_selection {

namespace {

/// Lets one particle out at the origin as the first tick begins.
motion::Emitter one_particle(const Vec3d& velocity, const FlightBudget& budget) {
    motion::Emitter out;
    out.rate_hz = 1.0e9;
    out.most = 1;
    out.spread = 0.0F;
    out.cone_cosine = 1.0F;
    const double speed = velocity.norm();
    out.direction = speed > 0.0 ? Vec3((velocity / speed).cast<float>()) : Vec3(Vec3::UnitY());
    out.speed_min = out.speed_max = static_cast<float>(speed);
    out.lifetime_min_s = out.lifetime_max_s =
        static_cast<float>(budget.seconds + 2.0 * budget.tick_s);
    return out;
}

double error_from(const ParticleSystemDef& def,
                  const Flight& flight,
                  const Vec3d& velocity,
                  const FlightBudget& budget) {
    ParticleSystem system(def, nullptr);
    system.add(one_particle(velocity, budget));
    compute::Team alone;
    ParticleCounts counts;
    Tick now = 0;
    double most = 0.0;
    for (const Vec3d& there : exact_path(flight, velocity, budget.tick_s, ticks_of(budget))) {
        system.step(now++, static_cast<float>(budget.tick_s), false, alone, counts);
        const double off = (system.position(0).cast<double>() - there).norm();
        if (!std::isfinite(off)) {
            return std::numeric_limits<double>::infinity();
        }
        most = std::max(most, off);
    }
    return most;
}

}  // namespace

Flight flight_of(const ParticleSystemDef& def, double fastest) {
    Flight flight;
    flight.name = def.name;
    flight.gravity = def.gravity.cast<double>();
    flight.linear_drag = static_cast<double>(def.linear_drag);
    flight.quadratic_drag = static_cast<double>(def.quadratic_drag);
    flight.wind = def.wind.uniform.cast<double>();
    flight.fastest = fastest;
    return flight;
}

double particle_error(const ParticleSystemDef& def,
                      int pieces,
                      double fastest,
                      const FlightBudget& budget) {
    ParticleSystemDef free = def;
    free.walls.clear();
    free.balls.clear();
    free.field.reset();
    free.wind.gust_speed = 0.0F;
    free.most = 1;
    free.pieces = pieces;
    const Flight flight = flight_of(def, fastest);
    return std::max(error_from(free, flight, Vec3d::Zero(), budget),
                    error_from(free, flight, launch_of(flight), budget));
}

MethodChoice choose_particle_pieces(const ParticleSystemDef& def,
                                    double fastest,
                                    const FlightBudget& budget) {
    MethodChoice choice;
    choice.subject = "particle system " + def.name;
    choice.unit = "m";
    choice.budget = budget.error_m;
    std::vector<MethodOption> options;
    for (const int pieces : kParticlePieces) {
        MethodOption option;
        option.method = "semi_implicit_euler";
        option.pieces = pieces;
        option.least_cost_ns = particle_cost_ns(def, pieces);
        option.attempt = [&def, pieces, fastest, budget, cost = option.least_cost_ns] {
            MethodTrial trial;
            trial.cost_ns = cost;
            trial.error = particle_error(def, pieces, fastest, budget);
            trial.spent_ns = 2.0 * cost * ticks_of(budget);
            return trial;
        };
        options.push_back(std::move(option));
    }
    choose(choice, options);
    return choice;
}

}  // namespace zoned::physics::method_selection

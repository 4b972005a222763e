#include "server/physics/method_selection/flight_choice.h"

#include "server/physics/integrator/free_flight.h"
#include "server/physics/integrator/integrator.h"
#include "server/physics/integrator/stability.h"
#include "server/physics/method_selection/cost_table.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::method_selection {

namespace {

/// The whole force of a flight; `Real` as the method computes.
template <class Real>
struct Dragged {
    using V = Eigen::Matrix<Real, 3, 1>;

    V gravity;
    V wind;
    Real linear;
    Real quadratic;

    explicit Dragged(const Flight& flight)
        : gravity(flight.gravity.cast<Real>()),
          wind(flight.wind.cast<Real>()),
          linear(static_cast<Real>(flight.linear_drag)),
          quadratic(static_cast<Real>(flight.quadratic_drag)) {}

    [[nodiscard]] Real rate(const V& v) const { return linear + quadratic * (v - wind).norm(); }

    V operator()(const V&, const V& v, Real) const { return gravity - rate(v) * (v - wind); }

    void jacobian(const V&,
                  const V& v,
                  Real,
                  Eigen::Matrix<Real, 3, 3>& dx,
                  Eigen::Matrix<Real, 3, 3>& dv) const {
        dx.setZero();
        const V u = v - wind;
        const Real speed = u.norm();
        dv = -(linear + quadratic * speed) * Eigen::Matrix<Real, 3, 3>::Identity();
        if (speed > 0) {
            dv -= (quadratic / speed) * (u * u.transpose());
        }
    }
};

struct Motion {
    Vec3d x = Vec3d::Zero();
    Vec3d v = Vec3d::Zero();
};

/// x' = v, v' = pull - c v, pull = gravity + c wind: v = end + (v0 - end) e^-ct with end = pull /
/// c.
Motion exact_flight(const Flight& flight, const Motion& start, double t) {
    const double c = flight.linear_drag;
    const Vec3d pull = flight.gravity + c * flight.wind;
    if (c * t < 1.0e-8) {
        return {start.x + t * start.v + 0.5 * t * t * pull, start.v + t * pull};
    }
    const Vec3d end = pull / c;
    const double reach = -elementary::expm1(-c * t) / c;
    return {start.x + t * end + reach * (start.v - end),
            end + elementary::exp(-c * t) * (start.v - end)};
}

/// A step of the engine's, or of the same method on the quadratic force.
bool step_flight(IntegratorKind kind,
                 int pieces,
                 const Flight& flight,
                 float dt,
                 Vec3& x,
                 Vec3& v) {
    const Dragged<float> force(flight);
    if (flight.quadratic_drag <= 0.0) {
        const Vec3 pull = force.gravity + force.linear * force.wind;
        return free_flight_in(pieces, kind, {pull, force.linear}, dt, x, v);
    }
    const float piece = dt / static_cast<float>(pieces);
    bool arrived = true;
    Vec3 way = Vec3::Zero();
    for (int i = 0; i < pieces; ++i) {
        if (kind == IntegratorKind::kDefault) {
            const float rate = force.rate(v);
            const Vec3 pull = force.gravity + rate * force.wind;
            arrived = free_flight(kind, {pull, rate}, piece, way, v) && arrived;
        } else if (kind == IntegratorKind::kAdaptive) {
            Adaptive<Vec3d> method;
            Vec3d xd = way.cast<double>();
            Vec3d vd = v.cast<double>();
            method.step(xd, vd, 0.0, static_cast<double>(piece), Dragged<double>(flight));
            way = xd.cast<float>();
            v = vd.cast<float>();
            arrived = arrived && !method.report.gave_up;
        } else {
            with_integrator<Vec3>(kind, [&](auto method) {
                method.start(way, v, 0.0F, piece, force);
                method.step(way, v, 0.0F, piece, force);
            });
        }
    }
    x += way;
    return arrived;
}

double error_from(const Flight& flight,
                  const Vec3d& start,
                  IntegratorKind kind,
                  int pieces,
                  const FlightBudget& budget) {
    const std::vector<Vec3d> path = exact_path(flight, start, budget.tick_s, ticks_of(budget));
    Vec3 x = Vec3::Zero();
    Vec3 v = start.cast<float>();
    double most = 0.0;
    for (const Vec3d& there : path) {
        const bool arrived =
            step_flight(kind, pieces, flight, static_cast<float>(budget.tick_s), x, v);
        const double off = (x.cast<double>() - there).norm();
        if (!arrived || !std::isfinite(off)) {
            return std::numeric_limits<double>::infinity();
        }
        most = std::max(most, off);
    }
    return most;
}

MethodOption option_of(IntegratorKind kind,
                       int pieces,
                       std::span<const Flight> flights,
                       const FlightBudget& budget) {
    MethodOption option;
    option.code = static_cast<int>(kind);
    option.method = physics::name_of(kind);
    option.pieces = pieces;
    option.least_cost_ns = flight_cost_ns(kind, pieces);
    option.refused = why_unfit_integrator(kind);
    for (const Flight& flight : flights) {
        if (option.refused.empty()) {
            option.refused = why_unstable(kind, pieces, flight, budget.tick_s);
        }
    }
    option.attempt = [=, cost = option.least_cost_ns] {
        MethodTrial trial;
        trial.cost_ns = cost;
        for (const Flight& flight : flights) {
            trial.error = std::max(trial.error, flight_error(kind, pieces, flight, budget));
            trial.spent_ns += 2.0 * cost * budget.seconds / budget.tick_s;
        }
        return trial;
    };
    return option;
}

}  // namespace

double Flight::steepest_drag() const {
    // Against the wind, or down at the speed at which drag and weight balance.
    double speed = fastest + wind.norm();
    if (quadratic_drag > 0.0) {
        speed = std::max(speed, std::sqrt(gravity.norm() / quadratic_drag));
    }
    return linear_drag + 2.0 * quadratic_drag * speed;  // d/dv of q v |v|, along v
}

std::string why_unstable(IntegratorKind kind, int pieces, const Flight& flight, double tick_s) {
    const std::string reason =
        why_unstable_drag(kind, flight.steepest_drag(), tick_s / static_cast<double>(pieces));
    return reason.empty() || flight.name.empty() ? reason : reason + ": " + flight.name;
}

std::vector<Vec3d> exact_path(const Flight& flight,
                              const Vec3d& velocity,
                              double tick_s,
                              int ticks) {
    std::vector<Vec3d> path;
    Adaptive<Vec3d> method;
    method.options.relative = method.options.absolute = 1.0e-9;
    Motion start;
    start.v = velocity;
    Motion now = start;
    for (int i = 1; i <= ticks; ++i) {
        if (flight.quadratic_drag > 0.0) {
            method.step(now.x, now.v, (i - 1) * tick_s, tick_s, Dragged<double>(flight));
        } else {
            now = exact_flight(flight, start, i * tick_s);
        }
        path.push_back(now.x);
    }
    return path;
}

Vec3d launch_of(const Flight& flight) {
    return flight.fastest * Vec3d(std::sqrt(0.5), std::sqrt(0.5), 0.0);
}

int ticks_of(const FlightBudget& budget) {
    return std::max(1, static_cast<int>(std::ceil(budget.seconds / budget.tick_s - 1e-9)));
}

double flight_error(IntegratorKind kind,
                    int pieces,
                    const Flight& flight,
                    const FlightBudget& budget) {
    return std::max(error_from(flight, Vec3d::Zero(), kind, pieces, budget),
                    error_from(flight, launch_of(flight), kind, pieces, budget));
}

MethodChoice choose_flight(std::string subject,
                           std::span<const Flight> flights,
                           const FlightBudget& budget,
                           std::span<const IntegratorKind> methods) {
    MethodChoice choice;
    choice.subject = std::move(subject);
    choice.unit = "m";
    choice.budget = budget.error_m;
    std::vector<MethodOption> options;
    for (const IntegratorKind kind : methods) {
        for (const int pieces : kFlightPieces) {
            options.push_back(option_of(kind, pieces, flights, budget));
        }
    }
    choose(choice, options);
    return choice;
}

}  // namespace zoned::physics::method_selection

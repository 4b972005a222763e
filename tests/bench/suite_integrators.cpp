// Suite `integrators`: each method of server/physics/integrator on motions with known answers, at
// six time steps: error, observed order, drift of the energy, time of a step.
#include "server/physics/integrator/integrate.h"
#include "server/physics/integrator/integrator.h"
#include "server/physics/integrator/stability.h"
#include "tests/bench/comparison.h"
#include "tests/bench/method_costs.h"
#include "tests/scenario/motions.h"
#include "tests/scenario/spin_reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

namespace zoned::bench {

namespace {

using physics::IntegratorKind;
using scenario::MotionState;

constexpr int kStepSizes = 6;
constexpr double kTolerance = 1e-9;  ///< of the adaptive pair
constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

/// A motion, and how runs of it are judged. Rows differ by their time step alone.
template <class Force>
struct KnownMotion {
    using V = typename Force::V;
    using State = MotionState<V>;

    std::string name;
    std::string unit;
    Force force;
    State start;
    double longest = 0.0;  ///< time step, s
    double ratio = 2.0;    ///< of neighbouring time steps
    long steps = 0;        ///< of the longest, up to when the error is taken
    std::function<double(const State&)> error;
    /// The relative error of the energy at the time t.
    std::function<double(const State&, double t)> energy_error;
    long drift_steps = 0;
    std::function<void(Row&, const State&)> after_a_minute;  ///< none: not run
    double omega = 0.0;                                      ///< of a spring; 0: no spring
    double damping_ratio = 0.0;

    [[nodiscard]] double step_at(int size) const { return longest / std::pow(ratio, size); }

    [[nodiscard]] long steps_at(int size) const {
        return std::lround(static_cast<double>(steps) * std::pow(ratio, size));
    }
};

/// A frame is `batch` steps from the start.
template <class Force, class Method>
class MotionTrial : public JudgedTrial {
  public:
    using State = MotionState<typename Force::V>;

    MotionTrial(const KnownMotion<Force>& motion, int size, int batch, const Method& method)
        : motion_(motion),
          size_(size),
          h_(motion.step_at(size)),
          batch_(batch),
          fresh_(method) {}

    void frame() override {
        run(batch_, [](long) {});
    }

    void judge(Row& row) override {
        run(motion_.steps_at(size_), [](long) {});
        row.error = motion_.error(last_);
        row.error_unit = motion_.unit;
        judge_energy(row);
        if (motion_.after_a_minute) {
            run(std::lround(60.0 / h_), [](long) {});
            motion_.after_a_minute(row, last_);
        }
    }

  private:
    template <class Look>
    void run(long steps, const Look& look) {
        Method method = fresh_;
        last_ = motion_.start;
        method.start(last_.x, last_.v, 0.0, h_, motion_.force);
        for (long i = 0; i < steps; ++i) {
            method.step(last_.x, last_.v, static_cast<double>(i) * h_, h_, motion_.force);
            look(i + 1);
        }
    }

    /// The growth of the mean energy error between the second and the last tenth of a long run. An
    /// error that swings and comes back is no drift.
    void judge_energy(Row& row) {
        if (motion_.drift_steps == 0) {
            return;
        }
        // The adaptive pair cuts each step into dozens there, so a tenth of the run must suffice.
        const bool cut = std::is_same_v<Method, physics::Adaptive<typename Force::V>> &&
                         motion_.omega * h_ > 4.0;
        const long steps = cut ? motion_.drift_steps / 10 : motion_.drift_steps;
        const long tenth = steps / 10;
        double early = 0.0;
        double late = 0.0;
        double most = 0.0;
        run(steps, [&](long done) {
            const bool is_early = done > tenth && done <= 2 * tenth;
            if (is_early || done > 9 * tenth) {
                const double off = motion_.energy_error(last_, static_cast<double>(done) * h_);
                (is_early ? early : late) += off / static_cast<double>(tenth);
                most = std::isfinite(off) ? std::max(most, std::abs(off)) : kNoValue;
            }
        });
        row.metric("energy_drift", late - early);
        row.metric("energy_error_max", most);
        row.metric("drift_steps", static_cast<double>(steps));
    }

    const KnownMotion<Force>& motion_;
    int size_;
    double h_;
    int batch_;
    Method fresh_;
    State last_;
};

/// The engine's own free rotation behind the interface of the other methods. Its state stays in the
/// engine's form.
struct EngineSpin {
    Vec3 moments;
    Quat orientation = Quat::Identity();
    Vec3 spin = Vec3::Zero();

    template <class... Rest>
    void start(const Eigen::Vector4d& x, const Eigen::Vector4d& v, const Rest&...) {
        orientation = Quat(Eigen::Vector4f(x.cast<float>()));
        spin = orientation * scenario::FreeRotation::body_spin({x, v}).cast<float>();
    }

    template <class... Rest>
    void step(Eigen::Vector4d& x, Eigen::Vector4d& v, double, double h, const Rest&...) {
        physics::rotate_freely(moments, static_cast<float>(h), orientation, spin);
        x = orientation.coeffs().cast<double>();
        const Quat rate = Quat(0.0F, spin.x(), spin.y(), spin.z()) * orientation;
        v = 0.5 * rate.coeffs().cast<double>();
    }
};

template <class Force>
std::unique_ptr<JudgedTrial> trial_of(const KnownMotion<Force>& motion,
                                      int size,
                                      int batch,
                                      IntegratorKind kind) {
    using V = typename Force::V;
    if constexpr (std::is_same_v<Force, scenario::FreeRotation>) {
        if (kind == IntegratorKind::kDefault) {
            const EngineSpin engine{motion.force.moments.template cast<float>()};
            return std::make_unique<MotionTrial<Force, EngineSpin>>(motion, size, batch, engine);
        }
    }
    return physics::with_integrator<V>(kind, [&](auto method) -> std::unique_ptr<JudgedTrial> {
        using Method = decltype(method);
        if constexpr (std::is_same_v<Method, physics::Adaptive<V>>) {
            method.options = {kTolerance, kTolerance, 1'000'000};
        }
        return std::make_unique<MotionTrial<Force, Method>>(motion, size, batch, method);
    });
}

/// Verlet's forms are for forces that do not depend on velocity: on a rotation they lose their
/// purpose.
template <class Force>
bool has_meaning(IntegratorKind kind) {
    return !std::is_same_v<Force, scenario::FreeRotation> ||
           (kind != IntegratorKind::kVerlet && kind != IntegratorKind::kVelocityVerlet);
}

/// Times become those of a step.
void per_step(Row& row, int batch) {
    row.time_us_p50 /= batch;
    row.time_us_p99 /= batch;
    for (auto& [name, value] : row.metrics) {
        value /= name == "time_us_mean" || name == "wall_us_p50" ? batch : 1;
    }
    row.metric("ns_per_step", 1e3 * row.time_us_p50);
}

/// The order between a row and that with the next longer step. Neither must have exploded, and both
/// must be above the floor of rounding.
void add_order(Row& row, const Row& longer, double ratio) {
    constexpr double kFloor = 1e-12;
    constexpr double kExploded = 100.0;  // all motions are of size one, the ball's of 300 m
    const auto tells = [](const Row& r) {
        return r.error > kFloor && r.error < kExploded;
    };
    if (row.method != physics::name_of(IntegratorKind::kAdaptive) && tells(row) && tells(longer)) {
        row.metric("order", std::log(longer.error / row.error) / std::log(ratio));
    }
}

/// The steps at which the method is stable on this spring.
template <class Force>
void add_stability(Row& row, const KnownMotion<Force>& motion) {
    const auto kind = std::find_if(physics::kIntegratorKinds.begin(),
                                   physics::kIntegratorKinds.end(),
                                   [&row](auto k) { return physics::name_of(k) == row.method; });
    const auto limit = physics::stability_limit(*kind, motion.omega, motion.damping_ratio);
    row.metric("stability_limit_s", limit.step_s);
    row.metric("stable", limit.stable(*row.find_metric("step_s")) ? 1.0 : 0.0);
}

template <class Force>
void compare_on(Session& session, const KnownMotion<Force>& motion) {
    if (!session.wants_scene(motion.name)) {
        return;
    }
    session.progress("integrators " + motion.name);
    const int batch = session.quick ? 32 : 256;
    const Plan plan{0, session.quick ? 4 : 100, session.quick ? 1 : session.repeats};
    std::array<std::vector<Row>, kStepSizes> sizes;
    for (int size = 0; size < kStepSizes; ++size) {
        std::vector<Method> methods;
        for (const IntegratorKind kind : physics::kIntegratorKinds) {
            if (has_meaning<Force>(kind)) {
                methods.push_back({physics::name_of(kind), "", [&motion, size, batch, kind] {
                                       return trial_of(motion, size, batch, kind);
                                   }});
            }
        }
        const double h = motion.step_at(size);
        std::array<char, 40> parameter{};
        std::snprintf(parameter.data(), parameter.size(), "dt=%.5g", h);
        sizes[static_cast<std::size_t>(size)] = compare("integrators",
                                                        motion.name,
                                                        parameter.data(),
                                                        wanted(session, std::move(methods)),
                                                        plan);
        for (Row& row : sizes[static_cast<std::size_t>(size)]) {
            per_step(row, batch);
            row.metric("step_s", h);
            row.metric("steps_per_s", 1.0 / h);
        }
    }
    // By method, so that each is a curve of the report.
    for (std::size_t i = 0; i < sizes[0].size(); ++i) {
        std::vector<Row> rows;
        for (auto& size : sizes) {
            Row& row = size[i];
            if (motion.omega > 0.0) {
                add_stability(row, motion);
            }
            if (!rows.empty()) {
                add_order(row, rows.back(), motion.ratio);
            }
            rows.push_back(std::move(row));
        }
        session.add(std::move(rows));
    }
}

void run_springs(Session& session, long drift_steps) {
    using scenario::Line;
    using scenario::SwayingSpring;
    KnownMotion<SwayingSpring> m;
    m.name = "oscillator";
    m.unit = "m";
    m.force = {2.0 * std::numbers::pi, 0.0, 0.0, 0.0};
    m.start = {Line(1.0), Line(0.0)};
    m.longest = 1.0 / 20;
    m.steps = 46;
    m.omega = m.force.omega;
    m.drift_steps = drift_steps;
    const auto by_time = [](const SwayingSpring& spring, const auto& start, double t) {
        return [exact = spring.exact(start, t), spring](const MotionState<Line>& s) {
            return std::hypot((s.x - exact.x).norm(), (s.v - exact.v).norm() / spring.omega);
        };
    };
    m.error = by_time(m.force, m.start, 2.3);
    const double whole = m.force.energy(m.start);
    m.energy_error = [spring = m.force, whole](const MotionState<Line>& s, double) {
        return spring.energy(s) / whole - 1.0;
    };
    compare_on(session, m);

    // k dt^2 / m = 10^4 at the longest step. The far end sways by a decimetre; the error is taken
    // at no special phase of that.
    m.name = "stiff_spring";
    m.force = {6000.0, 0.1, 0.1, 5.0};
    m.start = {Line(0.0), Line(0.0)};
    m.longest = 1.0 / 60;
    m.ratio = 4.0;
    m.steps = 15;
    m.omega = m.force.omega;
    m.damping_ratio = m.force.damping_ratio;
    m.error = by_time(m.force, m.start, 0.25);
    // Of the mass; its largest kinetic energy is the unit.
    m.energy_error = [spring = m.force, start = m.start](const MotionState<Line>& s, double t) {
        const double most = spring.sway_m * spring.sway_rps;
        const double exact = spring.exact(start, t).v.squaredNorm();
        return (s.v.squaredNorm() - exact) / (most * most);
    };
    compare_on(session, m);
}

void run_conservative(Session& session, long drift_steps) {
    using scenario::Line;
    KnownMotion<scenario::Orbit> orbit;
    orbit.name = "kepler";
    orbit.unit = "semi-axes";
    orbit.start = scenario::Orbit::exact(0.5, 0.0);
    orbit.longest = 2.0 * std::numbers::pi / 100;
    orbit.steps = 90;
    orbit.drift_steps = drift_steps;
    orbit.error = [exact = scenario::Orbit::exact(0.5, 1.8 * std::numbers::pi)](
                      const MotionState<scenario::Plane>& s) {
        return std::hypot((s.x - exact.x).norm(), (s.v - exact.v).norm());
    };
    orbit.energy_error = [](const MotionState<scenario::Plane>& s, double) {
        return -2.0 * scenario::Orbit::energy(s) - 1.0;  // it is -1/2
    };
    compare_on(session, orbit);

    KnownMotion<scenario::Pendulum> pendulum;
    pendulum.name = "pendulum";
    pendulum.unit = "rad";
    pendulum.start = {Line(2.5), Line(0.0)};
    pendulum.longest = 1.0 / 30;
    pendulum.steps = 90;
    pendulum.drift_steps = drift_steps;
    // The rate counts as the angle that it makes in 1 / sqrt(g / l) seconds.
    pendulum.error = [exact = pendulum.force.exact(2.5, 3.0)](const MotionState<Line>& s) {
        return std::hypot((s.x - exact.x).norm(), (s.v - exact.v).norm() / std::sqrt(9.81));
    };
    pendulum.energy_error = [force = pendulum.force, start = pendulum.start](
                                const MotionState<Line>& s, double) {
        return force.energy(s) / force.energy(start) - 1.0;
    };
    compare_on(session, pendulum);
}

/// A ball thrown at 100 m/s; the reference is the adaptive pair at 1e-13.
void run_projectile(Session& session, long drift_steps) {
    KnownMotion<scenario::ThrownBall> m;
    m.name = "projectile_drag";
    m.unit = "m";
    m.start = {Vec3d::Zero(), Vec3d(70, 70, 10)};
    m.longest = 1.0 / 15;
    m.steps = 120;
    // Long after, it falls at its terminal speed. Cut short, it does not get there.
    m.drift_steps = session.quick ? 0 : drift_steps;
    physics::Adaptive<Vec3d> reference;
    reference.options = {1e-13, 1e-13, 1'000'000};
    MotionState<Vec3d> end = m.start;
    reference.step(end.x, end.v, 0.0, 8.0, m.force);
    m.error = [end](const MotionState<Vec3d>& s) {
        return (s.x - end.x).norm();
    };
    m.energy_error = [most = m.force.terminal_speed()](const MotionState<Vec3d>& s, double) {
        return s.v.squaredNorm() / (most * most) - 1.0;
    };
    compare_on(session, m);
}

/// Scene S7 of the physics suite: a box of 1 x 2 x 3 m and 6 kg, spun about its middle axis. Errors
/// are those of the spin in body axes after 2 s, before the first flip. Any wobble has grown a
/// hundredfold by then.
void run_free_spin(Session& session, long drift_steps) {
    const Vec3d spin(0.01, 5.0, 0.01);
    KnownMotion<scenario::FreeRotation> m;
    m.name = "free_spin";
    m.unit = "share";
    m.force.moments = Vec3d(6.5, 5.0, 2.5);
    m.start = scenario::FreeRotation::start(spin);
    m.longest = 1.0 / 15;
    m.steps = 30;
    m.drift_steps = drift_steps;
    using State = MotionState<Eigen::Vector4d>;
    m.error = [end = scenario::free_spin(m.force.moments, spin, 2.0).omega_end](const State& s) {
        return (scenario::FreeRotation::body_spin(s) - end).norm() / end.norm();
    };
    m.energy_error = [force = m.force, start = m.start](const State& s, double) {
        return force.energy(s) / force.energy(start) - 1.0;
    };
    m.after_a_minute = [force = m.force, start = m.start](Row& row, const State& s) {
        const Vec3d from = force.momentum(start);
        const Vec3d to = force.momentum(s);
        row.metric("energy_error_60s", force.energy(s) / force.energy(start) - 1.0);
        row.metric("momentum_turned_60s_degrees",
                   std::atan2(from.cross(to).norm(), from.dot(to)) * 180.0 / std::numbers::pi);
    };
    compare_on(session, m);
}

void run_integrators(Session& session) {
    session.note(
        "integrators: times are of one step; energy_drift is the change of the mean energy error "
        "over 1,000,000 steps (2,000 with --quick), as a share; the adaptive pair keeps a "
        "tolerance "
        "of 1e-9 whatever the step, and so has no order");
    session.note(
        "integrators: free_spin has no rows verlet and velocity_verlet: a rotation's acceleration "
        "depends on its rate, which leaves them neither symplectic nor reversible; its default is "
        "the engine's splitting, on floats");
    const long drift_steps = session.quick ? 2000 : 1'000'000;
    run_springs(session, drift_steps);
    run_conservative(session, drift_steps);
    if (session.wants_scene("projectile_drag")) {
        run_projectile(session, drift_steps);
    }
    if (session.wants_scene("free_spin")) {
        run_free_spin(session, drift_steps);
    }
    if (session.wants_scene("free_flight")) {
        run_flight_costs(session);
    }
}

const Registration kIntegrators({"integrators",
                                 "error, order, energy and cost of what carries motions on",
                                 {"oscillator",
                                  "stiff_spring",
                                  "kepler",
                                  "pendulum",
                                  "projectile_drag",
                                  "free_spin",
                                  "free_flight"},
                                 {"explicit_euler",
                                  "implicit_euler",
                                  "semi_implicit_euler",
                                  "verlet",
                                  "velocity_verlet",
                                  "rk2",
                                  "rk4",
                                  "adaptive",
                                  "default"},
                                 run_integrators});

}  // namespace

}  // namespace zoned::bench

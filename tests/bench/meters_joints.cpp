// Meters of jointed bodies under contact: drops, a car, ragdolls, a sheet.
#include "tests/bench/motion_sums.h"
#include "tests/bench/physics_meters.h"
#include "tests/scenario/joint_scenes.h"

#include <algorithm>
#include <cmath>

namespace zoned::bench {

namespace {

/// Largest values over a run that any jointed scene shows.
class JointWatch {
  public:
    explicit JointWatch(const scenario::Description& description)
        : description_(description),
          start_(sums_at_start(description)) {}

    void look(const Simulator& simulator) {
        now_ = sums_now(description_, simulator);
        fastest_ = std::max(fastest_, now_.fastest);
        energy_ = std::max(energy_, now_.kinetic + now_.potential);
        not_finite_ = std::max(not_finite_, now_.not_finite);
        errors_ = joint_errors(description_, simulator);
        worst_.gap_m = std::max(worst_.gap_m, errors_.gap_m);
        worst_.axis_rad = std::max(worst_.axis_rad, errors_.axis_rad);
    }

    void write(Row& row) const {
        row.metric("gap_m_max", worst_.gap_m);
        row.metric("gap_end_m", errors_.gap_m);
        row.metric("axis_error_rad_max", worst_.axis_rad);
        row.metric("speed_mps_max", fastest_);
        row.metric("speed_end_mps", now_.fastest);
        row.metric("not_finite", not_finite_);
    }

    [[nodiscard]] const scenario::Description& description() const { return description_; }

    [[nodiscard]] const MotionSums& start() const { return start_; }

    [[nodiscard]] const MotionSums& now() const { return now_; }

    [[nodiscard]] double fastest() const { return fastest_; }

    /// Kinetic and potential, largest over the run, J.
    [[nodiscard]] double energy() const { return energy_; }

    [[nodiscard]] double gap() const { return worst_.gap_m; }

  private:
    scenario::Description description_;
    MotionSums start_;
    MotionSums now_;
    JointErrors errors_;
    JointErrors worst_;
    double fastest_ = 0.0;
    double energy_ = -INFINITY;
    int not_finite_ = 0;
};

/// Drops: the scene's lowest point begins at a known height above the ground.
class DropMeter : public Meter {
  public:
    explicit DropMeter(const scenario::Description& description) : watch_(description) {
        clearance_ = INFINITY;
        for (const scenario::Body& body : description.bodies) {
            if (body.mass > 0.0 && body.solid.form == scenario::Form::kSphere) {
                clearance_ = std::min(clearance_, body.pose.position.y() - body.solid.radius);
            }
        }
        fall_s_ = std::sqrt(2.0 * clearance_ / 9.81);
    }

    void after_step(const Simulator& simulator) override {
        watch_.look(simulator);
        const scenario::Description& d = watch_.description();
        // Two frames for the impact itself.
        if (++steps_ * d.dt < fall_s_ + 2.0 * d.dt) {
            return;
        }
        for (std::size_t i = 0; i < d.bodies.size(); ++i) {
            if (d.bodies[i].mass > 0.0) {
                const double rest = d.bodies[i].pose.position.y() - clearance_;
                rise_ = std::max(rise_, simulator.motion(i).pose.position.y() - rest);
            }
        }
    }

    void finish(const Simulator& /*simulator*/, Row& row) override {
        double weight = 0.0;
        for (const scenario::Body& body : watch_.description().bodies) {
            weight += body.mass * 9.81;
        }
        row.error = watch_.now().not_finite > 0 ? INFINITY : rise_;
        row.error_unit = "m";
        const MotionSums& start = watch_.start();
        row.metric(
            "energy_gain_percent",
            100.0 * (watch_.energy() - start.kinetic - start.potential) / (weight * clearance_));
        row.metric("fall_speed_mps", 9.81 * fall_s_);
        watch_.write(row);
    }

  private:
    JointWatch watch_;
    double clearance_ = 0.0;
    double fall_s_ = 0.0;
    double rise_ = 0.0;
    int steps_ = 0;
};

class CarMeter : public Meter {
  public:
    explicit CarMeter(const scenario::Description& description) : watch_(description) {}

    void after_step(const Simulator& simulator) override {
        watch_.look(simulator);
        ++steps_;
    }

    void finish(const Simulator& simulator, Row& row) override {
        const scenario::Description& d = watch_.description();
        const Motion box = simulator.motion(1);
        const double way = box.pose.position.z() - d.bodies[1].pose.position.z();
        double mass = 0.0;
        double turning = 0.0;  // what the wheels' rotation adds to the mass, kg
        double work = 0.0;     // J: most kinetic energy at the motors' speed, and of the first fall
        const double speed = scenario::kWheelSpeed * scenario::kWheelRadius;
        for (const scenario::Body& body : d.bodies) {
            mass += body.mass;
            turning += body.solid.form == scenario::Form::kSphere ? 0.4 * body.mass : 0.0;
            work += body.mass * 9.81 * (body.mass > 0.0 ? body.pose.position.y() : 0.0);
        }
        work += 0.5 * (mass + turning) * speed * speed;
        const bool mesh = d.bodies.front().solid.form == scenario::Form::kMesh;
        const double pull = 4.0 * scenario::kWheelTorque / scenario::kWheelRadius;
        const double fall = 0.8;  // m, of the wheels before they grip
        const double exact = mesh ? kMeshWay
                                  : speed * (steps_ * d.dt - std::sqrt(2.0 * fall / 9.81) -
                                             0.5 * speed * (mass + turning) / pull);
        row.error = is_finite(box) ? way - exact : INFINITY;
        row.error_unit = "m";
        row.metric("way_m", way);
        row.metric("aside_m", box.pose.position.x());
        row.metric("kinetic_over_most", watch_.now().kinetic / work);
        watch_.write(row);
    }

  private:
    /// Fine steps of the best engine: 230 to 236 m.
    static constexpr double kMeshWay = 233.0;

    JointWatch watch_;
    int steps_ = 0;
};

class RagdollMeter : public Meter {
  public:
    explicit RagdollMeter(const scenario::Description& description) : watch_(description) {}

    void after_step(const Simulator& simulator) override { watch_.look(simulator); }

    void finish(const Simulator& simulator, Row& row) override {
        const scenario::Description& d = watch_.description();
        double top = 0.0;
        double moving = 0.0;
        double asleep = 0.0;
        for (std::size_t i = 0; i < d.bodies.size(); ++i) {
            if (d.bodies[i].mass > 0.0) {
                top = std::max(top, d.bodies[i].pose.position.y());
                moving += 1.0;
                asleep += simulator.motion(i).asleep ? 1.0 : 0.0;
            }
        }
        const double fall = std::sqrt(2.0 * 9.81 * top);  // m/s, of the highest part to the ground
        row.error = watch_.now().not_finite > 0 ? INFINITY : watch_.fastest() / fall;
        row.error_unit = "1";
        row.metric("fall_speed_mps", fall);
        row.metric("asleep_share", asleep / moving);
        watch_.write(row);
    }

  private:
    JointWatch watch_;
};

class SheetMeter : public Meter {
  public:
    explicit SheetMeter(const scenario::Description& description) : watch_(description) {}

    void after_step(const Simulator& simulator) override { watch_.look(simulator); }

    void finish(const Simulator& /*simulator*/, Row& row) override {
        row.error = watch_.now().not_finite > 0 ? INFINITY : watch_.gap() / scenario::kSheetLink;
        row.error_unit = "1";
        watch_.write(row);
    }

  private:
    JointWatch watch_;
};

}  // namespace

std::unique_ptr<Meter> drop_meter(const scenario::Description& description) {
    return std::make_unique<DropMeter>(description);
}

std::unique_ptr<Meter> car_meter(const scenario::Description& description) {
    return std::make_unique<CarMeter>(description);
}

std::unique_ptr<Meter> ragdoll_meter(const scenario::Description& description) {
    return std::make_unique<RagdollMeter>(description);
}

std::unique_ptr<Meter> sheet_meter(const scenario::Description& description) {
    return std::make_unique<SheetMeter>(description);
}

}  // namespace zoned::bench

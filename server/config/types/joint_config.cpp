#include "server/config/types/joint_config.h"

#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "proto/config/config.pb.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace zoned::config {

namespace {

using proto::config::Joint;
using zone::MotorTarget;

Vec3 point_of(const proto::config::Corner& corner) {
    return {narrow(corner.x_m()), narrow(corner.y_m()), narrow(corner.z_m())};
}

class JointReader {
  public:
    JointReader(const JointEnds& ends, const std::string& path, Diagnostics& diagnostics)
        : ends_(ends),
          path_(path),
          diagnostics_(diagnostics) {}

    std::shared_ptr<const zone::JointPlan> read(const Joint& from) {
        const std::size_t before = diagnostics_.size();
        plan_.name = from.name();
        def().collide = from.collide();
        if (from.break_force_n() > 0.0) {
            def().break_force_n = narrow(from.break_force_n());
        }
        def().anchor = ends_.stands_b.conjugate() * point_of(from.anchor());
        read_kind(from);
        const bool two_points = from.has_distance() || from.has_spring();
        if (from.has_anchor_a() && !two_points) {
            diagnostics_.add(path_ + ".anchor_a", "belongs to distance and spring only");
        }
        if (two_points) {
            def().anchor_b = def().anchor;
            const Quat& stands = ends_.to_world ? ends_.stands_b : ends_.stands_a;
            def().anchor = stands.conjugate() * point_of(from.anchor_a());
        }
        if (diagnostics_.size() == before) {
            if (const std::string reason = physics::why_unfit(def()); !reason.empty()) {
                diagnostics_.add(path_, reason);
            }
        }
        return diagnostics_.size() == before
                   ? std::make_shared<const zone::JointPlan>(std::move(plan_))
                   : nullptr;
    }

  private:
    physics::JointDef& def() { return plan_.def; }

    void read_kind(const Joint& from) {
        switch (from.kind_case()) {
            case Joint::kBall:
                read_ball(from.ball());
                return;
            case Joint::kHinge:
                read_hinge(from.hinge());
                return;
            case Joint::kSlider:
                read_slider(from.slider());
                return;
            case Joint::kFixed:
                def().kind = physics::JointKind::kFixed;
                return;
            case Joint::kDistance:
                def().kind = physics::JointKind::kDistance;
                if (from.distance().has_length_m()) {
                    def().length_m = narrow(from.distance().length_m());
                }
                return;
            case Joint::kSpring:
                def().kind = physics::JointKind::kSpring;
                def().spring_hz = narrow(from.spring().frequency_hz());
                def().spring_damping_ratio = narrow(from.spring().damping_ratio());
                if (from.spring().has_length_m()) {
                    def().length_m = narrow(from.spring().length_m());
                }
                return;
            case Joint::KIND_NOT_SET:
                break;
        }
        diagnostics_.add(
            path_, "a joint needs a kind: ball, hinge, slider, fixed, distance or spring { ... }");
    }

    void read_ball(const proto::config::BallJoint& ball) {
        def().kind = physics::JointKind::kBall;
        read_friction(ball.friction_nm(), false, ".ball.friction_nm");
        read_axis(ball.has_axis(), ball.axis(), ".ball.axis", def().axis);
        const bool twists = ball.has_twist_min_deg() || ball.has_twist_max_deg();
        if (!ball.has_cone_deg()) {
            const char* extra = ball.has_cone_axis() ? ".ball.cone_axis"
                                : twists             ? ".ball.twist_min_deg"
                                                     : nullptr;
            if (extra != nullptr) {
                diagnostics_.add(path_ + extra, "goes with cone_deg");
            }
            return;
        }
        def().cone_rad = narrow(ball.cone_deg() * kRadians);
        if (ball.has_cone_axis()) {
            read_axis(true, ball.cone_axis(), ".ball.cone_axis", def().cone_axis);
            if (!def().cone_axis.isZero(0.0F)) {
                check_cone(ball.cone_deg());
            }
        }
        read_limits(ball.has_twist_min_deg(),
                    ball.has_twist_max_deg(),
                    ball.twist_min_deg(),
                    ball.twist_max_deg(),
                    ".ball.twist_min_deg",
                    "twist_max_deg",
                    kRadians);
    }

    void check_cone(double cone_deg) {
        const double cosine = static_cast<double>(def().axis.dot(def().cone_axis));
        const double out_deg = elementary::acos(std::clamp(cosine, -1.0, 1.0)) / kRadians;
        if (out_deg > cone_deg + 0.01) {
            diagnostics_.add(
                path_ + ".ball.cone_axis",
                text_of("as placed, the axis is %g degrees from it, outside cone_deg, %g",
                        out_deg,
                        cone_deg));
        }
    }

    void read_hinge(const proto::config::HingeJoint& hinge) {
        def().kind = physics::JointKind::kHinge;
        read_axis(hinge.has_axis(), hinge.axis(), ".hinge.axis", def().axis);
        read_limits(hinge.has_min_deg(),
                    hinge.has_max_deg(),
                    hinge.min_deg(),
                    hinge.max_deg(),
                    ".hinge.min_deg",
                    "max_deg",
                    kRadians);
        read_friction(hinge.friction_nm(), hinge.has_motor(), ".hinge.friction_nm");
        if (!hinge.has_motor()) {
            return;
        }
        const proto::config::HingeMotor& motor = hinge.motor();
        const std::string here = path_ + ".hinge.motor";
        if (motor.drive_case() == proto::config::HingeMotor::DRIVE_NOT_SET) {
            diagnostics_.add(here, "a motor needs speed_rps or angle_deg { ... }");
            return;
        }
        const bool holds = motor.has_angle_deg();
        zone::MotorDef out;
        out.holds_position = holds;
        out.target = read_target(holds ? motor.angle_deg() : motor.speed_rps(),
                                 here + (holds ? ".angle_deg" : ".speed_rps"),
                                 holds ? kRadians : 1.0);
        finish_motor(
            out, motor.max_torque_nm(), motor.max_speed_rps(), here, ".max_torque_nm", kRadians);
    }

    void read_slider(const proto::config::SliderJoint& slider) {
        def().kind = physics::JointKind::kSlider;
        read_axis(slider.has_axis(), slider.axis(), ".slider.axis", def().axis);
        read_limits(slider.has_min_m(),
                    slider.has_max_m(),
                    slider.min_m(),
                    slider.max_m(),
                    ".slider.min_m",
                    "max_m",
                    1.0);
        read_friction(slider.friction_n(), slider.has_motor(), ".slider.friction_n");
        if (!slider.has_motor()) {
            return;
        }
        const proto::config::SliderMotor& motor = slider.motor();
        const std::string here = path_ + ".slider.motor";
        if (motor.drive_case() == proto::config::SliderMotor::DRIVE_NOT_SET) {
            diagnostics_.add(here, "a motor needs speed_mps or shift_m { ... }");
            return;
        }
        zone::MotorDef out;
        out.holds_position = motor.has_shift_m();
        out.target = read_target(motor.has_shift_m() ? motor.shift_m() : motor.speed_mps(),
                                 here + (motor.has_shift_m() ? ".shift_m" : ".speed_mps"),
                                 1.0);
        finish_motor(out, motor.max_force_n(), motor.max_speed_mps(), here, ".max_force_n", 1.0);
    }

    void read_axis(bool given, const proto::config::Axis& axis, const char* at, Vec3& out) {
        Vec3 direction = Vec3::UnitY();
        if (given) {
            direction = Vec3(narrow(axis.x()), narrow(axis.y()), narrow(axis.z()));
            if (!(direction.norm() > 1e-6F)) {
                diagnostics_.add(path_ + at, "an axis needs a direction: all of x, y, z are 0");
                return;
            }
        }
        out = ends_.stands_b.conjugate() * direction.normalized();
    }

    void read_limits(bool has_min,
                     bool has_max,
                     double low,
                     double high,
                     const char* at,
                     const char* other,
                     double unit) {
        if (has_min != has_max) {
            diagnostics_.add(path_ + at,
                             std::string("goes with ") + other + ": give both, or none");
            return;
        }
        if (low > high) {
            diagnostics_.add(path_ + at,
                             text_of("%g is above ", low) + other + text_of(", %g", high));
            return;
        }
        def().limited = has_min;
        def().lower = narrow(low * unit);
        def().upper = narrow(high * unit);
    }

    /// Friction is a motor that wants to stand still.
    void read_friction(double friction, bool motor, const char* at) {
        if (!(friction > 0.0)) {
            return;
        }
        if (motor) {
            diagnostics_.add(path_ + at, "a joint has either friction or a motor");
            return;
        }
        def().motor = true;
        def().motor_max = narrow(friction);
    }

    MotorTarget read_target(const proto::config::Target& from, const std::string& at, double unit) {
        MotorTarget out;
        switch (from.value_case()) {
            case proto::config::Target::kConstant:
                out.mean = narrow(from.constant() * unit);
                return out;
            case proto::config::Target::kSine:
                out.form = MotorTarget::Form::kSine;
                out.mean = narrow(from.sine().mean() * unit);
                out.amplitude = narrow(from.sine().amplitude() * unit);
                out.period_s = from.sine().period_s();
                out.phase_rad = from.sine().phase_deg() * kRadians;
                return out;
            case proto::config::Target::kRamps:
                return read_ramps(from.ramps(), at + ".ramps", unit);
            case proto::config::Target::VALUE_NOT_SET:
                break;
        }
        diagnostics_.add(at, "a target needs constant, sine { ... } or ramps { ... }");
        return out;
    }

    MotorTarget read_ramps(const proto::config::Ramps& from, const std::string& at, double unit) {
        MotorTarget out;
        out.form = MotorTarget::Form::kRamps;
        out.period_s = from.has_period_s() ? from.period_s() : 0.0;
        for (int p = 0; p < from.point_size(); ++p) {
            const proto::config::RampPoint& point = from.point(p);
            if (p > 0 && !(point.at_s() > from.point(p - 1).at_s())) {
                diagnostics_.add(join_path(at, "point", p),
                                 text_of("%g s is not after the point before, %g s",
                                         point.at_s(),
                                         from.point(p - 1).at_s()));
            }
            if (out.period_s > 0.0 && point.at_s() > out.period_s) {
                diagnostics_.add(
                    join_path(at, "point", p),
                    text_of("%g s is beyond the period of %g s", point.at_s(), out.period_s));
            }
            out.points.push_back({point.at_s(), narrow(point.value() * unit)});
        }
        return out;
    }

    void finish_motor(zone::MotorDef& motor,
                      double most,
                      double max_speed,
                      const std::string& here,
                      const char* at_most,
                      double unit) {
        if (!(most > 0.0)) {
            diagnostics_.add(here + at_most, "a motor needs some: give a number above 0");
        }
        motor.most = narrow(most);
        motor.max_speed = narrow(max_speed);
        const bool constant = motor.target.form == MotorTarget::Form::kConstant;
        if (motor.holds_position && constant && def().limited &&
            (motor.target.mean < def().lower || motor.target.mean > def().upper)) {
            diagnostics_.add(here,
                             text_of("its target, %g, is outside the limits %g to %g",
                                     static_cast<double>(motor.target.mean) / unit,
                                     static_cast<double>(def().lower) / unit,
                                     static_cast<double>(def().upper) / unit));
        }
        plan_.motor = std::move(motor);
    }

    const JointEnds& ends_;
    const std::string& path_;
    Diagnostics& diagnostics_;
    zone::JointPlan plan_;
};

}  // namespace

std::shared_ptr<const zone::JointPlan> read_joint(const Joint& from,
                                                  const JointEnds& ends,
                                                  const std::string& path,
                                                  Diagnostics& diagnostics) {
    return JointReader(ends, path, diagnostics).read(from);
}

}  // namespace zoned::config

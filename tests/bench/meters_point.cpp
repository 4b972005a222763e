// Meters of single bodies against closed forms: bounces, inclines and fast spheres.
#include "tests/bench/physics_meters.h"
#include "tests/bench/statistics.h"

#include <array>
#include <cmath>

namespace zoned::bench {

namespace {

/// Heights above the drop's rest position at which the ball turned around, from three samples each:
/// flight is a parabola, whose top lies between samples.
class Apexes {
  public:
    void add(double height) {
        last_ = {last_[1], last_[2], height};
        if (++count_ >= 3 && last_[1] > last_[0] && last_[1] >= last_[2]) {
            const double bend = last_[0] - 2.0 * last_[1] + last_[2];
            const double slope = 0.5 * (last_[2] - last_[0]);
            heights_.push_back(last_[1] - 0.5 * slope * slope / bend);
        }
    }

    [[nodiscard]] const std::vector<double>& heights() const { return heights_; }

  private:
    std::array<double, 3> last_{};
    int count_ = 0;
    std::vector<double> heights_;
};

class BounceMeter : public Meter {
  public:
    explicit BounceMeter(const scenario::Description& description)
        : ball_(description.bodies.size() - 1),
          rest_(description.bodies.back().solid.radius),
          restitution_(description.bodies.back().restitution) {}

    void after_step(const Simulator& simulator) override {
        apexes_.add(simulator.motion(ball_).pose.position.y() - rest_);
    }

    void finish(const Simulator& /*simulator*/, Row& row) override {
        const std::vector<double>& heights = apexes_.heights();
        row.metric("apexes", static_cast<double>(heights.size()));
        if (restitution_ == 1.0) {
            row.error =
                heights.empty() ? -scenario::kDropHeight : heights.back() - scenario::kDropHeight;
            row.error_unit = "m";
            return;
        }
        double largest_error = 0.0;
        for (std::size_t k = 1; k <= 6; ++k) {
            const double exact = scenario::kDropHeight *
                                 std::pow(restitution_ * restitution_, static_cast<double>(k));
            const double height = k <= heights.size() ? heights[k - 1] : 0.0;
            row.metric("apex_" + std::to_string(k) + "_m", height);
            row.metric("apex_" + std::to_string(k) + "_error", height / exact - 1.0);
            largest_error = std::max(largest_error, std::abs(height / exact - 1.0));
            row.error = height / exact - 1.0;
        }
        row.metric("apex_error_largest", largest_error);
        row.error_unit = "1";
    }

  private:
    std::size_t ball_;
    double rest_;
    double restitution_;
    Apexes apexes_;
};

class InclineMeter : public Meter {
  public:
    InclineMeter(const scenario::Description& description, bool slides)
        : description_(description),
          slides_(slides) {}

    void after_step(const Simulator& simulator) override {
        const Vec3d moved = displacement(simulator);
        const double normal = moved.dot(normal_);
        along_largest_ = std::max(along_largest_, (moved - normal * normal_).norm());
        normal_largest_ = std::max(normal_largest_, std::abs(normal));
    }

    void finish(const Simulator& simulator, Row& row) override {
        const Vec3d moved = displacement(simulator);
        const double normal = moved.dot(normal_);
        const Vec3d along = moved - normal * normal_;
        const double seconds = description_.steps * description_.dt;
        const double pull =
            std::sin(scenario::kInclineRadians) -
            description_.bodies.back().friction * std::cos(scenario::kInclineRadians);
        const double exact = 0.5 * 9.81 * pull * seconds * seconds;
        row.error = slides_ ? along.norm() - exact : along.norm();
        row.error_unit = "m";
        row.metric("distance_m", along.norm());
        row.metric("distance_largest_m", along_largest_);
        row.metric("normal_displacement_m", normal);
        row.metric("normal_displacement_m_max", normal_largest_);
    }

  private:
    [[nodiscard]] Vec3d displacement(const Simulator& simulator) const {
        const std::size_t cube = description_.bodies.size() - 1;
        return simulator.motion(cube).pose.position - description_.bodies[cube].pose.position;
    }

    scenario::Description description_;
    bool slides_;
    Vec3d normal_ =
        Vec3d(-std::sin(scenario::kInclineRadians), std::cos(scenario::kInclineRadians), 0.0);
    double along_largest_ = 0.0;
    double normal_largest_ = 0.0;
};

class BulletsMeter : public Meter {
  public:
    explicit BulletsMeter(const scenario::Description& description) : description_(description) {}

    void after_step(const Simulator& /*simulator*/) override {}

    void finish(const Simulator& simulator, Row& row) override {
        int passed = 0;
        int reached = 0;
        std::vector<double> speeds;
        for (std::size_t i = 0; i < description_.bodies.size(); ++i) {
            if (description_.bodies[i].mass == 0.0) {
                continue;
            }
            const Motion m = simulator.motion(i);
            passed += m.pose.position.x() > 0.0 || !m.pose.position.allFinite() ? 1 : 0;
            reached += m.pose.position.x() > -5.0 ? 1 : 0;
            speeds.push_back(m.velocity.norm());
        }
        row.error = passed;
        row.error_unit = "count";
        row.metric("passed", passed);
        row.metric("near_or_past_wall", reached);
        row.metric("speed_mps_max", largest(speeds));
    }

  private:
    scenario::Description description_;
};

}  // namespace

std::unique_ptr<Meter> last_apex_meter(const scenario::Description& description) {
    return std::make_unique<BounceMeter>(description);
}

std::unique_ptr<Meter> apexes_meter(const scenario::Description& description) {
    return std::make_unique<BounceMeter>(description);
}

std::unique_ptr<Meter> slide_meter(const scenario::Description& description) {
    return std::make_unique<InclineMeter>(description, true);
}

std::unique_ptr<Meter> creep_meter(const scenario::Description& description) {
    return std::make_unique<InclineMeter>(description, false);
}

std::unique_ptr<Meter> bullets_meter(const scenario::Description& description) {
    return std::make_unique<BulletsMeter>(description);
}

}  // namespace zoned::bench

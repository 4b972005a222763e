// Meters of stacks: drift, height and penetration.
#include "tests/bench/motion_sums.h"
#include "tests/bench/physics_meters.h"
#include "tests/bench/statistics.h"
#include "tests/scenario/overlaps.h"

#include <algorithm>
#include <cmath>

namespace zoned::bench {

namespace {

std::vector<scenario::Pose> poses_of(const scenario::Description& d, const Simulator& simulator) {
    std::vector<scenario::Pose> poses;
    for (std::size_t i = 0; i < d.bodies.size(); ++i) {
        poses.push_back(simulator.motion(i).pose);
    }
    return poses;
}

/// Stands: no body is further than this from its start.
constexpr double kStands = 0.5;

class DriftMeter : public Meter {
  public:
    DriftMeter(const scenario::Description& description, bool height)
        : description_(description),
          height_(height) {}

    void after_step(const Simulator& /*simulator*/) override {}

    void finish(const Simulator& simulator, Row& row) override {
        std::vector<double> drifts;
        const std::vector<scenario::Pose> poses = poses_of(description_, simulator);
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const scenario::Body& body = description_.bodies[i];
            if (body.mass > 0.0) {
                drifts.push_back((poses[i].position - body.pose.position).norm());
            }
        }
        const double top = poses.back().position.y() - description_.bodies.back().pose.position.y();
        row.error = height_ ? top : largest(drifts);
        row.error_unit = "m";
        row.metric("drift_largest_m", largest(drifts));
        row.metric("drift_mean_m", mean(drifts));
        row.metric("top_height_error_m", top);
        row.metric("stands", largest(drifts) < kStands ? 1.0 : 0.0);
        const scenario::Overlaps overlaps = scenario::find_overlaps(description_.bodies, poses);
        row.metric("pair_penetration_m_max", largest(overlaps.pairs));
        row.metric("floor_penetration_m_max", largest(overlaps.floor));
    }

  private:
    scenario::Description description_;
    bool height_;
};

class CardMeter : public Meter {
  public:
    explicit CardMeter(const scenario::Description& description) : description_(description) {}

    void after_step(const Simulator& simulator) override {
        ++steps_;
        for (std::size_t i = 0; i < description_.bodies.size(); ++i) {
            const scenario::Body& body = description_.bodies[i];
            const double moved = (simulator.motion(i).pose.position - body.pose.position).norm();
            drift_ = std::isfinite(moved) ? std::max(drift_, moved) : INFINITY;
        }
        if (drift_ > kFallen && fell_s_ < 0.0) {
            fell_s_ = steps_ * description_.dt;
        }
    }

    void finish(const Simulator& /*simulator*/, Row& row) override {
        row.error = drift_;
        row.error_unit = "m";
        row.metric("stands", fell_s_ < 0.0 ? 1.0 : 0.0);
        row.metric("fell_after_s", fell_s_);
    }

  private:
    static constexpr double kFallen = 0.1;  // m

    scenario::Description description_;
    double drift_ = 0.0;
    double fell_s_ = -1.0;
    int steps_ = 0;
};

/// Steps between measurements of the penetration of a pile that still falls.
constexpr int kLook = 20;

class PileMeter : public Meter {
  public:
    explicit PileMeter(const scenario::Description& description) : description_(description) {}

    void after_step(const Simulator& simulator) override {
        if (++steps_ % kLook == 0) {
            const scenario::Overlaps overlaps =
                scenario::find_overlaps(description_.bodies, poses_of(description_, simulator));
            ever_ = std::max({ever_, largest(overlaps.pairs), largest(overlaps.fixed)});
        }
    }

    void finish(const Simulator& simulator, Row& row) override {
        std::vector<double> speeds;
        int escaped = 0;
        int broken = 0;
        const double half = 0.5 * scenario::kPitWidth;
        for (std::size_t i = 0; i < description_.bodies.size(); ++i) {
            if (description_.bodies[i].mass == 0.0) {
                continue;
            }
            const Motion m = simulator.motion(i);
            const Vec3d& p = m.pose.position;
            if (!is_finite(m)) {
                ++broken;
            } else if (std::abs(p.x()) > half || std::abs(p.z()) > half || p.y() < 0.0) {
                ++escaped;
            } else {
                speeds.push_back(m.velocity.norm());
            }
        }
        const scenario::Overlaps overlaps =
            scenario::find_overlaps(description_.bodies, poses_of(description_, simulator));
        row.error = mean(overlaps.pairs);
        row.error_unit = "m";
        row.metric("pair_penetration_m_mean", mean(overlaps.pairs));
        row.metric("pair_penetration_m_p99", quantile(overlaps.pairs, 0.99));
        row.metric("pair_penetration_m_max", largest(overlaps.pairs));
        row.metric("overlapping_pairs", static_cast<double>(overlaps.pairs.size()));
        row.metric("floor_penetration_m_mean", mean(overlaps.floor));
        row.metric("floor_penetration_m_max", largest(overlaps.floor));
        row.metric("wall_penetration_m_max", largest(overlaps.fixed));
        row.metric("penetration_m_max_on_the_way", ever_);
        row.metric("speed_mps_mean", mean(speeds));
        row.metric("escaped", escaped);
        row.metric("not_finite", broken);
    }

  private:
    scenario::Description description_;
    int steps_ = 0;
    double ever_ = 0.0;
};

}  // namespace

std::unique_ptr<Meter> drift_meter(const scenario::Description& description) {
    return std::make_unique<DriftMeter>(description, false);
}

std::unique_ptr<Meter> column_meter(const scenario::Description& description) {
    return std::make_unique<DriftMeter>(description, true);
}

std::unique_ptr<Meter> card_meter(const scenario::Description& description) {
    return std::make_unique<CardMeter>(description);
}

std::unique_ptr<Meter> pile_meter(const scenario::Description& description) {
    return std::make_unique<PileMeter>(description);
}

}  // namespace zoned::bench

// Meters of hulls, compounds and surfaces: overlap of all that touches, and a field of boxes.
#include "tests/bench/motion_sums.h"
#include "tests/bench/physics_meters.h"
#include "tests/bench/statistics.h"
#include "tests/scenario/overlaps.h"
#include "tests/scenario/solid_geometry.h"

#include <algorithm>

namespace zoned::bench {

namespace {

/// Lowest point of the surfaces less this: what is lower has fallen through or off.
constexpr double kFallen = 5.0;  // m
/// Frames between measurements of overlaps.
constexpr int kLookEvery = 100;

class HullMeter : public Meter {
  public:
    explicit HullMeter(const scenario::Description& description) : description_(description) {
        for (const scenario::Body& body : description.bodies) {
            if (body.mass == 0.0) {
                for (const Vec3d& p : body.solid.geometry->points) {
                    lowest_ = std::min(lowest_, p.y());
                }
            }
        }
    }

    void after_step(const Simulator& simulator) override {
        if (++steps_ % kLookEvery == 0) {
            look(simulator);
        }
    }

    void finish(const Simulator& simulator, Row& row) override {
        if (depths_.empty()) {
            look(simulator);
        }
        int escaped = 0;
        for (std::size_t i = 0; i < description_.bodies.size(); ++i) {
            const Motion m = simulator.motion(i);
            const bool gone = !is_finite(m) || m.pose.position.y() < lowest_ - kFallen;
            escaped += description_.bodies[i].mass > 0.0 && gone ? 1 : 0;
        }
        row.error = mean(depths_);
        row.error_unit = "m";
        row.metric("overlap_m_mean", mean(depths_));
        row.metric("overlap_m_p99", quantile(depths_, 0.99));
        row.metric("overlap_m_max", largest(depths_));
        row.metric("overlaps", static_cast<double>(depths_.size()));
        row.metric("speed_mps_max", sums_now(description_, simulator).fastest);
        row.metric("escaped", escaped);
    }

  private:
    /// Overlaps of pairs of bodies, and of bodies with the surfaces, as they are now.
    void look(const Simulator& simulator) {
        std::vector<scenario::Pose> poses;
        for (std::size_t i = 0; i < description_.bodies.size(); ++i) {
            poses.push_back(simulator.motion(i).pose);
        }
        const scenario::Overlaps found = scenario::find_overlaps(description_.bodies, poses);
        depths_.insert(depths_.end(), found.pairs.begin(), found.pairs.end());
        depths_.insert(depths_.end(), found.fixed.begin(), found.fixed.end());
    }

    scenario::Description description_;
    double lowest_ = INFINITY;
    std::vector<double> depths_;
    int steps_ = 0;
};

/// Keeps no copy of a million bodies: balls are the last ones.
class StaticFieldMeter : public Meter {
  public:
    explicit StaticFieldMeter(const scenario::Description& description)
        : bodies_(description.bodies.size()) {
        for (const scenario::Body& body : description.bodies) {
            boxes_ += body.mass == 0.0 ? 1 : 0;
        }
    }

    void after_step(const Simulator& /*simulator*/) override {}

    void finish(const Simulator& simulator, Row& row) override {
        double awake = 0.0;
        double off = 0.0;
        for (std::size_t i = boxes_; i < bodies_; ++i) {
            const Motion m = simulator.motion(i);
            awake += m.asleep ? 0.0 : 1.0;
            off = std::max(off, is_finite(m) ? std::abs(m.pose.position.y() - 0.5) : INFINITY);
        }
        row.error = off;
        row.error_unit = "m";
        row.metric("awake", awake);
        row.metric("bytes_per_body", simulator.heap_bytes() / static_cast<double>(bodies_));
    }

  private:
    std::size_t bodies_;
    std::size_t boxes_ = 0;
};

}  // namespace

std::unique_ptr<Meter> hull_meter(const scenario::Description& description) {
    return std::make_unique<HullMeter>(description);
}

std::unique_ptr<Meter> static_field_meter(const scenario::Description& description) {
    return std::make_unique<StaticFieldMeter>(description);
}

}  // namespace zoned::bench

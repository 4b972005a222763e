#include "server/replication/volatility.h"

namespace zoned::replication {

namespace {

using motion::PredictorOrder;

// What one publication of each order costs, relative to each other: higher orders carry more
// fields. The share of a packet's headers is in all of them, hence the small differences.
constexpr std::array<float, motion::kPredictorOrders> kCost = {1.0F, 1.1F, 1.2F};
// Payments fade with a time constant of 64 ticks, about two seconds.
constexpr float kKeep = 1.0F - 1.0F / 64.0F;
// Another order must be this much cheaper before it replaces the present one.
constexpr float kAdvantage = 0.85F;

}  // namespace

float elapsed_seconds(Tick from, Tick now, float tick_s) {
    return static_cast<float>(now - from) * tick_s;
}

bool leaves_bound(const motion::KinematicState& from,
                  PredictorOrder order,
                  float elapsed_s,
                  const motion::KinematicState& truth,
                  const LodBound& bound) {
    const Vec3 error = motion::predict_position(from, order, elapsed_s) - truth.position;
    // Written so that a truth that is not a number counts as outside.
    if (!(error.squaredNorm() <= bound.position_m * bound.position_m)) {
        return true;
    }
    const Quat turned = motion::predict_orientation(from, order, elapsed_s);
    if (turned.coeffs() == truth.orientation.coeffs()) {
        return false;
    }
    return !(motion::angle_between(turned, truth.orientation) <= bound.orientation_rad);
}

void Volatility::restart(Tick now, const motion::KinematicState& truth) {
    for (std::size_t order = 0; order < processes_.size(); ++order) {
        // Until experience says otherwise, constant velocity is the best guess.
        processes_[order] = {truth, now, order == 1 ? 0.0F : 0.2F};
    }
    best_ = PredictorOrder::kLinear;
}

void Volatility::observe(Tick now,
                         const motion::KinematicState& truth,
                         bool upright,
                         const LodBound& bound,
                         const Settings& settings) {
    for (std::size_t i = 0; i < processes_.size(); ++i) {
        Process& process = processes_[i];
        const auto order = static_cast<PredictorOrder>(i);
        process.cost *= kKeep;
        if (leaves_bound(process.from,
                         order,
                         elapsed_seconds(process.tick, now, settings.tick_s),
                         truth,
                         bound)) {
            const wire::QuantizedState sent =
                wire::quantize(truth, order, upright, false, 0, settings.quantization);
            process.from = wire::dequantize(sent, upright, settings.quantization);
            process.tick = now;
            process.cost += kCost[i];
        }
    }
    choose();
}

void Volatility::choose() {
    for (std::size_t i = 0; i < processes_.size(); ++i) {
        if (processes_[i].cost < kAdvantage * processes_[static_cast<std::size_t>(best_)].cost) {
            best_ = static_cast<PredictorOrder>(i);
        }
    }
}

}  // namespace zoned::replication

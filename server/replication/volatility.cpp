#include "server/replication/volatility.h"

#include "server/replication/landing.h"

#include <algorithm>

namespace zoned::replication {

namespace {

using motion::PredictorOrder;

// The cost of one publication of each kind, relative to one of order 1. It is the bytes of a record
// (12, 19, 25, 16 and 27 in the mean over the traces of `zoned-bench replication`) plus some 20 as
// its share of a packet's headers.
constexpr std::array<float, motion::kPredictorOrders> kCost = {0.82F, 1.0F, 1.15F, 0.92F, 1.2F};
// Payments fade with a time constant of 64 ticks, about two seconds.
constexpr float kKeep = 1.0F - 1.0F / 64.0F;
// Another order must be this much cheaper before it replaces the present one.
constexpr float kAdvantage = 0.85F;
// An entity that begins to fall will fall until it meets something: no experience is needed.
constexpr float kFallingCredit = 0.8F;

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

motion::KinematicState start_of(const Truth& truth,
                                PredictorOrder order,
                                const ReplicationSettings& settings) {
    motion::KinematicState from = truth.state;
    if (order == PredictorOrder::kTurning) {
        from.acceleration = truth.estimate->acceleration();
        from.turn = truth.estimate->turn();
    } else if (order == PredictorOrder::kBallistic) {
        from.acceleration = Vec3(0.0F, -settings.quantization.gravity_mps2, 0.0F);
        if (settings.ground) {
            from.floor = landing_height(
                *settings.ground, from, resting_height(*truth.type, from.orientation));
        }
    }
    return from;
}

bool suits(const MotionEstimate& estimate, PredictorOrder order) {
    switch (order) {
        case PredictorOrder::kBallistic:
            return estimate.falls();
        case PredictorOrder::kTurning:
            return estimate.turns();
        case PredictorOrder::kStatic:
        case PredictorOrder::kLinear:
        case PredictorOrder::kQuadratic:
            break;
    }
    return true;
}

PredictorOrder fitting(const MotionEstimate& estimate, PredictorOrder order) {
    if (suits(estimate, order)) {
        return order;
    }
    return order == PredictorOrder::kTurning ? PredictorOrder::kQuadratic : PredictorOrder::kLinear;
}

void Volatility::restart(Tick now, const motion::KinematicState& truth) {
    for (std::size_t i = 0; i < processes_.size(); ++i) {
        // Until experience says otherwise, constant velocity is the best guess.
        const auto order = static_cast<PredictorOrder>(i);
        processes_[i] = {truth,
                         now,
                         order == PredictorOrder::kLinear ? 0.0F : 0.2F,
                         order <= PredictorOrder::kQuadratic};
    }
    best_ = PredictorOrder::kLinear;
}

void Volatility::begin(Process& process,
                       Tick now,
                       const Truth& truth,
                       PredictorOrder order,
                       bool upright,
                       const wire::Quantization& quantization,
                       const ReplicationSettings& settings) {
    const wire::QuantizedState sent =
        wire::quantize(start_of(truth, order, settings), order, upright, false, 0, quantization);
    process.from = wire::dequantize(sent, upright, quantization);
    process.tick = now;
    process.live = true;
}

void Volatility::observe(Tick now,
                         const Truth& truth,
                         bool upright,
                         const LodBound& bound,
                         const wire::Quantization& quantization,
                         const ReplicationSettings& settings) {
    for (std::size_t i = 0; i < processes_.size(); ++i) {
        Process& process = processes_[i];
        const auto order = static_cast<PredictorOrder>(i);
        process.cost *= kKeep;
        const bool suited = suits(*truth.estimate, order);
        if (!process.live) {
            if (!suited) {
                continue;
            }
            const float par = processes_[static_cast<std::size_t>(best_)].cost;
            process.cost = order == PredictorOrder::kBallistic ? kFallingCredit * par
                                                               : std::max(process.cost, par);
            begin(process, now, truth, order, upright, quantization, settings);
            continue;
        }
        if (leaves_bound(process.from,
                         order,
                         elapsed_seconds(process.tick, now, settings.tick_s),
                         truth.state,
                         bound)) {
            process.cost += kCost[i];
            process.live = suited;
            if (suited) {
                begin(process, now, truth, order, upright, quantization, settings);
            }
        }
    }
    choose(*truth.estimate);
}

void Volatility::choose(const MotionEstimate& estimate) {
    const auto cost = [&](PredictorOrder order) {
        return processes_[static_cast<std::size_t>(order)].cost;
    };
    best_ = fitting(estimate, best_);
    for (std::size_t i = 0; i < processes_.size(); ++i) {
        const auto order = static_cast<PredictorOrder>(i);
        if (processes_[i].live && suits(estimate, order) &&
            cost(order) < kAdvantage * cost(best_)) {
            best_ = order;
        }
    }
}

}  // namespace zoned::replication

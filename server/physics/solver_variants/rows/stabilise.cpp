#include "server/physics/solver_variants/rows/stabilise.h"

#include <algorithm>
#include <numbers>

namespace zoned::physics {

namespace {

/// Joints that are torn apart (a body that was teleported) come back no faster than this, m/s.
constexpr double kJointSpeed = 20.0;

/// The part of an overlap to undo.
double excess_of(const VariantSettings& settings, double gap) {
    return std::min(gap + static_cast<double>(settings.slop_m), 0.0);
}

void soften(const VariantSettings& settings, double h, double most, std::size_t i, RowSystem& s) {
    const double omega = 2.0 * std::numbers::pi * static_cast<double>(settings.soft_hz);
    const double mass = s.response[i] > 0.0 ? 1.0 / s.response[i] : 0.0;
    const double k = mass * omega * omega;
    const double c = 2.0 * mass * static_cast<double>(settings.soft_damping_ratio) * omega;
    const double both = h * (c + h * k);
    if (both > 0.0) {
        s.soft[i] = 1.0 / both;
        s.bias[i] = std::clamp(s.gap[i] * h * k / both, -most, most);
    }
}

}  // namespace

void stabilise_contact(const VariantSettings& settings,
                       double h,
                       std::size_t i,
                       RowSystem& system) {
    const double gap = system.gap[i];
    const auto most = static_cast<double>(settings.push_speed_mps);
    if (gap >= 0.0) {
        system.bias[i] = gap / h;
        return;
    }
    system.undoes[i] = 1;
    switch (settings.stabilisation) {
        case Stabilisation::kBaumgarte:
            system.bias[i] =
                std::max(static_cast<double>(settings.beta) * excess_of(settings, gap) / h, -most);
            break;
        case Stabilisation::kSoft:
            soften(settings, h, most, i, system);
            break;
        case Stabilisation::kSplit:
            system.bias[i] = 0.0;
            break;
    }
}

void stabilise_joint(const VariantSettings& settings,
                     double h,
                     bool limit,
                     std::size_t i,
                     RowSystem& system) {
    const double error = system.gap[i];
    if (limit && error >= 0.0) {
        system.bias[i] = error / h;
        return;
    }
    system.undoes[i] = 1;
    switch (settings.stabilisation) {
        case Stabilisation::kBaumgarte:
            system.bias[i] = std::clamp(
                static_cast<double>(settings.beta) * error / h, -kJointSpeed, kJointSpeed);
            break;
        case Stabilisation::kSoft:
            soften(settings, h, kJointSpeed, i, system);
            break;
        case Stabilisation::kSplit:
            system.bias[i] = 0.0;
            break;
    }
}

void ask_for_positions(const VariantSettings& settings, double h, RowSystem& system) {
    const auto beta = static_cast<double>(settings.beta);
    for (std::size_t i = 0; i < system.size(); ++i) {
        const bool contact = system.role[i] == RowRole::kNormal;
        const double most = contact ? static_cast<double>(settings.push_speed_mps) : kJointSpeed;
        system.lambda[i] = 0.0;
        system.soft[i] = 0.0;
        system.bias[i] = 0.0;
        if (system.undoes[i] != 0) {
            const double error = contact ? excess_of(settings, system.gap[i]) : system.gap[i];
            system.bias[i] = std::clamp(beta * error / h, -most, most);
        } else if (contact) {
            system.bias[i] = std::max(system.gap[i], 0.0) / h;
        } else {
            system.low[i] = system.high[i] = 0.0;
            system.friction[i] = 0.0;
        }
    }
}

BiasEnergy bias_energy(const RowSystem& system, std::span<const double> before) {
    BiasEnergy energy;
    for (std::size_t i = 0; i < system.size(); ++i) {
        if (system.undoes[i] != 0) {
            const double work = 0.5 * system.lambda[i] * (before[i] + system.speed(i));
            (work > 0.0 ? energy.in : energy.out) += std::abs(work);
        }
    }
    return energy;
}

}  // namespace zoned::physics

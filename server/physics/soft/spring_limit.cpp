#include "server/physics/soft/spring_limit.h"

#include "server/physics/integrator/stability.h"
#include "server/physics/soft/volume.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

/// How much longer than at first everything may have become, for derivatives of volumes.
constexpr double kLonger = 1.25;

/// The bound of a sum of rank-one elements: shares first, then each element with its masses.
class ElementBound {
  public:
    explicit ElementBound(SoftBody& body) : body_(body), share_(body.limit.share) {
        share_.assign(body.x.size(), 0.0);
    }

    /// Of an element with the stiffness k and the derivatives g at the nodes.
    template <class Nodes, class Sizes>
    void deal(double k, const Nodes& nodes, const Sizes& g) {
        double sum = 0.0;
        for (std::size_t i = 0; i < std::size(nodes); ++i) {
            sum += inverse_mass(nodes[i]) > 0.0 ? g[i] : 0.0;
        }
        for (std::size_t i = 0; i < std::size(nodes); ++i) {
            share_[nodes[i]] += k * g[i] * sum;
        }
    }

    /// After all have been dealt: the element's own eigenvalue.
    template <class Nodes, class Sizes>
    void judge(const Nodes& nodes, const Sizes& g) {
        double sum = 0.0;
        double weighted = 0.0;
        for (std::size_t i = 0; i < std::size(nodes); ++i) {
            const double per_mass = inverse_mass(nodes[i]);
            sum += per_mass > 0.0 ? g[i] : 0.0;
            weighted += g[i] * share_[nodes[i]] * per_mass;
        }
        most_ = std::max(most_, sum > 0.0 ? weighted / sum : 0.0);
    }

    [[nodiscard]] double most() const { return most_; }

  private:
    [[nodiscard]] double inverse_mass(std::uint32_t node) const {
        return static_cast<double>(body_.x[node].w());
    }

    const SoftBody& body_;
    std::vector<double>& share_;
    double most_ = 0.0;
};

constexpr std::array<double, 2> kUnit{1.0, 1.0};

double damper_bound(SoftBody& body) {
    ElementBound bound(body);
    for (const Spring& s : body.springs) {
        bound.deal(s.alive ? static_cast<double>(s.damping) : 0.0, std::array{s.a, s.b}, kUnit);
    }
    for (const Spring& s : body.springs) {
        if (s.alive && s.damping > 0.0F) {
            bound.judge(std::array{s.a, s.b}, kUnit);
        }
    }
    return bound.most();
}

std::array<double, 4> volume_sizes(const SoftBody& body, std::size_t tetrahedron) {
    const std::array<Vec3d, 4> p = body.corners(tetrahedron);
    const auto g = tetrahedron_gradient(p[0], p[1], p[2], p[3]);
    constexpr double kWider = kLonger * kLonger;
    return {kWider * g[0].norm(), kWider * g[1].norm(), kWider * g[2].norm(), kWider * g[3].norm()};
}

/// How stiff the gas is; sizes of the derivatives of its volume by the nodes of its surface go to
/// `body.limit.sizes`.
double gas_stiffness(SoftBody& body) {
    body.limit.sizes.clear();
    if (body.gas <= 0.0) {
        return 0.0;
    }
    const double volume = std::max(enclosed_volume(body, &body.gradient), least_gas_volume(body));
    for (const std::uint32_t i : body.surface) {
        body.limit.sizes.push_back(kLonger * kLonger * body.gradient[i].norm());
    }
    return body.gas / (volume * volume);
}

/// Gershgorin's row sums of the surplus pressure times the second derivatives of the volume: a
/// face's block between its corners a and b is the cross product with (c - a) / 6.
double turning_bound(SoftBody& body) {
    if (body.gas <= 0.0) {
        return 0.0;
    }
    const double volume = std::max(enclosed_volume(body, nullptr), least_gas_volume(body));
    const double surplus =
        std::abs(body.gas / volume - static_cast<double>(body.material.ambient_pressure));
    std::vector<double>& row = body.limit.share;
    row.assign(body.x.size(), 0.0);
    for (const SoftFace& f : body.faces) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 at = body.position(f[k]);
            row[f[k]] += kLonger * surplus / 6.0 *
                         static_cast<double>((body.position(f[(k + 1) % 3]) - at).norm() +
                                             (body.position(f[(k + 2) % 3]) - at).norm());
        }
    }
    double most = 0.0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        most = std::max(most, row[i] * static_cast<double>(body.x[i].w()));
    }
    return most;
}

double stiffness_bound(SoftBody& body) {
    ElementBound bound(body);
    const bool volumes = body.material.bulk_modulus > 0.0F;
    const double gas = gas_stiffness(body);
    for (const Spring& s : body.springs) {
        bound.deal(s.alive ? static_cast<double>(s.stiffness) : 0.0, std::array{s.a, s.b}, kUnit);
    }
    for (std::size_t i = 0; volumes && i < body.tetrahedra.size(); ++i) {
        const double k = static_cast<double>(body.material.bulk_modulus) /
                         static_cast<double>(body.rest_volume[i]);
        bound.deal(k, body.tetrahedra[i], volume_sizes(body, i));
    }
    bound.deal(gas, body.surface, body.limit.sizes);
    for (const Spring& s : body.springs) {
        if (s.alive) {
            bound.judge(std::array{s.a, s.b}, kUnit);
        }
    }
    for (std::size_t i = 0; volumes && i < body.tetrahedra.size(); ++i) {
        bound.judge(body.tetrahedra[i], volume_sizes(body, i));
    }
    bound.judge(body.surface, body.limit.sizes);
    return bound.most() + turning_bound(body);
}

}  // namespace

double SpringLimit::omega() const {
    return std::sqrt(omega2);
}

double SpringLimit::damping_ratio() const {
    return omega2 > 0.0 ? damping / (2.0 * omega()) : 0.0;
}

double SpringLimit::step_s() const {
    return omega2 > 0.0
               ? stability_limit(IntegratorKind::kSemiImplicitEuler, omega(), damping_ratio())
                     .step_s
               : StabilityLimit::kAny;
}

SpringLimit spring_limit(SoftBody& body) {
    return {stiffness_bound(body), damper_bound(body)};
}

SpringLimit spring_limit(const SoftDef& def) {
    SoftBody body = make_body(def);
    return spring_limit(body);
}

void limit_step(SoftBody& body) {
    if (body.solver.method == SoftMethod::kSemiImplicitEuler) {
        body.limit.longest_step_s = spring_limit(body).step_s();
    }
}

std::string why_unstable(const SoftDef& def, float dt) {
    if (def.solver.method != SoftMethod::kSemiImplicitEuler) {
        return {};
    }
    if (!(dt > 0.0F)) {
        return "semi_implicit_euler: springs cannot be judged: nobody says how long steps are";
    }
    const SpringLimit limit = spring_limit(def);
    const int most = def.solver.substeps > 0 ? def.solver.substeps : kMostSubsteps;
    const double h = static_cast<double>(dt) / most;
    if (h <= limit.step_s()) {
        return {};
    }
    return why_unstable(
               IntegratorKind::kSemiImplicitEuler, limit.omega(), limit.damping_ratio(), h) +
           ": " + std::to_string(most) + " substeps are too few";
}

}  // namespace zoned::physics::soft

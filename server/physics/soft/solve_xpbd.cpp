// build: hot loops
// XPBD with one pass of Gauss-Seidel per substep: Macklin, Mueller, Chentanez, "XPBD:
// Position-Based Simulation of Compliant Constrained Dynamics" (2016), equation 26 for the damped
// multiplier; Macklin et al., "Small Steps in Physics Simulation" (2019) for substeps instead of
// iterations: the multipliers of a substep begin at zero and need not be kept.
#include "server/compute/team.h"
#include "server/physics/simd/node_lanes.h"
#include "server/physics/soft/soft_body.h"
#include "server/physics/soft/volume.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

constexpr std::size_t kGrain = 32;  // batches: about two microseconds

[[gnu::always_inline]] inline Lanes eight(const std::array<float, kLanes>& a) {
    return load(a.data());
}

/// C = length - rest; moves both ends along the spring by their inverse masses.
template <bool kDamped>
void solve_batches(SoftBody& body, std::span<const SpringBatch> batches, float h) {
    const Lanes per_h2 = lanes(1.0F / (h * h));
    const Lanes per_h = lanes(1.0F / h);
    for (const SpringBatch& batch : batches) {
        NodeLanes a = load_nodes(body.x.data(), batch.a);
        NodeLanes b = load_nodes(body.x.data(), batch.b);
        const Lanes dx = b.x - a.x;
        const Lanes dy = b.y - a.y;
        const Lanes dz = b.z - a.z;
        const Lanes length = max(sqrt(dx * dx + dy * dy + dz * dz), lanes(1.0e-9F));
        Lanes wrong = length - eight(batch.rest);
        Lanes mass = a.w + b.w;
        if constexpr (kDamped) {
            const NodeLanes p = load_nodes(body.start.data(), batch.a);
            const NodeLanes q = load_nodes(body.start.data(), batch.b);
            const Lanes gamma = eight(batch.lag) * per_h;
            const Lanes way =
                length - (dx * (q.x - p.x) + dy * (q.y - p.y) + dz * (q.z - p.z)) / length;
            wrong += gamma * way;
            mass *= lanes(1.0F) + gamma;
        }
        const Lanes push = -wrong / ((mass + eight(batch.compliance) * per_h2) * length);
        const Lanes pa = a.w * push;
        const Lanes pb = b.w * push;
        a.x -= pa * dx;
        a.y -= pa * dy;
        a.z -= pa * dz;
        b.x += pb * dx;
        b.y += pb * dy;
        b.z += pb * dz;
        store_nodes(body.x.data(), batch.a, a);
        store_nodes(body.x.data(), batch.b, b);
    }
}

void solve_springs(SoftBody& body, float h, compute::Team* team) {
    const auto solve = [&](std::span<const SpringBatch> batches) {
        if (body.batches.damped()) {
            solve_batches<true>(body, batches, h);
        } else {
            solve_batches<false>(body, batches, h);
        }
    };
    for (std::size_t c = 0; c < body.batches.colours(); ++c) {
        const std::span<const SpringBatch> all = body.batches.colour(c);
        if (team == nullptr) {
            solve(all);
        } else {
            team->run(all.size(), kGrain, [&](std::size_t begin, std::size_t end) {
                solve(all.subspan(begin, end - begin));
            });
        }
    }
}

/// C = V - V0 of each tetrahedron, energy K C^2 / (2 V0).
void solve_tetrahedra(SoftBody& body, float h) {
    const double modulus = static_cast<double>(body.material.bulk_modulus);
    if (modulus <= 0.0) {
        return;
    }
    const double h2 = static_cast<double>(h) * static_cast<double>(h);
    for (std::size_t i = 0; i < body.tetrahedra.size(); ++i) {
        const SoftTetrahedron& t = body.tetrahedra[i];
        const std::array<Vec3d, 4> p = body.corners(i);
        const auto g = tetrahedron_gradient(p[0], p[1], p[2], p[3]);
        const double rest = static_cast<double>(body.rest_volume[i]);
        const double volume = g[3].dot(p[3] - p[0]);
        double mass = 0.0;
        for (std::size_t k = 0; k < 4; ++k) {
            mass += static_cast<double>(body.x[t[k]].w()) * g[k].squaredNorm();
        }
        const double lambda = -(volume - rest) / (mass + rest / (modulus * h2));
        for (std::size_t k = 0; k < 4; ++k) {
            body.x[t[k]].head<3>() +=
                (static_cast<double>(body.x[t[k]].w()) * lambda * g[k]).cast<float>();
        }
    }
}

/// The gas pushes by q = p V / V - ambient along the gradient of V: the multiplier is q h^2 at the
/// end of the substep, found by Newton's method on q(V + w lambda) h^2 = lambda.
void solve_gas(SoftBody& body, float h) {
    if (body.gas <= 0.0) {
        return;
    }
    const double volume = enclosed_volume(body, &body.gradient);
    double mass = 0.0;
    for (const std::uint32_t i : body.surface) {
        mass += static_cast<double>(body.x[i].w()) * body.gradient[i].squaredNorm();
    }
    const double h2 = static_cast<double>(h) * static_cast<double>(h);
    const double ambient = static_cast<double>(body.material.ambient_pressure);
    // From V at its least upwards the function is convex and falls: Newton's steps from the left
    // never pass the root.
    double end = std::max(volume, 1.0e-12);
    for (int i = 0; i < 8; ++i) {
        const double q = body.gas / end - ambient;
        const double f = volume + mass * h2 * q - end;
        end = std::max(end + f / (1.0 + mass * h2 * body.gas / (end * end)), 0.5 * end);
    }
    const double lambda = h2 * (body.gas / end - ambient);
    for (const std::uint32_t i : body.surface) {
        body.x[i].head<3>() +=
            (static_cast<double>(body.x[i].w()) * lambda * body.gradient[i]).cast<float>();
    }
}

}  // namespace

void solve_xpbd(SoftBody& body, float h, compute::Team* team) {
    solve_springs(body, h, team);
    solve_tetrahedra(body, h);
    solve_gas(body, h);
}

}  // namespace zoned::physics::soft

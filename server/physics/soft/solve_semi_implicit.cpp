// Semi-implicit Euler for soft bodies ("symplectic Euler": Hairer, Lubich, Wanner, "Geometric
// Numerical Integration", I.1.2). Springs, tetrahedra and gas push by their state at the start of
// the substep. The nodes drift with the velocities that this gives (predict), gravity and drag
// exactly. One sweep over the springs and nothing to solve: the cheapest substep there is, up to
// the length that spring_limit.h names, and none beyond it.
#include "server/physics/simd/node_lanes.h"
#include "server/physics/soft/soft_body.h"
#include "server/physics/soft/volume.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

/// Impulses along the springs: stiffness by the length, damping by the speed at which it changes.
/// Ends of different springs of a batch are different nodes.
template <bool kDamped>
void push_batches(SoftBody& body, std::span<const SpringBatch> batches, float h) {
    const Lanes whole = lanes(h);
    for (const SpringBatch& batch : batches) {
        const NodeLanes a = load_nodes(body.x.data(), batch.a);
        const NodeLanes b = load_nodes(body.x.data(), batch.b);
        const Lanes dx = b.x - a.x;
        const Lanes dy = b.y - a.y;
        const Lanes dz = b.z - a.z;
        const Lanes length = max(sqrt(dx * dx + dy * dy + dz * dz), lanes(1.0e-9F));
        Lanes wrong = length - load(batch.rest.data());
        if constexpr (kDamped) {
            const NodeLanes p = load_nodes(body.v.data(), batch.a);
            const NodeLanes q = load_nodes(body.v.data(), batch.b);
            const Lanes rate = (dx * (q.x - p.x) + dy * (q.y - p.y) + dz * (q.z - p.z)) / length;
            wrong += load(batch.lag.data()) * rate;
        }
        const Lanes pull = whole * wrong / (load(batch.compliance.data()) * length);
        NodeLanes to_a = load_nodes(body.impulse.data(), batch.a);
        NodeLanes to_b = load_nodes(body.impulse.data(), batch.b);
        to_a.x += pull * dx;
        to_a.y += pull * dy;
        to_a.z += pull * dz;
        to_b.x -= pull * dx;
        to_b.y -= pull * dy;
        to_b.z -= pull * dz;
        store_nodes(body.impulse.data(), batch.a, to_a);
        store_nodes(body.impulse.data(), batch.b, to_b);
    }
}

/// -K (V - V0) / V0 along the derivatives of each volume.
void push_tetrahedra(SoftBody& body, double h) {
    const auto modulus = static_cast<double>(body.material.bulk_modulus);
    if (modulus <= 0.0) {
        return;
    }
    for (std::size_t i = 0; i < body.tetrahedra.size(); ++i) {
        const SoftTetrahedron& t = body.tetrahedra[i];
        const std::array<Vec3d, 4> p = body.corners(i);
        const auto g = tetrahedron_gradient(p[0], p[1], p[2], p[3]);
        const auto rest = static_cast<double>(body.rest_volume[i]);
        const double push = -h * modulus * (g[3].dot(p[3] - p[0]) - rest) / rest;
        for (std::size_t k = 0; k < 4; ++k) {
            body.impulse[t[k]].head<3>() += (push * g[k]).cast<float>();
        }
    }
}

/// The surplus of its pressure along the derivatives of the volume. Gas that would be pressed into
/// nothing pushes as it does at a thousandth of its volume.
void push_gas(SoftBody& body, double h) {
    if (body.gas <= 0.0) {
        return;
    }
    const double volume = std::max(enclosed_volume(body, &body.gradient), least_gas_volume(body));
    const double push =
        h * (body.gas / volume - static_cast<double>(body.material.ambient_pressure));
    for (const std::uint32_t i : body.surface) {
        body.impulse[i].head<3>() += (push * body.gradient[i]).cast<float>();
    }
}

}  // namespace

void push_springs(SoftBody& body, float h) {
    body.impulse.assign(body.x.size(), Row4::Zero());
    for (std::size_t c = 0; c < body.batches.colours(); ++c) {
        if (body.batches.damped()) {
            push_batches<true>(body, body.batches.colour(c), h);
        } else {
            push_batches<false>(body, body.batches.colour(c), h);
        }
    }
    push_tetrahedra(body, static_cast<double>(h));
    push_gas(body, static_cast<double>(h));
    // The fourth number of an impulse is zero, as a velocity's is.
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        body.v[i] += body.x[i].w() * body.impulse[i];
    }
}

}  // namespace zoned::physics::soft

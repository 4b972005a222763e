// Contact persistence: carries the state of a contact over from the last step as its points travel.
#pragma once

#include "server/physics/contacts/contact_graph.h"

namespace zoned::physics {

/// Takes the points of a manifold, and the impulses over from the `old_count` points of the last
/// step: from the one that names the same features, else from the nearest. `xa` and `xb` are the
/// centres of the bodies at the time of the manifold.
void adopt_points(const Manifold& manifold,
                  const Vec3& xa,
                  const Vec3& xb,
                  std::size_t old_count,
                  Contact& contact);

/// With which body the point of contact travels within a step, as b's share. A round body takes it
/// along wherever it rolls; between two round ones it lies on the line of centres; on the unmoving
/// world it goes with the body that moves. Any choice conserves momentum: the point is one and the
/// same for both bodies.
float share_of_b(const Shape& a, const Shape& b, bool a_moves, bool b_moves);

/// How a pair has moved since its manifolds were found.
struct PairShift {
    Vec3 shift = Vec3::Zero();   ///< of b relative to a, m
    Vec3 turn_a = Vec3::Zero();  ///< rotation vectors, to first order
    Vec3 turn_b = Vec3::Zero();
};

/// The gaps of points that stay where they are, to first order.
void follow_gaps(const PairShift& moved, std::size_t count, Contact& contact);

/// The least separation of the points of a contact and of its chain, m; infinite without points.
float lowest_gap(const ContactGraph& graph, std::uint32_t contact);

struct ChainRecords {
    std::array<std::uint32_t, kMaxPairManifolds> records{};
    std::size_t count = 0;
};

/// Makes the chain of a contact match these manifolds, one record each in their order: the record
/// of the same parts, else the one of the most similar normal, else a new one. Their points are not
/// filled in.
ChainRecords match_chain(ContactGraph& graph,
                         std::uint32_t contact,
                         const std::vector<PartManifold>& manifolds);

}  // namespace zoned::physics

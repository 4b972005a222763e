#include "server/physics/contacts/contact_persistence.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Two points of one contact that lie closer than this in successive steps are one, m.
constexpr float kSamePoint = 0.05F;
/// Normals farther apart (26 degrees) are no longer those of the same contact.
constexpr float kSimilarNormal = 0.9F;

}  // namespace

float share_of_b(const Shape& a, const Shape& b, bool a_moves, bool b_moves) {
    const bool a_round = a.kind == ShapeKind::kSphere || a.kind == ShapeKind::kCapsule;
    const bool b_round = b.kind == ShapeKind::kSphere || b.kind == ShapeKind::kCapsule;
    if (a_round && b_round) {
        return a.radius / (a.radius + b.radius);
    }
    if (a_round != b_round) {
        return b_round ? 1.0F : 0.0F;
    }
    return a_moves == b_moves ? 0.5F : (b_moves ? 1.0F : 0.0F);
}

/// Boxes that lie corner on corner change the names of their points with every breath, and a stack
/// that forgets its load each time sags and walks; so points without a name that is known look for
/// the nearest.
void adopt_points(const Manifold& manifold,
                  const Vec3& xa,
                  const Vec3& xb,
                  std::size_t old_count,
                  Contact& contact) {
    const std::array<ContactPoint, kMaxManifoldPoints> old = contact.points;
    std::array<bool, kMaxManifoldPoints> taken{};
    std::array<bool, kMaxManifoldPoints> served{};
    const auto count = static_cast<std::size_t>(manifold.count);
    for (std::size_t i = 0; i < count; ++i) {
        const ManifoldPoint& from = manifold.points[i];
        ContactPoint& to = contact.points[i];
        to = {
            from.point - xa, from.point - xb, from.separation, from.separation, 0.0F, from.feature};
        for (std::size_t k = 0; k < old_count; ++k) {
            if (!taken[k] && old[k].feature == from.feature) {
                to.impulse = old[k].impulse;
                taken[k] = true;
                served[i] = true;
                break;
            }
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        if (served[i]) {
            continue;
        }
        std::size_t best = kMaxManifoldPoints;
        float least = kSamePoint * kSamePoint;
        for (std::size_t k = 0; k < old_count; ++k) {
            const float d = (old[k].arm_a - contact.points[i].arm_a).squaredNorm();
            if (!taken[k] && d < least) {
                least = d;
                best = k;
            }
        }
        if (best < kMaxManifoldPoints) {
            contact.points[i].impulse = old[best].impulse;
            taken[best] = true;
        }
    }
    if (manifold.count == 0) {
        contact.friction.setZero();
        contact.twist = 0.0F;
        contact.rolling.setZero();
    }
}

void follow_gaps(const PairShift& moved, std::size_t count, Contact& contact) {
    const float closing = contact.normal.dot(moved.shift);
    for (std::size_t i = 0; i < count; ++i) {
        ContactPoint& p = contact.points[i];
        p.separation =
            p.found_separation + closing +
            contact.normal.dot(moved.turn_b.cross(p.arm_b) - moved.turn_a.cross(p.arm_a));
    }
}

float lowest_gap(const ContactGraph& graph, std::uint32_t contact) {
    float lowest = INFINITY;
    graph.for_chain(contact, [&](std::uint32_t record) {
        for (std::size_t i = 0; i < graph.pair(record).points(); ++i) {
            lowest = std::min(lowest, graph[record].points[i].separation);
        }
    });
    return lowest;
}

ChainRecords match_chain(ContactGraph& graph,
                         std::uint32_t contact,
                         const std::vector<PartManifold>& manifolds) {
    std::array<std::uint32_t, kMaxPairManifolds> old{};
    std::size_t left = 0;
    for (std::uint32_t at = graph[contact].chain; at != kNoIndex; at = graph[at].chain) {
        old[left++] = at;
    }
    ChainRecords out;
    out.count = manifolds.size();
    out.records.fill(kNoIndex);
    const auto take = [&](std::size_t i, std::size_t k) {
        out.records[i] = old[k];
        old[k] = old[--left];
    };
    for (std::size_t i = 0; i < out.count; ++i) {
        for (std::size_t k = 0; k < left; ++k) {
            if (graph[old[k]].part == manifolds[i].key) {
                take(i, k);
                break;
            }
        }
    }
    for (std::size_t i = 0; i < out.count; ++i) {
        if (out.records[i] != kNoIndex) {
            continue;
        }
        std::size_t best = left;
        float closest = kSimilarNormal;
        for (std::size_t k = 0; k < left; ++k) {
            const float d = graph[old[k]].normal.dot(manifolds[i].manifold.normal);
            if (d > closest) {
                closest = d;
                best = k;
            }
        }
        if (best < left) {
            take(i, best);
        } else {
            out.records[i] = graph.make_record(graph.pair(contact).a, graph.pair(contact).b);
        }
    }
    for (std::size_t k = 0; k < left; ++k) {
        graph.drop_record(old[k]);
    }
    std::uint32_t at = contact;
    for (std::size_t i = 0; i < out.count; ++i) {
        graph[at].chain = out.records[i];
        at = out.records[i];
        graph[at].part = manifolds[i].key;
    }
    graph[at].chain = kNoIndex;
    return out;
}

}  // namespace zoned::physics

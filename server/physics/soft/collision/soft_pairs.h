// SoftPairs: which soft bodies meet in a step, and how they push each other.
#pragma once

#include "server/physics/soft/soft_body.h"
#include "server/spatial/sort_and_sweep.h"

#include <span>
#include <vector>

namespace zoned::physics::soft {

/// A face of one body that a node of another may come to within the step.
struct NearFace {
    std::uint32_t face;
    float side;  ///< 1: the node belongs in front; -1: behind; 0: the face is a segment
};

/// A node of one body with the faces of another that it may come to.
struct SkinNode {
    std::uint32_t body, other, node;
    std::uint32_t first, end;  ///< near faces
    bool inside;               ///< it began within the other body: its one face leads out
};

/// Two bodies, a < b, of which nodes may come to faces.
struct SoftPair {
    std::uint32_t island;
    std::uint32_t a, b;
    std::uint32_t first, end;  ///< skin nodes, of both ways

    auto operator<=>(const SoftPair&) const = default;
};

/// Bodies that push each other, or one body alone. Islands share no body that moves.
struct SoftIsland {
    std::uint32_t first_member, end_member;
    std::uint32_t first_pair, end_pair;
    float fastest;  ///< at which a node comes to a face, m/s
    float least;    ///< distance that two bodies keep, m
};

/// Contacts between the skins of soft bodies, node against face, both ways. Faces near a node are
/// looked for once a step; in each substep, after springs and volumes, the nearest of them keeps
/// the node off at the sum of both thicknesses: a unilateral constraint of position between one
/// node and three, as Mueller et al. have it for cloth against itself ("Position Based Dynamics",
/// 2007), with Coulomb friction on the distance of the substep (Macklin et al., "Unified particle
/// physics for real-time applications", 2014, section 6.1). Momentum stays, as the node and the
/// face get opposite impulses by weights that sum to one.
///
/// A node that crosses a face within a substep is put back to the side that it came from. A node
/// that lies within a closed skin at the start of a step leaves by the nearest face. An overlap
/// from before parts without speed, apart from the inelastic end of the approach (compare the
/// repulsion of Bridson et al., "Robust Treatment of Collisions, Contact and Friction for Cloth
/// Animation", 2002).
///
/// A body whose nodes swing faster than a substep resolves (omega h far above 1) may gain energy
/// where it strikes: of 1,000 random pairs one did, a stiff rope.
///
/// Edges are not tested against edges. Ropes and the rims of sheets may cross each other where
/// their nodes lie farther apart than twice the distance that two bodies keep. An edge of a closed
/// body may cut into a face between the nodes of both.
class SoftPairs {
  public:
    /// Finds what may meet within `dt` s and puts bodies that move into islands. A body asleep that
    /// one in motion touches wakes. Bodies that are gone, rigid or collide with nothing stay out.
    void find(std::span<SoftBody> bodies, const Vec3& gravity, float dt);

    [[nodiscard]] std::span<const SoftIsland> islands() const { return islands_; }

    /// Indices of bodies, ascending.
    [[nodiscard]] std::span<const std::uint32_t> members(const SoftIsland& island) const {
        return std::span(members_).subspan(island.first_member,
                                           island.end_member - island.first_member);
    }

    /// So many substeps that no node comes farther than the distance which two bodies keep.
    [[nodiscard]] int substeps(const SoftIsland& island, float dt) const;

    /// The constraints of one substep, after those within the bodies and before `finish`. Returns
    /// how many nodes were held off.
    std::uint32_t solve(std::span<SoftBody> bodies, const SoftIsland& island, float h) const;

  private:
    void find_overlaps(std::span<SoftBody> bodies, const Vec3& gravity, float dt);
    void search(std::span<SoftBody> bodies, SoftPair& pair, const Vec3& gravity, float dt);
    bool wake_touched(std::span<SoftBody> bodies) const;
    void build_islands(std::span<const SoftBody> bodies);
    void rate_island(std::span<const SoftBody> bodies, SoftIsland& island) const;

    spatial::SortAndSweep index_;  // of the boxes that bodies may sweep in the step
    std::vector<Aabb> boxes_;      // by body
    std::vector<std::uint32_t> moved_;
    std::vector<SoftPair> pairs_;
    std::vector<SkinNode> nodes_;
    std::vector<NearFace> faces_;
    std::vector<std::uint32_t> root_;  // by body: the least of its island
    std::vector<std::uint32_t> members_;
    std::vector<SoftIsland> islands_;
};

/// Appends the nodes of `body` that may come to faces of `other`, and those faces. Both skins fit
/// their nodes.
struct PairSearch {
    std::span<const SoftBody> bodies;
    float dt;
    float fall;  ///< by which gravity may lengthen a way, m
    std::vector<SkinNode>& nodes;
    std::vector<NearFace>& faces;

    void run(std::uint32_t body, std::uint32_t other);

  private:
    bool leave_inside(const SoftBody& other, const Vec3& x);
    void gather(const SoftBody& body, const SoftBody& other, std::uint32_t node, const Aabb& way);
};

/// Holds a node off the nearest of its faces. True where it pushed.
bool hold_off(std::span<SoftBody> bodies,
              const SkinNode& at,
              std::span<const NearFace> faces,
              float h);

}  // namespace zoned::physics::soft

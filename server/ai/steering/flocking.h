// Flocking: the heading of a herd animal from its neighbours.
#pragma once

#include "server/spatial/point_grid.h"
#include "server/world/entities.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace zoned::ai {

struct HerdDrift;

/// Distance under which herd animals turn away from each other, as a share of the flock's radius.
inline constexpr float kSeparationShare = 0.25F;

/// Of an animal in columns, along each axis, m/s.
inline constexpr float kFastestOfLanes = 100.0F;

/// Where an animal wants to go on its own account.
struct FlockPull {
    Vec2 home = Vec2::Zero();  ///< x, z, m
    /// Along a path, unit length; zero: it is drawn home instead.
    Vec2 path = Vec2::Zero();
    Vec2 heading = Vec2::Zero();  ///< own direction now: unit length, or zero when it stands
    float radius_m = 20.0F;       ///< who counts as a neighbour
    float speed = 1.0F;           ///< m/s, full speed of the gait, > 0
};

/// Separation, alignment and cohesion (Reynolds, "Flocks, herds, and schools: a distributed
/// behavioral model", SIGGRAPH 1987, as weighted sums) over the neighbours of one animal, plus a
/// pull towards home that grows with distance, or along a path, and some inertia. The sums are
/// integers, so that they do not depend on the order in which neighbours are added.
class FlockSum {
  public:
    /// What is farther than the radius is left out.
    explicit FlockSum(float radius_m) : radius_m_(radius_m) {}

    /// A neighbour at `offset` (x, z, m) with `velocity` (m/s); `older`: the animal has the smaller
    /// id.
    void add(const Vec2& offset, const Vec2& velocity, bool older);

    /// Animals in columns; the same numbers lie behind each.
    struct Columns {
        const float* x;  ///< m, at time 0; kLanes more may be read behind the end of any run
        const float* z;
        const float* velocity_x;  ///< m/s, of kFastestOfLanes at most
        const float* velocity_z;
        const EntityId* entity;
    };

    /// Those from `begin` to `end` but `self`, where they are `time_s` after time 0, eight at a
    /// time: the sums are those of add(), bit for bit.
    void add_run(const Columns& animals,
                 std::size_t begin,
                 std::size_t end,
                 std::size_t self,
                 const Vec2& here,
                 float time_s);

    /// Of an animal at `here` (x, z, m). Not normalised; may be zero.
    [[nodiscard]] Vec2 heading(const Vec2& here, const FlockPull& pull) const;

  private:
    /// A sum of vectors that is the same in every order of its terms.
    struct ExactSum {
        std::int64_t x = 0;
        std::int64_t z = 0;

        void add(const Vec2& v);

        /// In units of the sum.
        void add(std::int64_t add_x, std::int64_t add_z) {
            x += add_x;
            z += add_z;
        }

        [[nodiscard]] Vec2 value() const;
    };

    /// From a neighbour within the radius that is too near.
    void part(const Vec2& offset, bool older);

    float radius_m_;
    ExactSum apart_;
    ExactSum along_;
    ExactSum together_;
    int neighbours_ = 0;
};

/// The direction at `here` along the round trip of `stops` (1 or more): of the nearest piece,
/// turned towards it, by half a right angle at a distance of `width_m` (> 0) and by almost a right
/// one farther off, as pathfinding::along_path. One stop: towards it; zero within `width_m` of it.
Vec2 round_trip(std::span<const Vec2> stops, const Vec2& here, float width_m);

struct FlockQuery : FlockPull {
    world::Row self = world::kNoRow;
    const HerdDrift* drift = nullptr;  ///< of neighbours that doze; null: none does
};

/// Of an animal among the entities of its type. `grid` has at least where they were put last.
Vec2 flock_heading(const world::Entities& entities,
                   const spatial::PointGrid& grid,
                   const FlockQuery& query);

}  // namespace zoned::ai

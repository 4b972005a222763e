// Flocking: FlockSum computes the heading of a herd animal from its neighbours.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/spatial/point_grid.h"
#include "server/world/entities.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace zoned::ai {

struct HerdDrift;

/// Distance under which herd animals turn away from each other, as a share of the flock's radius.
inline constexpr float kSeparationShare = 0.25F;

/// The largest speed of an animal in columns, along each axis, m/s.
inline constexpr float kFastestOfLanes = 100.0F;

/// FlockPull: the direction in which an animal wants to go by itself.
struct FlockPull {
    Vec2 home = Vec2::Zero();  ///< x, z, m
    /// Along a path, unit length; zero: it is drawn home instead.
    Vec2 path = Vec2::Zero();
    Vec2 heading = Vec2::Zero();  ///< own direction now: unit length, or zero when it stands
    float radius_m = 20.0F;       ///< an animal within this radius counts as a neighbour
    float speed = 1.0F;           ///< m/s, full speed of the gait, > 0
    FlockWeights weights{};
};

/// Separation, alignment and cohesion over the neighbours of one animal, as weighted sums. Source:
/// Reynolds, "Flocks, herds, and schools: a distributed behavioral model", SIGGRAPH 1987. To these
/// come some inertia and a pull along a path, or a pull towards home that grows with distance. The
/// sums are integers, so they do not depend on the order in which neighbours are added.
class FlockSum {
  public:
    /// Animals beyond the radius are left out.
    explicit FlockSum(float radius_m) : radius_m_(radius_m) {}

    /// A neighbour at `offset` (x, z, m) with `velocity` (m/s); `older`: the animal has the smaller
    /// id.
    void add(const Vec2& offset, const Vec2& velocity, bool older);

    /// Animals in columns; the same index means the same animal in each.
    struct Columns {
        const float* x;  ///< m, at time 0; up to kLanes more values are read behind the end of a
                         ///< run
        const float* z;
        const float* velocity_x;  ///< m/s, at most kFastestOfLanes
        const float* velocity_z;
        const EntityId* entity;
    };

    /// Adds the animals from `begin` to `end`, except `self`, at their positions `time_s` after
    /// time 0. Eight are added at a time; the sums are bit for bit those of add().
    void add_run(const Columns& animals,
                 std::size_t begin,
                 std::size_t end,
                 std::size_t self,
                 const Vec2& here,
                 float time_s);

    /// The heading of an animal at `here` (x, z, m). Not normalised; may be zero.
    [[nodiscard]] Vec2 heading(const Vec2& here, const FlockPull& pull) const;

  private:
    /// A sum of vectors that is the same in every order of its terms.
    struct ExactSum {
        std::int64_t x = 0;
        std::int64_t z = 0;

        void add(const Vec2& v);

        /// In the units of the sum.
        void add(std::int64_t add_x, std::int64_t add_z) {
            x += add_x;
            z += add_z;
        }

        [[nodiscard]] Vec2 value() const;
    };

    /// Adds the separation from a neighbour within the radius that is too near.
    void part(const Vec2& offset, bool older);

    float radius_m_;
    ExactSum apart_;
    ExactSum along_;
    ExactSum together_;
    int neighbours_ = 0;
};

/// The direction at `here` along the round trip of `stops` (1 or more). It is the direction of the
/// nearest piece, turned towards that piece. The turn is half a right angle at a distance of
/// `width_m` (> 0) and almost a right angle farther off, as in physics::directions_along. With one
/// stop it points to the stop, and is zero within `width_m` of it.
Vec2 round_trip(std::span<const Vec2> stops, const Vec2& here, float width_m);

struct FlockQuery : FlockPull {
    world::Row self = world::kNoRow;
    const HerdDrift* drift = nullptr;  ///< positions of suspended neighbours; null: none is
                                       ///< suspended
};

/// The heading of an animal among the entities of its type. `grid` holds at least the positions at
/// which they were last put.
Vec2 flock_heading(const world::Entities& entities,
                   const spatial::PointGrid& grid,
                   const FlockQuery& query);

}  // namespace zoned::ai

// CapsuleSweep: how far an upright capsule can move in the static world, and the obstacle that
// stops it.
#pragma once

#include "shared/math/closest.h"
#include "shared/math/types.h"
#include "shared/motion/static_geometry.h"

#include <array>
#include <cstdint>
#include <limits>

namespace zoned::motion {

/// Upright capsule around its centre: all points within `radius` of the vertical segment of half
/// length `half_segment`, m.
struct Capsule {
    float radius = 0.4F;
    float half_segment = 0.5F;
};

/// Air that is kept between capsule and boxes, m: far more than the rounding of float coordinates
/// some kilometres from the origin, and far too little to be visible.
inline constexpr float kSkin = 0.001F;

/// Grazing moves may use up some of the skin; it is restored before it is gone.
inline constexpr float kLeastAir = 0.25F * kSkin;

/// The distance of the capsule's segment from a box, in the axes of the box, which are the columns
/// of `axes`.
SegmentBoxDistance distance_to(const Capsule& capsule,
                               const Vec3& position,
                               const StaticBox& box,
                               const Mat3& axes);

/// Whether a capsule is so far inside a box that CapsuleSweep::parted() moves it; columns of `axes`
/// are the box's.
bool overlaps(const Capsule& capsule, const Vec3& position, const StaticBox& box, const Mat3& axes);

inline constexpr std::uint32_t kNoPlatform = UINT32_MAX;

/// Platforms that a capsule passes through, because one has it squeezed.
struct PassedPlatforms {
    static constexpr std::size_t kMost = 8;

    std::array<std::uint32_t, kMost> number{};
    std::size_t count = 0;
    bool all = false;  ///< none is an obstacle

    /// All, where there are more than kMost.
    void add(std::uint32_t platform) {
        all = all || count == kMost;
        if (!all) {
            number[count++] = platform;
        }
    }

    [[nodiscard]] bool has(std::uint32_t platform) const {
        bool found = all;
        for (std::size_t i = 0; i < count; ++i) {
            found = found || number[i] == platform;
        }
        return found;
    }
};

/// The obstacle that a moving capsule hit.
struct SweepHit {
    float fraction = 1.0F;        ///< of the move that is free
    bool hit = false;             ///< false: all of it is free
    bool ground_plane = false;    ///< hit the ground plane, not a box or a surface
    Vec3 normal = Vec3::UnitY();  ///< unit, from the obstacle to the capsule
    /// Vertical part of the most upward normal among the faces that meet where the capsule was hit:
    /// distinguishes the rim of walkable ground from the rim of a wall.
    float face_up = 1.0F;
    std::uint32_t platform = kNoPlatform;  ///< that was hit
};

/// The static boxes near one character's tick, gathered once, and the surfaces there. No
/// allocation. Triangles are solid behind: a triangle whose front the capsule's centre does not see
/// is ignored.
class CapsuleSweep {
  public:
    /// `area` must hold all positions of the capsule in later calls, without its own size. Doors
    /// and platforms are as at `tick`, but for those that it passes (`passed` outlives this, null:
    /// none); kAllDoorsOpen: there are none.
    CapsuleSweep(const StaticGeometry& world,
                 const Capsule& capsule,
                 const Aabb& area,
                 Tick tick = kAllDoorsOpen,
                 const PassedPlatforms* passed = nullptr);

    /// The first obstacle on the path of the capsule's centre from `from` to `from + move`.
    /// Obstacles that the move only grazes (nears by less than 0.05 mm) or leaves do not count. The
    /// distance of a convex box and a capsule that moves along a line is a convex function of the
    /// distance moved, so Newton's iteration from the start never passes the first contact.
    [[nodiscard]] SweepHit sweep(const Vec3& from, const Vec3& move) const;

    /// As sweep() by `drop` metres straight down, but where several obstacles stop the capsule
    /// within a millimetre, one that `carries` is preferred.
    template <class Carries>
    [[nodiscard]] SweepHit sweep_down(const Vec3& from, float drop, Carries&& carries) const {
        const Vec3 move(0.0F, -drop, 0.0F);
        const SweepHit first = sweep(from, move);
        if (!first.hit || carries(first)) {
            return first;
        }
        SweepHit best = first;
        const float limit = first.fraction + kSkin / drop;
        const auto consider = [&](const SweepHit& other) {
            if (other.hit && other.fraction <= limit && carries(other)) {
                best = other;
                best.fraction = first.fraction;
                return true;
            }
            return false;
        };
        bool found = consider(sweep_ground(from, move));
        if (!found) {
            for_each_on_path(from, move, [&](std::uint32_t box) {
                found = consider(sweep_box(box, from, move));
                return found;
            });
        }
        if (!found && near_surfaces_) {
            found = consider(sweep_surfaces(from, move, carries));
        }
        if (!found && near_platforms_) {
            consider(sweep_platforms(from, move, carries));
        }
        return best;
    }

    /// `position`, moved out of boxes, surfaces and ground where the capsule overlaps them, but not
    /// out of platforms; out of doors by `most_of_doors` m at most. One that overlaps nothing is
    /// returned as it is.
    [[nodiscard]] Vec3 parted(Vec3 position,
                              float most_of_doors = std::numeric_limits<float>::infinity()) const;

    /// The height at which the capsule's centre rests on the ground plane.
    [[nodiscard]] float floor_height() const { return floor_height_; }

  private:
    [[nodiscard]] SweepHit sweep_ground(const Vec3& from, const Vec3& move) const;
    [[nodiscard]] SweepHit sweep_box(const StaticBox& box,
                                     const Mat3& axes,
                                     const Vec3& from,
                                     const Vec3& move) const;

    [[nodiscard]] SweepHit sweep_box(std::uint32_t box, const Vec3& from, const Vec3& move) const {
        return sweep_box(world_.box(box), world_.box_axes(box), from, move);
    }

    /// The first platform that the move hits, among hits that `counts` accepts.
    template <class Counts>
    [[nodiscard]] SweepHit sweep_platforms(const Vec3& from,
                                           const Vec3& move,
                                           Counts&& counts) const;
    /// `triangle` and the move in the triangle's own coordinates.
    [[nodiscard]] SweepHit sweep_triangle(const FacedTriangle& triangle,
                                          const Vec3& from,
                                          const Vec3& move) const;
    /// The first triangle that the move hits, among hits that `counts` accepts.
    template <class Counts>
    [[nodiscard]] SweepHit sweep_surfaces(const Vec3& from,
                                          const Vec3& move,
                                          Counts&& counts) const;
    /// Moves `position` out of the surfaces' triangles; true where it overlapped any.
    bool part_from_surfaces(Vec3& position) const;

    /// Calls `visit(surface, triangle)` for the triangles that the moving capsule may touch.
    template <class Visit>
    void for_each_triangle(const Vec3& from, const Vec3& move, Visit&& visit) const {
        const Vec3 to = from + move;
        const Aabb way{from.cwiseMin(to) - reach_, from.cwiseMax(to) + reach_};
        for (const PlacedSurface& placed : world_.surfaces()) {
            if (!placed.bounds().overlaps(way)) {
                continue;
            }
            const Vec3 a = placed.to_local(from);
            const Vec3 b = a + placed.turned_to_local(move);
            placed.surface().for_each_near({a.cwiseMin(b) - reach_, a.cwiseMax(b) + reach_},
                                           [&](const FacedTriangle& t) { visit(placed, t); });
        }
    }

    /// Calls `visit(box)` for each gathered box whose bounds the moving capsule may touch, until it
    /// returns true.
    template <class Visit>
    void for_each_on_path(const Vec3& from, const Vec3& move, Visit&& visit) const {
        const Vec3 to = from + move;
        const Aabb way{from.cwiseMin(to) - reach_, from.cwiseMax(to) + reach_};
        bool done = false;
        const auto step = [&](std::uint32_t box) {
            if (!done && world_.box_bounds(box).overlaps(way)) {
                done = visit(box);
            }
        };
        if (near_count_ <= near_.size()) {
            for (std::size_t i = 0; i < near_count_ && !done; ++i) {
                step(near_[i]);
            }
        } else {
            world_.for_each_near(way, tick_, step);  // too many to note: ask the grid each time
        }
    }

    const StaticGeometry& world_;
    Tick tick_;
    Capsule capsule_;
    Vec3 reach_;
    float floor_height_;
    bool near_surfaces_ = false;
    bool near_platforms_ = false;
    const PassedPlatforms* passed_ = nullptr;
    std::size_t near_count_ = 0;  // may exceed the array: then the array is not used
    std::array<std::uint32_t, 64> near_;
};

template <class Counts>
SweepHit CapsuleSweep::sweep_surfaces(const Vec3& from, const Vec3& move, Counts&& counts) const {
    // All triangles that meet where the capsule is hit define the surface there.
    constexpr float kSamePlace = 5e-5F;  // m along the move
    const float length = move.norm();
    SweepHit first;
    for_each_triangle(from, move, [&](const PlacedSurface& placed, const FacedTriangle& t) {
        SweepHit hit = sweep_triangle(t, placed.to_local(from), placed.turned_to_local(move));
        if (!hit.hit) {
            return;
        }
        hit.normal = placed.turned_to_world(hit.normal);
        if (!counts(hit)) {
            return;
        }
        const float behind = (hit.fraction - first.fraction) * length;
        if (first.hit && behind > -kSamePlace && behind < kSamePlace &&
            hit.normal.dot(first.normal) > 0.999F) {
            first.face_up = first.face_up > hit.face_up ? first.face_up : hit.face_up;
            first.fraction = first.fraction < hit.fraction ? first.fraction : hit.fraction;
        } else if (!first.hit || hit.fraction < first.fraction) {
            first = hit;
        }
    });
    return first;
}

template <class Counts>
SweepHit CapsuleSweep::sweep_platforms(const Vec3& from, const Vec3& move, Counts&& counts) const {
    const Vec3 to = from + move;
    const Aabb way{from.cwiseMin(to) - reach_, from.cwiseMax(to) + reach_};
    SweepHit first;
    world_.for_each_platform_near(way, [&](std::uint32_t number) {
        if (passed_ != nullptr && passed_->has(number)) {
            return;
        }
        SweepHit hit =
            sweep_box(world_.platform_box(number, tick_), world_.platform_axes(number), from, move);
        if (hit.hit && (!first.hit || hit.fraction < first.fraction) && counts(hit)) {
            hit.platform = number;
            first = hit;
        }
    });
    return first;
}

}  // namespace zoned::motion

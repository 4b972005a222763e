// StepTrial: whether a character stands at a place and walks from place to place, by trial.
#pragma once

#include "server/ai/pathfinding/grid/box_column.h"
#include "server/ai/pathfinding/grid/ground_grid.h"
#include "server/ai/pathfinding/grid/plan_rect.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/capsule_sweep.h"

#include <optional>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// The test is movement's own: motion::CapsuleSweep puts the capsule down, and motion::apply_input
/// walks it. Doors are open, and platforms are away.
class StepTrial {
  public:
    /// Heights that differ by less are one level, m.
    static constexpr float kLevel = 2.0F * motion::kSkin;
    /// Things farther from a capsule than this are not touched by it, m: ten times the air that it
    /// keeps.
    static constexpr float kClear = 10.0F * motion::kSkin;
    /// No world goes as far up or down, m.
    static constexpr float kEverywhere_m = 1e6F;
    /// Ground is gentle if it is this much less steep than the steepest that carries, as a cosine.
    static constexpr float kSlopeMargin = 0.02F;

    /// Of a world that holds all that is within reach_m() of the places in later calls.
    StepTrial(const motion::StaticGeometry& world,
              const motion::CharacterLimits& limits,
              float cell_m);

    /// How far a trial may look, m.
    static float reach_m(const motion::CharacterLimits& limits, float cell_m);

    /// A place, and the height of the capsule's lowest point there, m.
    struct Foothold {
        Spot at;
        float floor = 0.0F;
    };

    /// Heights over a place on which something may stand, from the lowest; until the next call.
    /// Heights at which the capsule would be within a box are not among them.
    std::span<const float> tops(Spot at);

    /// The height of its lowest point where the capsule comes to rest when it is put down there.
    [[nodiscard]] std::optional<float> stand(Spot at, float top) const;

    /// True if a character walks from the middle of a cell to that of a neighbour that is as high
    /// or higher.
    [[nodiscard]] bool walks(const Foothold& from, const Foothold& to) const;

  private:
    [[nodiscard]] bool carries(const motion::SweepHit& hit) const;
    [[nodiscard]] Aabb around_step(const Foothold& from, const Foothold& to) const;
    [[nodiscard]] bool surfaces_below(const Aabb& around, float height) const;
    [[nodiscard]] bool is_plain(Spot begin, Spot end, float floor) const;
    [[nodiscard]] bool is_slope(const Foothold& from, const Foothold& to) const;
    [[nodiscard]] bool is_on_slope(std::uint32_t box, const Foothold& at) const;
    [[nodiscard]] bool is_upright(std::uint32_t box) const;
    [[nodiscard]] bool is_level_under(std::uint32_t box, Spot begin, Spot end) const;
    [[nodiscard]] Aabb around_trial(const Foothold& from, const Foothold& to) const;
    [[nodiscard]] bool is_in_box(Spot at, float height, const Aabb& around) const;
    [[nodiscard]] bool is_wall(const Foothold& from, const Foothold& to) const;

    motion::StaticGeometry world_;
    motion::CharacterLimits limits_;
    float cell_m_;
    motion::Capsule capsule_;
    float half_height_;
    float slope_rise_;
    float ledge_m_;                ///< the most that a tick climbs
    float steepest_ = 0.0F;        ///< rise over run of the steepest ground that carries
    float off_floor_m_ = 0.0F;     ///< from the floor ahead, for a step that ends off the middle
    std::vector<PlanRect> plans_;  // by box
    std::vector<BoxColumn> columns_;
    std::vector<float> tops_;
};

}  // namespace zoned::ai::pathfinding

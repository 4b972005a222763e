// Matcher: keeps the visible set of every viewer tick by tick; it looks only at changed pairs.
#pragma once

#include "server/interest/incremental_grid.h"
#include "server/interest/interest_rule.h"
#include "server/interest/moved_set.h"
#include "server/interest/threshold_crossings.h"
#include "server/world/visibility.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::interest {

/// In every tick the sets are exactly those of hears() and lod_at() for all pairs, one after the
/// other, given the sets of the last tick.
///
/// The matcher looks at a pair only when a comparison of its distance changed since the last tick
/// (threshold_crossings.h), eight pairs at a time. Entities that moved go against a grid of the
/// viewers, and viewers that moved against a grid of the entities. When most move, all viewers go
/// against the entities. A viewer is matched with everything anew when it came, got another avatar,
/// changed its nimbus or jumped. A viewer with a cone (world::Cone) is matched so in every tick,
/// because a turn of either, or of the line between them, can lead over the cone's edge. The grids
/// follow the moves (incremental_grid.h).
///
/// Incremental matching of moved regions after Pan, Turner, Cai and Tan, "A dynamic sort-based DDM
/// matching algorithm for HLA applications", ACM TOMACS 21(3), 2011, section 3, on grids in place
/// of sorted lists.
class Matcher {
  public:
    /// Writes `out` (one set per viewer in the order of `viewers`, which ascend by client id). Sets
    /// of viewers that stay are updated in place, sets of viewers that are gone are dropped;
    /// entered/left/lod_changed/changed give the difference. No viewer hears of a hidden entity; a
    /// viewer without a row hears of nothing; no two share an avatar. The type table has to be the
    /// same in each call, and `out` the one of the last call. (Sets may be added, taken away or be
    /// given another `visible`, see VisibleSet::stamp.) No allocation after warm-up.
    InterestReport step(const world::Entities& entities,
                        const world::TypeTable& types,
                        std::span<const world::Viewer> viewers,
                        const InterestSettings& settings,
                        world::Visibility& out);

  private:
    /// Matched with everything because of its cone: its set is the last one but for differences.
    static constexpr std::uint8_t kFreshByCone = 2;

    /// The memory of a viewer, beside the columns below.
    struct MatchedViewer {
        world::Viewer viewer;
        world::Row row = world::kNoRow;
        std::uint64_t stamp = 0;
    };

    /// A pair to pending at; the row is none where the entity is gone, and only then its id
    /// matters.
    struct PendingPair {
        std::uint32_t viewer = 0;
        EntityId gone;
        world::Row row = world::kNoRow;
    };

    /// Between two places in the plane, m.
    struct MatchBox {
        float x0 = 0.0F;
        float x1 = 0.0F;
        float z0 = 0.0F;
        float z1 = 0.0F;

        MatchBox(float x, float z, float other_x, float other_z);
        void widen(float by_m);
    };

    void begin(const InterestSettings& settings, world::Visibility& out);
    void align(std::span<const world::Viewer> viewers, world::Visibility& out);
    void add_viewers(std::span<const world::Viewer> viewers, world::Visibility& out);
    void find_avatars(const world::Entities& entities);
    void read_cones(const world::Entities& entities);
    void read_viewers();
    void read_viewer(std::size_t viewer);
    void follow_entities(float cell_m);
    bool follow_entity(const EntityChange& change);
    void prefetch_changes() const;
    void index_viewers(float cell_m);
    void follow_viewers();
    void make_fresh(std::uint32_t viewer);
    [[nodiscard]] bool all_overlap(float& diagonal_squared) const;

    void refresh(std::size_t viewer);
    std::size_t keep_within_cone(std::size_t viewer, const ViewCone& cone, std::size_t candidates);
    void merge(std::size_t viewer, const ViewCone& cone, std::size_t candidates);
    void enclose_viewers();
    void cross_changes();
    void cross_steps();
    void cross_viewers(const ThresholdCrossings& test,
                       const PendingPair& pending,
                       const MatchBox& places);
    [[nodiscard]] MatchBox box_around(std::uint32_t viewer) const;
    void cross_entities(std::uint32_t viewer);
    void cross_all(std::uint32_t viewer);
    void sift();
    void sift_blocks();
    [[nodiscard]] EntityId entity_of(const PendingPair& pending) const;
    void settle_pairs();
    void settle_pair(const PendingPair& pending);
    void mark(std::uint32_t viewer);
    void finish();

    InterestSettings settings_;
    LodThresholds lods_;
    float widen_ = 1.0F + InterestSettings{}.hysteresis;
    MovedSet moved_set_;
    IncrementalGrid entity_grid_;
    IncrementalGrid viewer_grid_;
    bool viewers_changed_ = false;  // other viewers than a tick ago, or in another order
    bool quiet_ = false;            // all pairs are within all radii, now
    bool refresh_all_ = false;
    bool everybody_ = false;  // most move: all viewers pending at all entities
    float largest_nimbus_m_ = 0.0F;
    float smallest_nimbus_m_ = 0.0F;
    float entity_step_m_ = 0.0F;  // farthest that an entity stepped in this tick
    std::uint64_t next_stamp_ = 1;
    InterestReport report_;
    std::uint32_t pairs_ = 0;           // in all visible sets together
    world::Visibility* out_ = nullptr;  // during step()

    std::vector<MatchedViewer> matched_viewers_;
    std::vector<float> viewer_x_;  // by viewer, as are the next four
    std::vector<float> viewer_z_;
    std::vector<float> viewer_old_x_;
    std::vector<float> viewer_old_z_;
    std::vector<float> viewer_nimbus_;          // 0: no visible set
    std::vector<ViewCone> viewer_cone_;         // empty where no type has one
    std::vector<std::uint32_t> viewer_of_row_;  // by row
    std::vector<std::uint32_t> moved_;          // viewers that stepped
    std::vector<std::uint32_t> fresh_;          // viewers that are matched with everything
    std::vector<std::uint8_t> fresh_flag_;      // by viewer: whether it is among them, and why
    std::vector<std::uint32_t> marked_;         // viewers whose sets say a difference
    std::vector<std::uint32_t> near_;           // rows, scratch
    std::vector<std::uint64_t> sorted_;         // entity << 32 | row, scratch
    MatchBox viewers_ = MatchBox(0.0F, 0.0F, 0.0F, 0.0F);  // around them all, now and a tick ago
    std::vector<PendingPair> pending_pairs_;
    std::vector<IncrementalGrid::Note>
        notes_;  // viewers and entities near a step, the first `noted_`
    std::size_t noted_ = 0;
    std::vector<IncrementalGrid::GridBlock>
        old_places_;  // of all entities, in the order of the grid
    std::vector<world::Visible> scratch_;
    std::vector<MatchedViewer> spare_viewers_;
    world::Visibility spare_;
};

}  // namespace zoned::interest

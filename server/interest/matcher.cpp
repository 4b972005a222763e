#include "server/interest/matcher.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::interest {

namespace {

// The radius: few runs of slots per query, each long enough that its end costs little.
constexpr float kCellsPerRadius = 1.0F;
// Viewers are fewer: larger cells, so that a run fills its lanes.
constexpr float kViewerCells = 3.0F;
// More points than one in so many that come, go or change their cell: building a grid anew costs
// less than following.
constexpr std::size_t kFollowShare = 6;

bool same(const InterestSettings& a, const InterestSettings& b) {
    return a.hysteresis == b.hysteresis && a.lod_radius_m == b.lod_radius_m &&
           a.lod_lead_m == b.lod_lead_m;
}

/// The largest float whose root is at most `reach`; below zero there is none.
float largest_square(float reach) {
    if (reach < 0.0F) {
        return -1.0F;
    }
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    float square = reach * reach;
    while (std::sqrt(square) > reach) {
        square = std::nextafter(square, 0.0F);
    }
    while (std::sqrt(std::nextafter(square, kInfinity)) <= reach) {
        square = std::nextafter(square, kInfinity);
    }
    return square;
}

bool suits(const IncrementalGrid& grid, float cell_m) {
    return grid.cell_m() > 0.5F * cell_m && grid.cell_m() < 2.0F * cell_m && !grid.worn();
}

}  // namespace

LodThresholds::LodThresholds(const InterestSettings& settings) {
    ZONED_ASSERT(settings.lod_radius_m.size() <= kMost, "at most three radii");
    for (const float radius : settings.lod_radius_m) {
        nearer_m[count] = std::max(0.0F, radius + settings.lod_lead_m);
        farther_m[count] =
            std::max(0.0F, radius + settings.lod_lead_m + settings.hysteresis * radius);
        nearer[count] = largest_square(radius + settings.lod_lead_m);
        farther[count++] =
            largest_square(radius + settings.lod_lead_m + settings.hysteresis * radius);
    }
}

InterestReport Matcher::step(const world::Entities& entities,
                             const world::TypeTable& types,
                             std::span<const world::Viewer> viewers,
                             const InterestSettings& settings,
                             world::Visibility& out) {
    report_ = InterestReport{};
    if (viewers.empty()) {
        out.clear();
        matched_viewers_.clear();
        marked_.clear();
        viewers_changed_ = true;
        report_.skipped = true;
        return report_;
    }
    begin(settings, out);
    moved_set_.follow(entities, types);
    align(viewers, out);
    add_viewers(viewers, out);
    find_avatars(entities);
    read_viewers();
    read_cones(entities);
    const float radius = std::min(largest_nimbus_m_, moved_set_.largest_aura_m());
    const float cell_m = std::max(1.0F, radius / kCellsPerRadius);
    // Entities that moved meet the few viewers near them, viewers that moved the many entities:
    // together less than all viewers with all entities, unless most move.
    const double share =
        static_cast<double>(moved_set_.changed()) /
            static_cast<double>(std::max<std::size_t>(1, moved_set_.size())) +
        static_cast<double>(moved_.size()) / static_cast<double>(matched_viewers_.size());
    everybody_ = share >= 1.0;
    follow_entities(cell_m);
    index_viewers(kViewerCells * cell_m);
    for (const std::uint32_t viewer : fresh_) {
        refresh(viewer);
    }

    float diagonal_squared = 0.0F;
    report_.broadcast = all_overlap(diagonal_squared);
    const bool was_quiet = std::exchange(
        quiet_, report_.broadcast && (lods_.count == 0 || diagonal_squared <= lods_.nearer[0]));
    // Where all hear of each other, before and now, at the same level of detail, steps change
    // nothing.
    const bool still = quiet_ && was_quiet;
    enclose_viewers();
    cross_changes();
    if (!still && !everybody_) {
        cross_steps();
    }
    follow_viewers();
    if (!still && everybody_) {
        noted_ = 0;
        viewer_grid_.for_each_key([&](std::uint32_t viewer) { cross_all(viewer); });
        sift();
    } else if (!still) {
        // They stand anywhere in memory: the data of one are prefetched while another reads.
        constexpr std::size_t kAhead = 2;
        for (std::size_t i = 0; i < moved_.size(); ++i) {
            if (i + kAhead < moved_.size()) {
                const MatchBox box = box_around(moved_[i + kAhead]);
                entity_grid_.prefetch(box.x0, box.x1, box.z0, box.z1);
            }
            cross_entities(moved_[i]);
        }
    }
    settle_pairs();
    finish();
    return report_;
}

/// Clears the differences of the last tick.
void Matcher::begin(const InterestSettings& settings, world::Visibility& out) {
    out_ = &out;
    refresh_all_ = !same(settings, settings_);
    if (refresh_all_) {
        settings_ = settings;
        lods_ = LodThresholds(settings);
        widen_ = 1.0F + settings.hysteresis;
    }
    const auto clear = [](world::VisibleSet& set) {
        set.entered.clear();
        set.left.clear();
        set.lod_changed.clear();
        set.changed = false;
    };
    const bool untouched = out.size() == matched_viewers_.size() &&
                           std::all_of(marked_.begin(), marked_.end(), [&](std::uint32_t viewer) {
                               return out[viewer].stamp == matched_viewers_[viewer].stamp;
                           });
    if (untouched) {
        for (const std::uint32_t viewer : marked_) {
            clear(out[viewer]);
        }
    } else {
        std::for_each(out.begin(), out.end(), clear);
    }
    marked_.clear();
    fresh_.clear();
    moved_.clear();
}

/// Makes `out` and the seats hold exactly one entry per viewer; viewers that stay keep their sets.
void Matcher::align(std::span<const world::Viewer> viewers, world::Visibility& out) {
    const auto client_of = [](const auto& item) {
        if constexpr (requires { item.client; }) {
            return item.client;
        } else {
            return item.viewer.client;
        }
    };
    ZONED_ASSERT(std::is_sorted(viewers.begin(),
                                viewers.end(),
                                [](const world::Viewer& a, const world::Viewer& b) {
                                    return a.client < b.client;
                                }),
                 "viewers ascend by client id");
    const bool sets = world::align(out, spare_, viewers, client_of, [](const auto& viewer) {
        world::VisibleSet set;
        set.client = viewer.client;
        return set;
    });
    const bool seats =
        world::align(matched_viewers_, spare_viewers_, viewers, client_of, [](const auto& viewer) {
            return MatchedViewer{viewer, world::kNoRow, 0};
        });
    viewers_changed_ = viewers_changed_ || sets || seats;
}

/// Finds the viewers to match with everything: new ones, and those whose set is another one.
void Matcher::add_viewers(std::span<const world::Viewer> viewers, world::Visibility& out) {
    fresh_flag_.assign(matched_viewers_.size(), 0);
    for (std::uint32_t i = 0; i < matched_viewers_.size(); ++i) {
        MatchedViewer& add_viewers = matched_viewers_[i];
        if (refresh_all_ || add_viewers.stamp == 0 || add_viewers.stamp != out[i].stamp ||
            add_viewers.viewer.avatar != viewers[i].avatar) {
            if (add_viewers.viewer.avatar != viewers[i].avatar) {
                if (add_viewers.row < viewer_of_row_.size() &&
                    viewer_of_row_[add_viewers.row] == i) {
                    viewer_of_row_[add_viewers.row] = IncrementalGrid::kNone;
                }
                add_viewers.row = world::kNoRow;
            }
            add_viewers.viewer = viewers[i];
            make_fresh(i);
        }
    }
}

void Matcher::make_fresh(std::uint32_t viewer) {
    if (fresh_flag_[viewer] == 0) {
        fresh_flag_[viewer] = 1;
        fresh_.push_back(viewer);
    }
}

void Matcher::find_avatars(const world::Entities& entities) {
    const auto find = [&](std::uint32_t viewer) {
        MatchedViewer& add_viewers = matched_viewers_[viewer];
        const world::Row row = entities.find(add_viewers.viewer.avatar);
        if (row != world::kNoRow) {
            viewer_of_row_[row] = viewer;
        }
        if (row != add_viewers.row) {
            make_fresh(viewer);
        }
        add_viewers.row = row;
    };
    if (viewers_changed_) {
        viewer_of_row_.assign(moved_set_.size(), IncrementalGrid::kNone);
    } else {
        viewer_of_row_.resize(moved_set_.size(), IncrementalGrid::kNone);
        for (const world::Row row : moved_set_.rows_left()) {
            if (row < viewer_of_row_.size()) {
                viewer_of_row_[row] = IncrementalGrid::kNone;
            }
        }
    }
    if (viewers_changed_ || moved_set_.rows_changed()) {
        for (std::uint32_t i = 0; i < matched_viewers_.size(); ++i) {
            const world::Row row = matched_viewers_[i].row;
            if (row < moved_set_.size() &&
                moved_set_.id(row) == matched_viewers_[i].viewer.avatar) {
                viewer_of_row_[row] = i;
            } else {
                find(i);
            }
        }
        return;
    }
    for (const std::uint32_t viewer : fresh_) {
        if (matched_viewers_[viewer].row == world::kNoRow) {
            find(viewer);
        }
    }
}

void Matcher::read_viewer(std::size_t viewer) {
    const world::Row row = matched_viewers_[viewer].row;
    const bool placed = row != world::kNoRow && std::isfinite(moved_set_.x(row)) &&
                        std::isfinite(moved_set_.z(row));
    viewer_x_[viewer] = placed ? moved_set_.x(row) : 0.0F;
    viewer_z_[viewer] = placed ? moved_set_.z(row) : 0.0F;
    viewer_nimbus_[viewer] = placed ? moved_set_.nimbus_m(row) : 0.0F;
}

/// A viewer that looks far now is matched with everything, and only for that.
void Matcher::read_cones(const world::Entities& entities) {
    viewer_cone_.clear();
    if (!moved_set_.has_cones()) {
        return;
    }
    viewer_cone_.resize(matched_viewers_.size());
    for (std::uint32_t i = 0; i < matched_viewers_.size(); ++i) {
        const world::Row row = matched_viewers_[i].row;
        if (row == world::kNoRow || !std::isfinite(moved_set_.x(row)) ||
            !std::isfinite(moved_set_.z(row))) {
            continue;
        }
        viewer_cone_[i] = view_cone(moved_set_.cone(row), entities.yaw[row], settings_.hysteresis);
        if (viewer_cone_[i].length_m > 0.0F && fresh_flag_[i] == 0) {
            fresh_flag_[i] = kFreshByCone;
            fresh_.push_back(i);
        }
    }
}

/// Columns of the viewers, from their avatars; finds those that stepped.
void Matcher::read_viewers() {
    const std::size_t size = matched_viewers_.size();
    for (auto* column : {&viewer_x_, &viewer_z_, &viewer_old_x_, &viewer_old_z_, &viewer_nimbus_}) {
        column->resize(size);
    }
    for (const EntityChange& change : moved_set_.changes()) {
        if (change.row != world::kNoRow) {
            __builtin_prefetch(&viewer_of_row_[change.row]);
        }
    }
    for (const EntityChange& change : moved_set_.changes()) {
        const std::uint32_t viewer =
            change.row != world::kNoRow ? viewer_of_row_[change.row] : IncrementalGrid::kNone;
        if (viewer != IncrementalGrid::kNone) {
            make_fresh(viewer);
        }
    }
    for (const world::Row row : moved_set_.steps()) {
        const std::uint32_t viewer = viewer_of_row_[row];
        if (viewer != IncrementalGrid::kNone && fresh_flag_[viewer] == 0) {
            viewer_old_x_[viewer] = viewer_x_[viewer];
            viewer_old_z_[viewer] = viewer_z_[viewer];
            viewer_x_[viewer] = moved_set_.x(row);
            viewer_z_[viewer] = moved_set_.z(row);
            moved_.push_back(viewer);
        }
    }
    if (viewers_changed_) {
        for (std::size_t i = 0; i < size; ++i) {
            read_viewer(i);
            viewer_old_x_[i] = viewer_x_[i];
            viewer_old_z_[i] = viewer_z_[i];
        }
        for (const std::uint32_t i : moved_) {
            viewer_old_x_[i] = moved_set_.old_x(matched_viewers_[i].row);
            viewer_old_z_[i] = moved_set_.old_z(matched_viewers_[i].row);
        }
    }
    for (const std::uint32_t i : fresh_) {
        read_viewer(i);
        viewer_old_x_[i] = viewer_x_[i];
        viewer_old_z_[i] = viewer_z_[i];
    }
    if (viewers_changed_ || !fresh_.empty()) {
        largest_nimbus_m_ = 0.0F;
        smallest_nimbus_m_ = std::numeric_limits<float>::infinity();
        for (std::size_t i = 0; i < size; ++i) {
            largest_nimbus_m_ = std::max(largest_nimbus_m_, viewer_nimbus_[i]);
            if (matched_viewers_[i].row != world::kNoRow) {
                smallest_nimbus_m_ = std::min(smallest_nimbus_m_, viewer_nimbus_[i]);
            }
        }
    }
    entity_step_m_ = moved_set_.longest_step_m();
}

// ---------------------------------------------------------------- grids

void Matcher::follow_entities(float cell_m) {
    const std::size_t size = moved_set_.size();
    const std::vector<EntityChange>& changes = moved_set_.changes();
    const double leaving = static_cast<double>(changes.size()) +
                           entity_grid_.leaving(moved_set_.steps().size(), entity_step_m_);
    bool good = suits(entity_grid_, cell_m) &&
                leaving <= static_cast<double>(size) / static_cast<double>(kFollowShare);
    if (good) {
        for (const world::Row row : moved_set_.rows_left()) {
            if (entity_grid_.holds(row)) {
                entity_grid_.take(row);
            }
        }
        entity_grid_.resize(size);
        prefetch_changes();
        for (std::size_t i = 0; i < changes.size() && good; ++i) {
            good = changes[i].row == world::kNoRow || follow_entity(changes[i]);
        }
        good = good && entity_grid_.move_all(moved_set_.steps(), moved_set_.xs(), moved_set_.zs());
    }
    if (!good) {
        entity_grid_.build(moved_set_.points(), cell_m);
    }
    near_.resize(size + spatial::kLanes);
}

/// Their slots in the grid are anywhere in memory.
void Matcher::prefetch_changes() const {
    for (const EntityChange& change : moved_set_.changes()) {
        if (change.row != world::kNoRow) {
            entity_grid_.prefetch_slot(change.row);
        }
    }
    for (const EntityChange& change : moved_set_.changes()) {
        if (change.row != world::kNoRow) {
            entity_grid_.prefetch_place(change.row);
        }
    }
}

bool Matcher::follow_entity(const EntityChange& change) {
    const world::Row row = change.row;
    const float aura = moved_set_.aura_m(row);
    const float x = moved_set_.x(row);
    const float z = moved_set_.z(row);
    if (entity_grid_.holds(row)) {
        if (aura > 0.0F && aura == entity_grid_.radius_m(row)) {
            return entity_grid_.move(row, x, z);
        }
        entity_grid_.take(row);
    }
    if (!(aura > 0.0F)) {
        return true;
    }
    return entity_grid_.put(row, x, z, aura);
}

/// The viewers where they were a tick ago, but for those that are new there.
void Matcher::index_viewers(float cell_m) {
    bool good = !viewers_changed_ && suits(viewer_grid_, cell_m) &&
                fresh_.size() <= matched_viewers_.size() / kFollowShare;
    for (std::size_t i = 0; i < fresh_.size() && good; ++i) {
        const std::uint32_t viewer = fresh_[i];
        if (viewer_grid_.holds(viewer)) {
            viewer_grid_.take(viewer);
        }
        good =
            !(viewer_nimbus_[viewer] > 0.0F) ||
            viewer_grid_.put(viewer, viewer_x_[viewer], viewer_z_[viewer], viewer_nimbus_[viewer]);
    }
    if (!good) {
        viewer_grid_.build({viewer_old_x_, viewer_old_z_, viewer_nimbus_}, cell_m);
    }
}

/// The viewers where they are.
void Matcher::follow_viewers() {
    const double leaving = viewer_grid_.leaving(moved_.size(), entity_step_m_);
    if (leaving >
            static_cast<double>(matched_viewers_.size()) / static_cast<double>(kFollowShare) ||
        !viewer_grid_.move_all(moved_, viewer_x_, viewer_z_)) {
        viewer_grid_.build({viewer_x_, viewer_z_, viewer_nimbus_}, viewer_grid_.cell_m());
    }
}

/// All areas overlap when the diagonal of the box around everybody is within the smallest radius of
/// all: then every pair hears of each other, whatever the positions.
bool Matcher::all_overlap(float& diagonal_squared) const {
    const float smallest = std::min(smallest_nimbus_m_, moved_set_.smallest_aura_m());
    if (!(smallest > 0.0F) || std::isinf(smallest)) {
        return false;
    }
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    float min_x = kInfinity, max_x = -kInfinity, min_z = kInfinity, max_z = -kInfinity;
    const auto enclose = [&](float x, float z) {
        min_x = std::min(min_x, x);
        max_x = std::max(max_x, x);
        min_z = std::min(min_z, z);
        max_z = std::max(max_z, z);
        // Float subtraction, product and sum are monotonic, so no pair can be farther apart than
        // this, not even by rounding.
        const float dx = max_x - min_x;
        const float dz = max_z - min_z;
        diagonal_squared = dx * dx + dz * dz;
        return hears(diagonal_squared, smallest, smallest, false, settings_.hysteresis);
    };
    // In most worlds the first few are too far apart.
    for (world::Row row = 0; row < moved_set_.size(); ++row) {
        if (moved_set_.aura_m(row) > 0.0F && !enclose(moved_set_.x(row), moved_set_.z(row))) {
            return false;
        }
    }
    for (std::size_t i = 0; i < matched_viewers_.size(); ++i) {
        if (matched_viewers_[i].row != world::kNoRow && !enclose(viewer_x_[i], viewer_z_[i])) {
            return false;
        }
    }
    return true;
}

void Matcher::finish() {
    for (const std::uint32_t viewer : marked_) {
        world::VisibleSet& set = (*out_)[viewer];
        const auto by_entity = [](const world::Visible& a, const world::Visible& b) {
            return a.entity < b.entity;
        };
        std::sort(set.entered.begin(), set.entered.end(), by_entity);
        std::sort(set.left.begin(), set.left.end());
        std::sort(set.lod_changed.begin(), set.lod_changed.end(), by_entity);
        report_.entered += static_cast<std::uint32_t>(set.entered.size());
        report_.left += static_cast<std::uint32_t>(set.left.size());
    }
    report_.viewers = static_cast<std::uint32_t>(matched_viewers_.size());
    report_.changed = static_cast<std::uint32_t>(moved_set_.changed());
    report_.refreshed = static_cast<std::uint32_t>(fresh_.size());
    if (viewers_changed_ || !fresh_.empty()) {
        pairs_ = 0;
        for (const world::VisibleSet& set : *out_) {
            pairs_ += static_cast<std::uint32_t>(set.visible.size());
        }
    } else {
        pairs_ += report_.entered;
        pairs_ -= report_.left;
    }
    report_.visible_pairs = pairs_;
    for (const std::uint32_t viewer : moved_) {
        viewer_old_x_[viewer] = viewer_x_[viewer];
        viewer_old_z_[viewer] = viewer_z_[viewer];
    }
    moved_set_.settle();
    viewers_changed_ = false;
    out_ = nullptr;
}

}  // namespace zoned::interest

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

bool same(const Settings& a, const Settings& b) {
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

bool suits(const KeptGrid& grid, float cell_m) {
    return grid.cell_m() > 0.5F * cell_m && grid.cell_m() < 2.0F * cell_m && !grid.worn();
}

}  // namespace

LodSteps::LodSteps(const Settings& settings) {
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

Report Matcher::step(const world::Entities& entities,
                     const world::TypeTable& types,
                     std::span<const world::Viewer> viewers,
                     const Settings& settings,
                     world::Visibility& out) {
    report_ = Report{};
    if (viewers.empty()) {
        out.clear();
        seats_.clear();
        marked_.clear();
        viewers_changed_ = true;
        report_.skipped = true;
        return report_;
    }
    begin(settings, out);
    population_.follow(entities, types);
    align(viewers, out);
    seat(viewers, out);
    find_avatars(entities);
    read_viewers();
    read_cones(entities);
    const float radius = std::min(largest_nimbus_m_, population_.largest_aura_m());
    const float cell_m = std::max(1.0F, radius / kCellsPerRadius);
    // Entities that moved meet the few viewers near them, viewers that moved the many entities:
    // together less than all viewers with all entities, unless most move.
    const double share = static_cast<double>(population_.changed()) /
                             static_cast<double>(std::max<std::size_t>(1, population_.size())) +
                         static_cast<double>(moved_.size()) / static_cast<double>(seats_.size());
    everybody_ = share >= 1.0;
    follow_entities(cell_m);
    seat_viewers(kViewerCells * cell_m);
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
        // They stand anywhere: what one will read is asked for while another reads.
        constexpr std::size_t kAhead = 2;
        for (std::size_t i = 0; i < moved_.size(); ++i) {
            if (i + kAhead < moved_.size()) {
                const Box box = box_around(moved_[i + kAhead]);
                entity_grid_.prefetch(box.x0, box.x1, box.z0, box.z1);
            }
            cross_entities(moved_[i]);
        }
    }
    settle_pairs();
    finish();
    return report_;
}

/// Takes back what the last tick said of differences.
void Matcher::begin(const Settings& settings, world::Visibility& out) {
    out_ = &out;
    refresh_all_ = !same(settings, settings_);
    if (refresh_all_) {
        settings_ = settings;
        lods_ = LodSteps(settings);
        widen_ = 1.0F + settings.hysteresis;
    }
    const auto clear = [](world::VisibleSet& set) {
        set.entered.clear();
        set.left.clear();
        set.lod_changed.clear();
        set.changed = false;
    };
    const bool untouched = out.size() == seats_.size() &&
                           std::all_of(marked_.begin(), marked_.end(), [&](std::uint32_t viewer) {
                               return out[viewer].stamp == seats_[viewer].stamp;
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

/// Makes `out` and the seats hold exactly one entry per viewer; those that stay keep what they
/// knew.
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
        world::align(seats_, spare_seats_, viewers, client_of, [](const auto& viewer) {
            return Seat{viewer, world::kNoRow, 0};
        });
    viewers_changed_ = viewers_changed_ || sets || seats;
}

/// Who has to be matched with everything: those that are new here, and whose set is another one.
void Matcher::seat(std::span<const world::Viewer> viewers, world::Visibility& out) {
    fresh_flag_.assign(seats_.size(), 0);
    for (std::uint32_t i = 0; i < seats_.size(); ++i) {
        Seat& seat = seats_[i];
        if (refresh_all_ || seat.stamp == 0 || seat.stamp != out[i].stamp ||
            seat.viewer.avatar != viewers[i].avatar) {
            if (seat.viewer.avatar != viewers[i].avatar) {
                if (seat.row < viewer_of_row_.size() && viewer_of_row_[seat.row] == i) {
                    viewer_of_row_[seat.row] = KeptGrid::kNone;
                }
                seat.row = world::kNoRow;
            }
            seat.viewer = viewers[i];
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
        Seat& seat = seats_[viewer];
        const world::Row row = entities.find(seat.viewer.avatar);
        if (row != world::kNoRow) {
            viewer_of_row_[row] = viewer;
        }
        if (row != seat.row) {
            make_fresh(viewer);
        }
        seat.row = row;
    };
    if (viewers_changed_) {
        viewer_of_row_.assign(population_.size(), KeptGrid::kNone);
    } else {
        viewer_of_row_.resize(population_.size(), KeptGrid::kNone);
        for (const world::Row row : population_.rows_left()) {
            if (row < viewer_of_row_.size()) {
                viewer_of_row_[row] = KeptGrid::kNone;
            }
        }
    }
    if (viewers_changed_ || population_.rows_changed()) {
        for (std::uint32_t i = 0; i < seats_.size(); ++i) {
            const world::Row row = seats_[i].row;
            if (row < population_.size() && population_.id(row) == seats_[i].viewer.avatar) {
                viewer_of_row_[row] = i;
            } else {
                find(i);
            }
        }
        return;
    }
    for (const std::uint32_t viewer : fresh_) {
        if (seats_[viewer].row == world::kNoRow) {
            find(viewer);
        }
    }
}

void Matcher::read_viewer(std::size_t viewer) {
    const world::Row row = seats_[viewer].row;
    const bool placed = row != world::kNoRow && std::isfinite(population_.x(row)) &&
                        std::isfinite(population_.z(row));
    viewer_x_[viewer] = placed ? population_.x(row) : 0.0F;
    viewer_z_[viewer] = placed ? population_.z(row) : 0.0F;
    viewer_nimbus_[viewer] = placed ? population_.nimbus_m(row) : 0.0F;
}

/// Who looks far now is matched with everything, and only for that.
void Matcher::read_cones(const world::Entities& entities) {
    viewer_cone_.clear();
    if (!population_.has_cones()) {
        return;
    }
    viewer_cone_.resize(seats_.size());
    for (std::uint32_t i = 0; i < seats_.size(); ++i) {
        const world::Row row = seats_[i].row;
        if (row == world::kNoRow || !std::isfinite(population_.x(row)) ||
            !std::isfinite(population_.z(row))) {
            continue;
        }
        viewer_cone_[i] = view_cone(population_.cone(row), entities.yaw[row], settings_.hysteresis);
        if (viewer_cone_[i].length_m > 0.0F && fresh_flag_[i] == 0) {
            fresh_flag_[i] = kFreshByCone;
            fresh_.push_back(i);
        }
    }
}

/// Columns of the viewers, from their avatars; finds those that stepped.
void Matcher::read_viewers() {
    const std::size_t size = seats_.size();
    for (auto* column : {&viewer_x_, &viewer_z_, &viewer_old_x_, &viewer_old_z_, &viewer_nimbus_}) {
        column->resize(size);
    }
    for (const Change& change : population_.changes()) {
        if (change.row != world::kNoRow) {
            __builtin_prefetch(&viewer_of_row_[change.row]);
        }
    }
    for (const Change& change : population_.changes()) {
        const std::uint32_t viewer =
            change.row != world::kNoRow ? viewer_of_row_[change.row] : KeptGrid::kNone;
        if (viewer != KeptGrid::kNone) {
            make_fresh(viewer);
        }
    }
    for (const world::Row row : population_.steps()) {
        const std::uint32_t viewer = viewer_of_row_[row];
        if (viewer != KeptGrid::kNone && fresh_flag_[viewer] == 0) {
            viewer_old_x_[viewer] = viewer_x_[viewer];
            viewer_old_z_[viewer] = viewer_z_[viewer];
            viewer_x_[viewer] = population_.x(row);
            viewer_z_[viewer] = population_.z(row);
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
            viewer_old_x_[i] = population_.old_x(seats_[i].row);
            viewer_old_z_[i] = population_.old_z(seats_[i].row);
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
            if (seats_[i].row != world::kNoRow) {
                smallest_nimbus_m_ = std::min(smallest_nimbus_m_, viewer_nimbus_[i]);
            }
        }
    }
    entity_step_m_ = population_.longest_step_m();
}

// ---------------------------------------------------------------- grids

void Matcher::follow_entities(float cell_m) {
    const std::size_t size = population_.size();
    const std::vector<Change>& changes = population_.changes();
    const double leaving = static_cast<double>(changes.size()) +
                           entity_grid_.leaving(population_.steps().size(), entity_step_m_);
    bool good = suits(entity_grid_, cell_m) &&
                leaving <= static_cast<double>(size) / static_cast<double>(kFollowShare);
    if (good) {
        for (const world::Row row : population_.rows_left()) {
            if (entity_grid_.holds(row)) {
                entity_grid_.take(row);
            }
        }
        entity_grid_.resize(size);
        prefetch_changes();
        for (std::size_t i = 0; i < changes.size() && good; ++i) {
            good = changes[i].row == world::kNoRow || follow_entity(changes[i]);
        }
        good =
            good && entity_grid_.move_all(population_.steps(), population_.xs(), population_.zs());
    }
    if (!good) {
        entity_grid_.build(population_.points(), cell_m);
    }
    near_.resize(size + spatial::kLanes);
}

/// Their slots in the grid are anywhere in memory.
void Matcher::prefetch_changes() const {
    for (const Change& change : population_.changes()) {
        if (change.row != world::kNoRow) {
            entity_grid_.prefetch_slot(change.row);
        }
    }
    for (const Change& change : population_.changes()) {
        if (change.row != world::kNoRow) {
            entity_grid_.prefetch_place(change.row);
        }
    }
}

bool Matcher::follow_entity(const Change& change) {
    const world::Row row = change.row;
    const float aura = population_.aura_m(row);
    const float x = population_.x(row);
    const float z = population_.z(row);
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
void Matcher::seat_viewers(float cell_m) {
    bool good = !viewers_changed_ && suits(viewer_grid_, cell_m) &&
                fresh_.size() <= seats_.size() / kFollowShare;
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
    if (leaving > static_cast<double>(seats_.size()) / static_cast<double>(kFollowShare) ||
        !viewer_grid_.move_all(moved_, viewer_x_, viewer_z_)) {
        viewer_grid_.build({viewer_x_, viewer_z_, viewer_nimbus_}, viewer_grid_.cell_m());
    }
}

/// All areas overlap when the diagonal of the box around everybody is within the smallest radius of
/// all: then every pair hears of each other, whatever the positions.
bool Matcher::all_overlap(float& diagonal_squared) const {
    const float smallest = std::min(smallest_nimbus_m_, population_.smallest_aura_m());
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
    for (world::Row row = 0; row < population_.size(); ++row) {
        if (population_.aura_m(row) > 0.0F && !enclose(population_.x(row), population_.z(row))) {
            return false;
        }
    }
    for (std::size_t i = 0; i < seats_.size(); ++i) {
        if (seats_[i].row != world::kNoRow && !enclose(viewer_x_[i], viewer_z_[i])) {
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
    report_.viewers = static_cast<std::uint32_t>(seats_.size());
    report_.changed = static_cast<std::uint32_t>(population_.changed());
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
    population_.settle();
    viewers_changed_ = false;
    out_ = nullptr;
}

}  // namespace zoned::interest

#include "server/interest/interest_step.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::interest {

namespace {

// The grid is asked for slightly more than the largest radius, so that its rounding never decides:
// hears() does.
constexpr float kQuerySlack = 1.0001F;
// Cells of a quarter of the radius: the square of cells around the circle then holds about 1.6
// times the circle's area.
constexpr float kCellsPerRadius = 4.0F;

float radius_of(const std::array<float, world::kBehaviours>& radii, std::uint8_t behaviour) {
    ZONED_ASSERT(behaviour < world::kBehaviours, "a behaviour has radii");
    return radii[behaviour];
}

}  // namespace

Report Matcher::step(const world::Entities& entities,
                     const world::TypeTable& types,
                     std::span<const world::Viewer> viewers,
                     const spatial::PointGrid& grid,
                     const Settings& settings,
                     world::Visibility& out) {
    Report report;
    report.viewers = static_cast<std::uint32_t>(viewers.size());
    if (viewers.empty()) {
        out.clear();
        report.skipped = true;
        return report;
    }
    align_sets(viewers, out);
    const Survey seen = survey(entities, types, viewers, settings);
    report.broadcast = seen.all_overlap;
    const spatial::PointGrid* near = &grid;
    if (seen.all_overlap) {
        list_everybody(entities);
    } else if (grid.size() == 0 && entities.size() > 0) {
        const float radius = std::min(seen.largest_nimbus_m, seen.largest_aura_m);
        own_grid_.build(entities.position, std::max(1.0F, radius / kCellsPerRadius));
        near = &own_grid_;
    }
    for (std::size_t i = 0; i < viewers.size(); ++i) {
        candidates_.clear();
        if (viewer_row_[i] != world::kNoRow) {
            if (seen.all_overlap) {
                gather_all(entities, viewer_row_[i]);
            } else {
                const float reach = std::min(viewer_nimbus_m_[i], seen.largest_aura_m);
                gather_near(entities, *near, viewer_row_[i], reach, settings);
            }
        }
        update_set(viewer_nimbus_m_[i], seen.all_overlap, settings, out[i]);
        report.visible_pairs += static_cast<std::uint32_t>(out[i].visible.size());
        report.entered += static_cast<std::uint32_t>(out[i].entered.size());
        report.left += static_cast<std::uint32_t>(out[i].left.size());
    }
    return report;
}

/// Makes `out` hold exactly one set per viewer; sets that stay keep what they knew.
void Matcher::align_sets(std::span<const world::Viewer> viewers, world::Visibility& out) {
    const auto same = [](const world::VisibleSet& set, const world::Viewer& viewer) {
        return set.client == viewer.client;
    };
    if (std::equal(out.begin(), out.end(), viewers.begin(), viewers.end(), same)) {
        return;
    }
    spare_.clear();
    spare_.reserve(viewers.size());
    auto old = out.begin();
    for (const world::Viewer& viewer : viewers) {
        ZONED_ASSERT(spare_.empty() || spare_.back().client < viewer.client,
                     "viewers ascend by client id");
        while (old != out.end() && old->client < viewer.client) {
            ++old;
        }
        if (old != out.end() && old->client == viewer.client) {
            spare_.push_back(std::move(*old++));
        } else {
            spare_.emplace_back().client = viewer.client;
        }
    }
    out.swap(spare_);
    spare_.clear();
}

/// Fills the columns by row and by viewer. All areas overlap when the diagonal of the box around
/// everybody is within the smallest radius of all: then every pair hears of each other, whatever
/// the positions.
Matcher::Survey Matcher::survey(const world::Entities& entities,
                                const world::TypeTable& types,
                                std::span<const world::Viewer> viewers,
                                const Settings& settings) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    Survey seen;
    float smallest = kInfinity;
    float min_x = kInfinity, max_x = -kInfinity, min_z = kInfinity, max_z = -kInfinity;
    const auto enclose = [&](const Vec3& p) {
        min_x = std::min(min_x, p.x());
        max_x = std::max(max_x, p.x());
        min_z = std::min(min_z, p.z());
        max_z = std::max(max_z, p.z());
        return std::isfinite(p.x()) && std::isfinite(p.z());
    };
    bool all_finite = true;
    aura_m_.resize(entities.size());
    for (world::Row row = 0; row < entities.size(); ++row) {
        if (entities.has(row, world::kHidden)) {
            aura_m_[row] = 0.0F;
            continue;
        }
        aura_m_[row] = radius_of(types[entities.type[row]].aura_m, entities.behaviour[row]);
        seen.largest_aura_m = std::max(seen.largest_aura_m, aura_m_[row]);
        smallest = std::min(smallest, aura_m_[row]);
        all_finite = enclose(entities.position[row]) && all_finite;
    }
    viewer_row_.resize(viewers.size());
    viewer_nimbus_m_.resize(viewers.size());
    for (std::size_t i = 0; i < viewers.size(); ++i) {
        const world::Row row = entities.find(viewers[i].avatar);
        viewer_row_[i] = row;
        viewer_nimbus_m_[i] = 0.0F;
        if (row != world::kNoRow) {
            viewer_nimbus_m_[i] =
                radius_of(types[entities.type[row]].nimbus_m, entities.behaviour[row]);
            seen.largest_nimbus_m = std::max(seen.largest_nimbus_m, viewer_nimbus_m_[i]);
            smallest = std::min(smallest, viewer_nimbus_m_[i]);
            all_finite = enclose(entities.position[row]) && all_finite;
        }
    }
    if (all_finite && max_x >= min_x) {
        // Float subtraction, product and sum are monotonic, so no pair can be farther apart than
        // this, not even by rounding.
        const float dx = max_x - min_x;
        const float dz = max_z - min_z;
        seen.all_overlap = hears(dx * dx + dz * dz, smallest, smallest, false, settings.hysteresis);
    }
    return seen;
}

/// One sorted list that serves all viewers of a broadcast.
void Matcher::list_everybody(const world::Entities& entities) {
    everybody_.clear();
    for (world::Row row = 0; row < entities.size(); ++row) {
        if (!entities.has(row, world::kHidden)) {
            everybody_.push_back((static_cast<std::uint64_t>(entities.id[row].value) << 32) | row);
        }
    }
    std::sort(everybody_.begin(), everybody_.end());
}

void Matcher::gather_all(const world::Entities& entities, world::Row own_row) {
    const Vec3& here = entities.position[own_row];
    for (const std::uint64_t key : everybody_) {
        const auto row = static_cast<world::Row>(key & 0xFFFFFFFFu);
        if (row != own_row) {
            const float dx = entities.position[row].x() - here.x();
            const float dz = entities.position[row].z() - here.z();
            candidates_.push_back({key, dx * dx + dz * dz, aura_m_[row]});
        }
    }
}

void Matcher::gather_near(const world::Entities& entities,
                          const spatial::PointGrid& grid,
                          world::Row own_row,
                          float reach_m,
                          const Settings& settings) {
    const Vec3& here = entities.position[own_row];
    if (reach_m <= 0.0F || !std::isfinite(here.x()) || !std::isfinite(here.z())) {
        return;
    }
    const float radius = reach_m * (1.0F + settings.hysteresis) * kQuerySlack;
    grid.for_each_within(
        here.x(), here.z(), radius, [&](std::uint32_t row, float distance_squared) {
            const float aura = aura_m_[row];
            if (row != own_row &&
                hears(distance_squared, reach_m, aura, true, settings.hysteresis)) {
                const auto entity = static_cast<std::uint64_t>(entities.id[row].value);
                candidates_.push_back({(entity << 32) | row, distance_squared, aura});
            }
        });
    std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
        return a.key < b.key;
    });
}

/// Merges the candidates with what was known, both ascending by entity.
void Matcher::update_set(float nimbus_m,
                         bool everybody,
                         const Settings& settings,
                         world::VisibleSet& set) {
    scratch_.clear();
    set.entered.clear();
    set.left.clear();
    set.lod_changed.clear();
    auto old = set.visible.cbegin();
    const auto old_end = set.visible.cend();
    for (const Candidate& candidate : candidates_) {
        const EntityId entity(static_cast<std::uint32_t>(candidate.key >> 32));
        while (old != old_end && old->entity < entity) {
            set.left.push_back((old++)->entity);
        }
        const bool known = old != old_end && old->entity == entity;
        const int known_lod = known ? old->lod : -1;
        old += known ? 1 : 0;
        if (!everybody && !hears(candidate.distance_squared,
                                 nimbus_m,
                                 candidate.aura_m,
                                 known,
                                 settings.hysteresis)) {
            if (known) {
                set.left.push_back(entity);
            }
            continue;
        }
        const std::uint8_t lod =
            settings.lod_radius_m.empty()
                ? std::uint8_t{0}
                : lod_at(std::sqrt(candidate.distance_squared), settings, known_lod);
        scratch_.push_back({entity, lod});
        if (!known) {
            set.entered.push_back({entity, lod});
        } else if (known_lod != lod) {
            set.lod_changed.push_back({entity, lod});
        }
    }
    for (; old != old_end; ++old) {
        set.left.push_back(old->entity);
    }
    set.visible.assign(scratch_.begin(), scratch_.end());
}

}  // namespace zoned::interest

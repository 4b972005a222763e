#include "server/interest/matcher.h"

#include <algorithm>
#include <cmath>

namespace zoned::interest {

namespace {

constexpr float kReachSlack = 1.0001F;
constexpr float kNearest = 1e-6F;  // of the coordinates: what a difference of floats may lose

}  // namespace

/// What a viewer hears of by all pairs near it, merged with what it knew.
void Matcher::refresh(std::size_t viewer) {
    const Seat& seat = seats_[viewer];
    const ViewCone cone = viewer_cone_.empty() ? ViewCone{} : viewer_cone_[viewer];
    const float reach = std::max(viewer_nimbus_[viewer], cone.length_m);
    std::size_t found = 0;
    if (seat.row != world::kNoRow && reach > 0.0F) {
        found = entity_grid_.gather(
            viewer_x_[viewer], viewer_z_[viewer], reach, widen_, seat.row, near_.data());
    }
    if (cone.length_m > 0.0F) {
        found = keep_within_cone(viewer, cone, found);
    }
    sorted_.resize(found);
    for (std::size_t i = 0; i < found; ++i) {
        sorted_[i] = (static_cast<std::uint64_t>(population_.id(near_[i]).value) << 32U) | near_[i];
    }
    std::sort(sorted_.begin(), sorted_.end());
    merge(viewer, cone, found);
    world::VisibleSet& set = (*out_)[viewer];
    set.changed = fresh_flag_[viewer] != kFreshByCone || !set.entered.empty() ||
                  !set.left.empty() || !set.lod_changed.empty();
    if (set.changed) {
        marked_.push_back(static_cast<std::uint32_t>(viewer));
    }
    seats_[viewer].stamp = next_stamp_++;
    set.stamp = seats_[viewer].stamp;
}

/// Of what is near, what may be heard at all: a cone holds a small part of its disc, and what is
/// left is sorted.
std::size_t Matcher::keep_within_cone(std::size_t viewer,
                                      const ViewCone& cone,
                                      std::size_t candidates) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < candidates; ++i) {
        const world::Row row = near_[i];
        const bool heard = hears(population_.x(row) - viewer_x_[viewer],
                                 population_.z(row) - viewer_z_[viewer],
                                 viewer_nimbus_[viewer],
                                 cone,
                                 population_.aura_m(row),
                                 true,
                                 settings_.hysteresis);
        near_[kept] = row;
        kept += heard ? 1 : 0;
    }
    return kept;
}

/// Merges the candidates with what was known, both ascending by entity.
void Matcher::merge(std::size_t viewer, const ViewCone& cone, std::size_t candidates) {
    world::VisibleSet& set = (*out_)[viewer];
    scratch_.clear();
    auto old = set.visible.cbegin();
    const auto old_end = set.visible.cend();
    for (std::size_t i = 0; i < candidates; ++i) {
        const EntityId entity(static_cast<std::uint32_t>(sorted_[i] >> 32U));
        const auto row = static_cast<world::Row>(sorted_[i] & 0xFFFFFFFFU);
        while (old != old_end && old->entity < entity) {
            set.left.push_back((old++)->entity);
        }
        const bool known = old != old_end && old->entity == entity;
        const int known_lod = known ? old->lod : -1;
        old += known ? 1 : 0;
        const float dx = population_.x(row) - viewer_x_[viewer];
        const float dz = population_.z(row) - viewer_z_[viewer];
        const float distance_squared = dx * dx + dz * dz;
        if (!hears(dx,
                   dz,
                   viewer_nimbus_[viewer],
                   cone,
                   population_.aura_m(row),
                   known,
                   settings_.hysteresis)) {
            if (known) {
                set.left.push_back(entity);
            }
            continue;
        }
        const std::uint8_t lod = lods_.count == 0
                                     ? std::uint8_t{0}
                                     : lod_at(std::sqrt(distance_squared), settings_, known_lod);
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

/// Entities that changed against the viewers near the place that they left and the one they came
/// to.
void Matcher::cross_changes() {
    for (const Change& change : population_.changes()) {
        const bool here = change.row != world::kNoRow && population_.aura_m(change.row) > 0.0F;
        const bool was = change.old_aura_m > 0.0F;
        Crossings test;
        test.x = here ? population_.x(change.row) : change.old_x;
        test.z = here ? population_.z(change.row) : change.old_z;
        test.old_x = was ? change.old_x : test.x;
        test.old_z = was ? change.old_z : test.z;
        test.radius_m = here ? population_.aura_m(change.row) : 0.0F;
        test.old_radius_m = change.old_aura_m;
        test.widen = widen_;
        test.lods = &lods_;
        const Look look{0, change.entity, change.row};
        if (was) {
            cross_viewers(test, look, {test.old_x, test.old_z, test.old_x, test.old_z});
        }
        if (here) {
            cross_viewers(test, look, {test.x, test.z, test.x, test.z});
        }
    }
}

/// Entities that stepped against the viewers near them, neighbours one after the other: they meet
/// the same viewers.
void Matcher::cross_steps() {
    // Slots stand place by place: so many of them are one place.
    constexpr std::uint32_t kPlace = 512;
    const std::vector<world::Row>& steps = population_.steps();
    if (steps.empty()) {
        return;
    }
    place_begin_.assign(entity_grid_.slots() / kPlace + 2, 0);
    for (const world::Row row : steps) {
        if (entity_grid_.holds(row)) {
            ++place_begin_[entity_grid_.slot(row) / kPlace + 1];
        }
    }
    for (std::size_t place = 1; place < place_begin_.size(); ++place) {
        place_begin_[place] += place_begin_[place - 1];
    }
    ordered_.resize(place_begin_.back());
    for (const world::Row row : steps) {
        if (entity_grid_.holds(row)) {
            ordered_[place_begin_[entity_grid_.slot(row) / kPlace]++] = row;
        }
    }
    for (const world::Row row : ordered_) {
        Crossings test;
        test.x = population_.x(row);
        test.z = population_.z(row);
        test.old_x = population_.old_x(row);
        test.old_z = population_.old_z(row);
        test.radius_m = population_.aura_m(row);
        test.old_radius_m = test.radius_m;
        test.widen = widen_;
        test.lods = &lods_;
        cross_viewers(
            test, {0, population_.id(row), row}, {test.x, test.z, test.old_x, test.old_z});
    }
}

/// Against the viewers near the box of two places.
void Matcher::cross_viewers(const Crossings& test, const Look& look, const Stride& between) {
    const float reach = std::min(std::max(test.radius_m, test.old_radius_m), largest_nimbus_m_) *
                            widen_ * kReachSlack +
                        viewer_step_m_;
    const float reach_x = reach + kNearest * std::max(std::abs(between.x), std::abs(between.old_x));
    const float reach_z = reach + kNearest * std::max(std::abs(between.z), std::abs(between.old_z));
    viewer_grid_.for_each_run(std::min(between.x, between.old_x) - reach_x,
                              std::max(between.x, between.old_x) + reach_x,
                              std::min(between.z, between.old_z) - reach_z,
                              std::max(between.z, between.old_z) + reach_z,
                              [&](std::uint32_t begin, std::uint32_t end) {
                                  viewer_grid_.for_each_crossed<true>(
                                      begin, end, test, [&](std::uint32_t viewer) {
                                          looks_.push_back({viewer, look.entity, look.row});
                                      });
                              });
}

/// A viewer that stepped against the entities near it, as if these stood where they are: those that
/// stepped as well have been seen to. With `kRemember` against all as they moved.
template <bool kRemember>
void Matcher::cross_entities(std::uint32_t viewer) {
    if (fresh_flag_[viewer] != 0 || !(viewer_nimbus_[viewer] > 0.0F)) {
        return;
    }
    Crossings test;
    test.x = viewer_x_[viewer];
    test.z = viewer_z_[viewer];
    test.old_x = viewer_old_x_[viewer];
    test.old_z = viewer_old_z_[viewer];
    test.radius_m = viewer_nimbus_[viewer];
    test.old_radius_m = test.radius_m;
    test.widen = widen_;
    test.lods = &lods_;
    const float reach =
        std::min(test.radius_m, population_.largest_aura_m()) * widen_ * kReachSlack +
        entity_step_m_;
    const float reach_x = reach + kNearest * (std::abs(test.x) + std::abs(test.old_x));
    const float reach_z = reach + kNearest * (std::abs(test.z) + std::abs(test.old_z));
    entity_grid_.for_each_run(std::min(test.x, test.old_x) - reach_x,
                              std::max(test.x, test.old_x) + reach_x,
                              std::min(test.z, test.old_z) - reach_z,
                              std::max(test.z, test.old_z) + reach_z,
                              [&](std::uint32_t begin, std::uint32_t end) {
                                  entity_grid_.for_each_crossed<kRemember>(
                                      begin, end, test, [&](std::uint32_t row) {
                                          looks_.push_back({viewer, population_.id(row), row});
                                      });
                              });
}

template void Matcher::cross_entities<false>(std::uint32_t viewer);
template void Matcher::cross_entities<true>(std::uint32_t viewer);

/// The sets lie far apart in memory: what will be read is asked for some pairs ahead.
void Matcher::settle_pairs() {
    constexpr std::size_t kSoon = 6;
    constexpr std::size_t kLater = 12;
    for (std::size_t i = 0; i < looks_.size(); ++i) {
        if (i + kLater < looks_.size()) {
            const Look& later = looks_[i + kLater];
            __builtin_prefetch(&(*out_)[later.viewer]);
            population_.prefetch(later.row);
        }
        if (i + kSoon < looks_.size()) {
            const std::vector<world::Visible>& soon = (*out_)[looks_[i + kSoon].viewer].visible;
            const char* data = reinterpret_cast<const char*>(soon.data());
            const std::size_t bytes = soon.size() * sizeof(world::Visible);
            for (std::size_t at = 0; at < bytes; at += 64) {
                __builtin_prefetch(data + at);
            }
        }
        settle_pair(looks_[i].viewer, looks_[i].entity, looks_[i].row);
    }
    looks_.clear();
}

/// The rule for one pair, by what the viewer knows. To do it twice changes nothing.
void Matcher::settle_pair(std::uint32_t viewer, EntityId entity, world::Row row) {
    const Seat& seat = seats_[viewer];
    if (fresh_flag_[viewer] != 0 || row == seat.row) {
        return;
    }
    ++report_.examined;
    world::VisibleSet& set = (*out_)[viewer];
    const auto at = std::lower_bound(
        set.visible.begin(), set.visible.end(), entity, [](const world::Visible& v, EntityId id) {
            return v.entity < id;
        });
    const bool known = at != set.visible.end() && at->entity == entity;
    bool heard = false;
    float distance_squared = 0.0F;
    if (row != world::kNoRow) {
        const float dx = population_.x(row) - viewer_x_[viewer];
        const float dz = population_.z(row) - viewer_z_[viewer];
        distance_squared = dx * dx + dz * dz;
        heard = hears(distance_squared,
                      viewer_nimbus_[viewer],
                      population_.aura_m(row),
                      known,
                      settings_.hysteresis);
    }
    if (!heard) {
        if (known) {
            mark(viewer);
            set.visible.erase(at);
            set.left.push_back(entity);
        }
        return;
    }
    const std::uint8_t lod =
        lods_.count == 0 ? std::uint8_t{0}
                         : lod_at(std::sqrt(distance_squared), settings_, known ? at->lod : -1);
    if (!known) {
        mark(viewer);
        set.visible.insert(at, {entity, lod});
        set.entered.push_back({entity, lod});
    } else if (at->lod != lod) {
        mark(viewer);
        at->lod = lod;
        set.lod_changed.push_back({entity, lod});
    }
}

/// The viewer's set is not as it was a tick ago.
void Matcher::mark(std::uint32_t viewer) {
    world::VisibleSet& set = (*out_)[viewer];
    if (!set.changed) {
        set.changed = true;
        marked_.push_back(viewer);
    }
}

}  // namespace zoned::interest

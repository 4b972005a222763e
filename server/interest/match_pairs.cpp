// build: hot loops
#include "server/interest/matcher.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace zoned::interest {

namespace {

constexpr float kReachSlack = 1.0001F;
constexpr std::size_t kRoom = 4;
// More notes than blocks over this: to lay out where all were costs less than to pending it up for
// each that was noted.
constexpr std::size_t kLayOutShare = 2;
constexpr float kNearest =
    1e-6F;  // of the coordinates: the rounding error of a difference of floats

}  // namespace

/// Merges a viewer's new set, by all pairs near it, with its last one.
void Matcher::refresh(std::size_t viewer) {
    const MatchedViewer& add_viewers = matched_viewers_[viewer];
    const ViewCone cone = viewer_cone_.empty() ? ViewCone{} : viewer_cone_[viewer];
    const float reach = std::max(viewer_nimbus_[viewer], cone.length_m);
    std::size_t found = 0;
    if (add_viewers.row != world::kNoRow && reach > 0.0F) {
        found = entity_grid_.gather(
            viewer_x_[viewer], viewer_z_[viewer], reach, widen_, add_viewers.row, near_.data());
    }
    if (cone.length_m > 0.0F) {
        found = keep_within_cone(viewer, cone, found);
    }
    sorted_.resize(found);
    for (std::size_t i = 0; i < found; ++i) {
        sorted_[i] = (static_cast<std::uint64_t>(moved_set_.id(near_[i]).value) << 32U) | near_[i];
    }
    std::sort(sorted_.begin(), sorted_.end());
    merge(viewer, cone, found);
    world::VisibleSet& set = (*out_)[viewer];
    set.changed = fresh_flag_[viewer] != kFreshByCone || !set.entered.empty() ||
                  !set.left.empty() || !set.lod_changed.empty();
    if (set.changed) {
        marked_.push_back(static_cast<std::uint32_t>(viewer));
    }
    matched_viewers_[viewer].stamp = next_stamp_++;
    set.stamp = matched_viewers_[viewer].stamp;
}

/// Of the near entities, those that may be heard at all: a cone holds a small part of its disc, and
/// the rest is sorted.
std::size_t Matcher::keep_within_cone(std::size_t viewer,
                                      const ViewCone& cone,
                                      std::size_t candidates) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < candidates; ++i) {
        const world::Row row = near_[i];
        const bool heard = hears(moved_set_.x(row) - viewer_x_[viewer],
                                 moved_set_.z(row) - viewer_z_[viewer],
                                 viewer_nimbus_[viewer],
                                 cone,
                                 moved_set_.aura_m(row),
                                 true,
                                 settings_.hysteresis);
        near_[kept] = row;
        kept += heard ? 1 : 0;
    }
    return kept;
}

/// Merges the candidates with the last set, both ascending by entity.
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
        const float dx = moved_set_.x(row) - viewer_x_[viewer];
        const float dz = moved_set_.z(row) - viewer_z_[viewer];
        const float distance_squared = dx * dx + dz * dz;
        if (!hears(dx,
                   dz,
                   viewer_nimbus_[viewer],
                   cone,
                   moved_set_.aura_m(row),
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
    // Room for some that enter and leave: where all sets are new at once, the next ticks would
    // allocate for each of them otherwise.
    set.visible.reserve(scratch_.size() + scratch_.size() / 4 + kRoom);
    set.visible.assign(scratch_.begin(), scratch_.end());
    set.entered.reserve(kRoom);
    set.left.reserve(kRoom);
    set.lod_changed.reserve(kRoom);
}

void Matcher::enclose_viewers() {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    viewers_.x0 = viewers_.z0 = kInfinity;
    viewers_.x1 = viewers_.z1 = -kInfinity;
    for (std::size_t i = 0; i < matched_viewers_.size(); ++i) {
        if (viewer_nimbus_[i] > 0.0F) {
            viewers_.x0 = std::min({viewers_.x0, viewer_x_[i], viewer_old_x_[i]});
            viewers_.x1 = std::max({viewers_.x1, viewer_x_[i], viewer_old_x_[i]});
            viewers_.z0 = std::min({viewers_.z0, viewer_z_[i], viewer_old_z_[i]});
            viewers_.z1 = std::max({viewers_.z1, viewer_z_[i], viewer_old_z_[i]});
        }
    }
}

/// Entities that changed against the viewers near the place that they left and the one they came
/// to.
void Matcher::cross_changes() {
    for (const EntityChange& change : moved_set_.changes()) {
        const bool here = change.row != world::kNoRow && moved_set_.aura_m(change.row) > 0.0F;
        const bool was = change.old_aura_m > 0.0F;
        ThresholdCrossings test;
        test.x = here ? moved_set_.x(change.row) : change.old_x;
        test.z = here ? moved_set_.z(change.row) : change.old_z;
        test.old_x = was ? change.old_x : test.x;
        test.old_z = was ? change.old_z : test.z;
        test.radius_m = here ? moved_set_.aura_m(change.row) : 0.0F;
        test.old_radius_m = change.old_aura_m;
        test.widen = widen_;
        test.lods = &lods_;
        const PendingPair pending{0, change.entity, change.row};
        if (was) {
            cross_viewers(test, pending, MatchBox(test.old_x, test.old_z, test.old_x, test.old_z));
        }
        if (here) {
            cross_viewers(test, pending, MatchBox(test.x, test.z, test.x, test.z));
        }
    }
}

/// Entities that stepped against the viewers near them. These are few and near each other in
/// memory: the order of the entities does not matter.
void Matcher::cross_steps() {
    for (const world::Row row : moved_set_.steps()) {
        if (!(moved_set_.aura_m(row) > 0.0F)) {
            continue;
        }
        ThresholdCrossings test;
        test.x = moved_set_.x(row);
        test.z = moved_set_.z(row);
        test.old_x = moved_set_.old_x(row);
        test.old_z = moved_set_.old_z(row);
        test.radius_m = moved_set_.aura_m(row);
        test.old_radius_m = test.radius_m;
        test.widen = widen_;
        test.lods = &lods_;
        cross_viewers(test, {0, EntityId(), row}, MatchBox(test.x, test.z, test.old_x, test.old_z));
    }
}

Matcher::MatchBox::MatchBox(float x, float z, float other_x, float other_z)
    : x0(std::min(x, other_x)),
      x1(std::max(x, other_x)),
      z0(std::min(z, other_z)),
      z1(std::max(z, other_z)) {
}

/// A little more than by that much, so that rounding never decides.
void Matcher::MatchBox::widen(float by_m) {
    const float by_x = by_m * kReachSlack + kNearest * std::max(std::abs(x0), std::abs(x1));
    const float by_z = by_m * kReachSlack + kNearest * std::max(std::abs(z0), std::abs(z1));
    x0 -= by_x;
    x1 += by_x;
    z0 -= by_z;
    z1 += by_z;
}

/// Against the viewers near the places, as if they stood where they were a tick ago.
void Matcher::cross_viewers(const ThresholdCrossings& test,
                            const PendingPair& pending,
                            const MatchBox& places) {
    const float radius = std::max(test.radius_m, test.old_radius_m);
    MatchBox box = places;
    box.widen(std::min(radius, largest_nimbus_m_) * widen_);
    // Most of a large world is far from every viewer.
    if (box.x1 < viewers_.x0 || box.x0 > viewers_.x1 || box.z1 < viewers_.z0 ||
        box.z0 > viewers_.z1) {
        return;
    }
    const auto visit = [&](std::uint32_t viewer) {
        pending_pairs_.push_back({viewer, pending.gone, pending.row});
    };
    if (viewer_grid_.all_reach(radius)) {
        viewer_grid_.for_each_chosen<true>(box.x0, box.x1, box.z0, box.z1, test, visit);
    } else {
        viewer_grid_.for_each_chosen<false>(box.x0, box.x1, box.z0, box.z1, test, visit);
    }
}

/// All places from which the viewer hears now or heard a tick ago.
Matcher::MatchBox Matcher::box_around(std::uint32_t viewer) const {
    MatchBox box(
        viewer_x_[viewer], viewer_z_[viewer], viewer_old_x_[viewer], viewer_old_z_[viewer]);
    box.widen(std::min(viewer_nimbus_[viewer], moved_set_.largest_aura_m()) * widen_);
    return box;
}

/// A viewer that stepped against the entities near it, as if these stood where they are: that they
/// stepped has been seen to, and changes as well.
void Matcher::cross_entities(std::uint32_t viewer) {
    if (fresh_flag_[viewer] != 0 || !(viewer_nimbus_[viewer] > 0.0F)) {
        return;
    }
    ThresholdCrossings test;
    test.x = viewer_x_[viewer];
    test.z = viewer_z_[viewer];
    test.old_x = viewer_old_x_[viewer];
    test.old_z = viewer_old_z_[viewer];
    test.radius_m = viewer_nimbus_[viewer];
    test.old_radius_m = test.radius_m;
    test.widen = widen_;
    test.lods = &lods_;
    const MatchBox box = box_around(viewer);
    const auto visit = [&](std::uint32_t row) {
        pending_pairs_.push_back({viewer, EntityId(), row});
    };
    if (entity_grid_.all_reach(test.radius_m)) {
        entity_grid_.for_each_chosen<true>(box.x0, box.x1, box.z0, box.z1, test, visit);
    } else {
        entity_grid_.for_each_chosen<false>(box.x0, box.x1, box.z0, box.z1, test, visit);
    }
}

/// A viewer against the entities near it, with or without a step by them; sift() knows more.
void Matcher::cross_all(std::uint32_t viewer) {
    if (fresh_flag_[viewer] != 0 || !(viewer_nimbus_[viewer] > 0.0F)) {
        return;
    }
    const float x = viewer_x_[viewer];
    const float z = viewer_z_[viewer];
    const float nimbus = viewer_nimbus_[viewer];
    const float stride_x = x - viewer_old_x_[viewer];
    const float stride_z = z - viewer_old_z_[viewer];
    const float step = std::sqrt(stride_x * stride_x + stride_z * stride_z) * kReachSlack;
    const NearThresholds test(x, z, nimbus, widen_, step + entity_step_m_, lods_);
    MatchBox box = box_around(viewer);
    box.widen(entity_step_m_);
    if (notes_.size() < noted_ + entity_grid_.blocks() + 1) {
        notes_.resize(2 * noted_ + entity_grid_.blocks() + 1);
    }
    IncrementalGrid::Note* out = notes_.data() + noted_;
    noted_ +=
        entity_grid_.all_reach(nimbus)
            ? entity_grid_.note_chosen<true>(box.x0, box.x1, box.z0, box.z1, test, viewer, out)
            : entity_grid_.note_chosen<false>(box.x0, box.x1, box.z0, box.z1, test, viewer, out);
}

/// Looks at those pairs of the notes that came across a step.
void Matcher::sift() {
    if (noted_ > entity_grid_.blocks() / kLayOutShare) {
        sift_blocks();
        return;
    }
    constexpr std::size_t kSoon = 8;
    constexpr std::size_t kLater = 16;
    const auto key_of = [&](const IncrementalGrid::Note& note) {
        return entity_grid_.key_at(note.block,
                                   static_cast<std::uint32_t>(std::countr_zero(note.mask)));
    };
    for (std::size_t i = 0; i < noted_; ++i) {
        if (i + kLater < noted_) {
            entity_grid_.prefetch(notes_[i + kLater].block);
            moved_set_.prefetch_step(key_of(notes_[i + kSoon]));
        }
        const std::uint32_t viewer = notes_[i].asker;
        for (IncrementalGrid::Note note = notes_[i]; note.mask != 0; note.mask &= note.mask - 1) {
            const world::Row row = key_of(note);
            const float dx = moved_set_.x(row) - viewer_x_[viewer];
            const float dz = moved_set_.z(row) - viewer_z_[viewer];
            const float old_dx = moved_set_.old_x(row) - viewer_old_x_[viewer];
            const float old_dz = moved_set_.old_z(row) - viewer_old_z_[viewer];
            if (crossed(dx * dx + dz * dz,
                        old_dx * old_dx + old_dz * old_dz,
                        std::min(viewer_nimbus_[viewer], moved_set_.aura_m(row)),
                        widen_,
                        lods_)) {
                pending_pairs_.push_back({viewer, EntityId(), row});
            }
        }
    }
}

/// The same where there are many: eight at a time, in places that lie near each other.
void Matcher::sift_blocks() {
    entity_grid_.lay_out(moved_set_.old_xs(), moved_set_.old_zs(), old_places_);
    MutualCrossings test;
    test.widen = widen_;
    test.lods = &lods_;
    for (std::size_t i = 0; i < noted_; ++i) {
        const IncrementalGrid::Note& note = notes_[i];
        const std::uint32_t viewer = note.asker;
        test.x = viewer_x_[viewer];
        test.z = viewer_z_[viewer];
        test.old_x = viewer_old_x_[viewer];
        test.old_z = viewer_old_z_[viewer];
        test.radius_m = viewer_nimbus_[viewer];
        test.old_xs = old_places_[note.block].x.data();
        test.old_zs = old_places_[note.block].z.data();
        std::uint32_t mask = note.mask & (entity_grid_.all_reach(test.radius_m)
                                              ? entity_grid_.chosen_of<true>(note.block, test)
                                              : entity_grid_.chosen_of<false>(note.block, test));
        for (; mask != 0; mask &= mask - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(mask));
            pending_pairs_.push_back({viewer, EntityId(), entity_grid_.key_at(note.block, lane)});
        }
    }
}

/// The entity that a pending is about.
EntityId Matcher::entity_of(const PendingPair& pending) const {
    return pending.row == world::kNoRow ? pending.gone : moved_set_.id(pending.row);
}

/// The sets lie far apart in memory, so they are prefetched some pairs ahead. First comes the part
/// of a set that the search for the entity reads first, and then the part that it reads last.
void Matcher::settle_pairs() {
    constexpr std::size_t kSoon = 6;
    constexpr std::size_t kLater = 12;
    constexpr std::size_t kLast = 18;
    for (std::size_t i = 0; i < pending_pairs_.size(); ++i) {
        if (i + kLast < pending_pairs_.size()) {
            const PendingPair& last = pending_pairs_[i + kLast];
            __builtin_prefetch(&(*out_)[last.viewer]);
            moved_set_.prefetch(last.row);
        }
        if (i + kLater < pending_pairs_.size()) {
            const std::vector<world::Visible>& later =
                (*out_)[pending_pairs_[i + kLater].viewer].visible;
            const world::Visible* data = later.data();
            const std::size_t quarter = later.size() / 4;
            __builtin_prefetch(data + quarter);
            __builtin_prefetch(data + 2 * quarter);
            __builtin_prefetch(data + 3 * quarter);
        }
        if (i + kSoon < pending_pairs_.size()) {
            const PendingPair& soon = pending_pairs_[i + kSoon];
            const std::vector<world::Visible>& set = (*out_)[soon.viewer].visible;
            const EntityId entity = entity_of(soon);
            const world::Visible* at = set.data();
            const std::size_t quarter = set.size() / 4;
            if (quarter > 0) {
                at += at[2 * quarter].entity < entity ? 2 * quarter : 0;
                at += at[quarter].entity < entity ? quarter : 0;
                for (std::size_t next = 0; next < quarter; next += 8) {
                    __builtin_prefetch(at + next);
                }
            }
        }
        settle_pair(pending_pairs_[i]);
    }
    pending_pairs_.clear();
}

/// The rule for one pair, by the viewer's last set. To do it twice changes nothing.
void Matcher::settle_pair(const PendingPair& pending) {
    const std::uint32_t viewer = pending.viewer;
    const world::Row row = pending.row;
    const EntityId entity = entity_of(pending);
    const MatchedViewer& add_viewers = matched_viewers_[viewer];
    if (fresh_flag_[viewer] != 0 || row == add_viewers.row) {
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
        const float dx = moved_set_.x(row) - viewer_x_[viewer];
        const float dz = moved_set_.z(row) - viewer_z_[viewer];
        distance_squared = dx * dx + dz * dz;
        heard = hears(distance_squared,
                      viewer_nimbus_[viewer],
                      moved_set_.aura_m(row),
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

#include "server/zone/viewers/visibility_filter.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

namespace zoned::zone {

namespace {

// From the centre of a shape up, as a share of the distance to its top.
constexpr float kEyes = 0.9F;
// The surface that something flies off does not block its flight.
constexpr float kOnSurface_m = 0.1F;

float half_height(const world::EntityType& type) {
    switch (type.shape) {
        case world::TypeShape::kBox:
        case world::TypeShape::kSoft:
            return type.half_extents.y();
        case world::TypeShape::kCapsule:
            return type.radius + type.half_segment;
        case world::TypeShape::kSphere:
        case world::TypeShape::kSolid:
            break;
    }
    return type.radius;
}

Vec3 eyes_of(const ZoneState& state, world::Row viewer) {
    const world::Entities& e = state.entities;
    const world::EntityType& type = (*state.settings.types)[e.type[viewer]];
    return e.position[viewer] + Vec3(0.0F, kEyes * half_height(type), 0.0F);
}

bool in_sight(const ZoneState& state, world::Row viewer, world::Row entity) {
    const world::Entities& e = state.entities;
    const world::TypeTable& types = *state.settings.types;
    const Vec3 eyes = eyes_of(state, viewer);
    const float top = kEyes * half_height(types[e.type[entity]]);
    for (const float up : {0.0F, top}) {
        const Vec3 way = e.position[entity] + Vec3(0.0F, up, 0.0F) - eyes;
        const float distance = way.norm();
        if (!(distance > 1e-3F)) {
            return true;
        }
        physics::RayHit hit;
        const bool blocked =
            state.scene.ray_cast(eyes, way / distance, distance, e.id[viewer].value, hit);
        if (!blocked || EntityId(hit.user) == e.id[entity]) {
            return true;
        }
    }
    return false;
}

/// The viewer's sights are of those it hears of by the radii and whose type conceals itself.
void list_sights(const ZoneState& state,
                 const world::VisibleSet& heard,
                 ViewerFilter& sights,
                 std::vector<FilteredPair>& now) {
    now.clear();
    auto old = sights.seen.begin();
    for (const world::Visible& v : heard.visible) {
        const world::Row row = state.entities.find(v.entity);
        const world::EntityType& type = (*state.settings.types)[state.entities.type[row]];
        if (type.visibility_filter == world::VisibilityFilter::kNothing) {
            continue;
        }
        while (old != sights.seen.end() && old->entity < v.entity) {
            ++old;
        }
        const bool was = old != sights.seen.end() && old->entity == v.entity;
        now.push_back(was ? *old : FilteredPair{v.entity, -1, false, -1, -1});
    }
    sights.seen.assign(now.begin(), now.end());
}

void ask(ZoneState& state, const RulesContext& context) {
    FilteredVisibility& c = state.filtered;
    const auto again = static_cast<Tick>((state.settings.visibility_filter.stale_ticks + 1) / 2);
    std::vector<DuePair>& due = c.due;
    due.clear();
    for (std::uint32_t i = 0; i < c.viewers.size(); ++i) {
        for (std::uint32_t k = 0; k < c.viewers[i].seen.size(); ++k) {
            const FilteredPair& sight = c.viewers[i].seen[k];
            if (sight.asked < 0 || state.now - sight.asked >= again) {
                due.push_back({sight.asked, i, k});
            }
        }
    }
    std::sort(due.begin(), due.end(), [](const DuePair& a, const DuePair& b) {
        return std::tie(a.asked, a.viewer, a.sight) < std::tie(b.asked, b.viewer, b.sight);
    });
    const std::size_t budget = state.settings.visibility_filter.checks_per_tick;
    c.overdue = static_cast<std::uint32_t>(due.size() - std::min(due.size(), budget));
    due.resize(std::min(due.size(), budget));
    for (const DuePair& d : due) {
        FilteredPair& sight = c.viewers[d.viewer].seen[d.sight];
        const world::Row viewer = state.entities.find(state.viewers[d.viewer].avatar);
        const world::Row row = state.entities.find(sight.entity);
        sight.asked = state.now;
        sight.answer = viewer != world::kNoRow && row != world::kNoRow &&
                       may_know(state, context, viewer, row);
    }
    c.checks = static_cast<std::uint32_t>(due.size());
}

/// Makes the ViewerFilter and sets of all viewers, in the order of the matcher's sets; known
/// entities stay. Says which sets are new.
void align_viewers(FilteredVisibility& c, world::Visibility& notified) {
    const auto client_of = [](const auto& of) {
        return of.client;
    };
    world::align(c.viewers, c.aligned_viewers, c.heard, client_of, [](const auto& set) {
        return ViewerFilter{set.client, {}};
    });
    c.fresh.clear();
    world::align(
        notified, c.aligned_notified, c.heard, client_of, [&](const world::VisibleSet& set) {
            c.fresh.push_back(set.client);
            world::VisibleSet empty;
            empty.client = set.client;
            return empty;
        });
}

/// Whether the entity stays in a viewer's set; not concealed: always.
class Sieve {
  public:
    Sieve(const ZoneState& state, ViewerFilter& sights)
        : state_(&state),
          sights_(&sights),
          at_(sights.seen.begin()) {}

    /// For ascending entities.
    bool passes(EntityId entity) {
        while (at_ != sights_->seen.end() && at_->entity < entity) {
            ++at_;
        }
        if (at_ == sights_->seen.end() || at_->entity != entity) {
            return true;
        }
        const VisibilityFilterSettings& s = state_->settings.visibility_filter;
        if (at_->answer && at_->asked >= 0 &&
            state_->now - at_->asked < static_cast<Tick>(s.stale_ticks)) {
            at_->known = state_->now;
        }
        const bool known =
            at_->known >= 0 && state_->now - at_->known <= static_cast<Tick>(s.grace_ticks);
        at_->since = !known ? -1 : (at_->since < 0 ? state_->now : at_->since);
        return known;
    }

  private:
    const ZoneState* state_;
    ViewerFilter* sights_;
    std::vector<FilteredPair>::iterator at_;
};

/// The difference between the viewer's last and present knowledge.
void compare(const std::vector<world::Visible>& before, world::VisibleSet& set) {
    set.entered.clear();
    set.left.clear();
    set.lod_changed.clear();
    auto old = before.begin();
    for (const world::Visible& v : set.visible) {
        while (old != before.end() && old->entity < v.entity) {
            set.left.push_back((old++)->entity);
        }
        if (old == before.end() || old->entity != v.entity) {
            set.entered.push_back(v);
        } else {
            if (old->lod != v.lod) {
                set.lod_changed.push_back(v);
            }
            ++old;
        }
    }
    for (; old != before.end(); ++old) {
        set.left.push_back(old->entity);
    }
    set.changed = !set.entered.empty() || !set.left.empty() || !set.lod_changed.empty();
}

}  // namespace

bool may_know(const ZoneState& state,
              const RulesContext& context,
              world::Row viewer,
              world::Row entity) {
    const world::Entities& e = state.entities;
    switch ((*state.settings.types)[e.type[entity]].visibility_filter) {
        case world::VisibilityFilter::kNothing:
            return true;
        case world::VisibilityFilter::kLineOfSight:
            return in_sight(state, viewer, entity);
        case world::VisibilityFilter::kRules:
            break;
    }
    return state.rules->may_hear(context, e.id[viewer], e.id[entity]);
}

bool sees_place(const ZoneState& state, world::Row viewer, const Vec3& place) {
    const Vec3 eyes = eyes_of(state, viewer);
    const Vec3 way = place - eyes;
    const float distance = way.norm();
    if (!(distance > kOnSurface_m)) {
        return true;
    }
    physics::RayHit hit;
    return !state.scene.ray_cast(
        eyes, way / distance, distance - kOnSurface_m, state.entities.id[viewer].value, hit);
}

std::uint32_t filter_visibility(ZoneState& state, const RulesContext& context) {
    FilteredVisibility& c = state.filtered;
    align_viewers(c, state.visibility);
    for (std::size_t i = 0; i < c.heard.size(); ++i) {
        if (c.heard[i].changed) {
            list_sights(state, c.heard[i], c.viewers[i], c.listed);
        }
    }
    ask(state, context);
    for (std::size_t i = 0; i < c.heard.size(); ++i) {
        world::VisibleSet& notified = state.visibility[i];
        c.before.assign(notified.visible.begin(), notified.visible.end());
        notified.visible.clear();
        Sieve sieve(state, c.viewers[i]);
        for (const world::Visible& v : c.heard[i].visible) {
            if (sieve.passes(v.entity)) {
                notified.visible.push_back(v);
            }
        }
        const bool fresh = std::binary_search(c.fresh.begin(), c.fresh.end(), notified.client);
        compare(c.before, notified);
        // A set that is new here is new to replication too, even where it is empty.
        notified.changed = notified.changed || fresh;
    }
    return c.checks;
}

const FilteredPair* find_filtered_pair(const ZoneState& state, ClientId client, EntityId entity) {
    const std::vector<ViewerFilter>& viewers = state.filtered.viewers;
    const auto viewer = std::lower_bound(
        viewers.begin(), viewers.end(), client, [](const ViewerFilter& s, ClientId id) {
            return s.client < id;
        });
    if (viewer == viewers.end() || viewer->client != client) {
        return nullptr;
    }
    const auto at = std::lower_bound(
        viewer->seen.begin(), viewer->seen.end(), entity, [](const FilteredPair& s, EntityId id) {
            return s.entity < id;
        });
    return at != viewer->seen.end() && at->entity == entity ? &*at : nullptr;
}

}  // namespace zoned::zone

#include "server/zone/viewers/audit.h"

#include "server/zone/viewers/visibility_filter.h"
#include "shared/core/elementary/elementary.h"
#include "shared/wire/quantize.h"

#include <algorithm>
#include <cmath>

namespace zoned::zone {

namespace {

/// The level of detail that is promised at a distance: the plain radii, without the matcher's lead
/// or hysteresis.
std::size_t promised_lod(const ZoneSettings& settings, float distance) {
    const auto& radii = settings.interest.lod_radius_m;
    std::size_t lod = 0;
    while (lod < radii.size() && distance > radii[lod]) {
        ++lod;
    }
    return std::min(lod, settings.replication.lods.size() - 1);
}

void copy_position(const Vec3d& from, double (&to)[3]) {
    to[0] = from.x();
    to[1] = from.y();
    to[2] = from.z();
}

/// A frozen world is at rest: every client must hold this state in the end, to the last bit.
std::vector<std::int32_t> frozen_integers(const ZoneState& state, world::Row row) {
    const world::Entities& e = state.entities;
    const bool upright = (*state.settings.types)[e.type[row]].upright();
    const wire::QuantizedState q = wire::quantize(e.kinematic(row),
                                                  motion::PredictorOrder::kStatic,
                                                  upright,
                                                  true,
                                                  e.appearance[row],
                                                  state.settings.replication.quantization);
    return {q.position[0],
            q.position[1],
            q.position[2],
            q.orientation_largest,
            q.orientation[0],
            q.orientation[1],
            q.orientation[2],
            static_cast<std::int32_t>(q.appearance)};
}

mailbox::AuditEntity audit_entity(const ZoneState& state,
                                  world::Row row,
                                  ClientId client,
                                  const Vec3& viewer) {
    const world::Entities& e = state.entities;
    const Vec3d origin = state.settings.region().origin();
    mailbox::AuditEntity a;
    a.entity = e.id[row];
    a.type = e.type[row];
    copy_position(origin + e.position[row].cast<double>(), a.position);
    const Quat& q = e.orientation[row];
    a.orientation[0] = q.w();
    a.orientation[1] = q.x();
    a.orientation[2] = q.y();
    a.orientation[3] = q.z();
    a.distance_m =
        elementary::hypot(e.position[row].x() - viewer.x(), e.position[row].z() - viewer.z());
    const std::size_t lod = promised_lod(state.settings, a.distance_m);
    a.bound_m = state.settings.replication.lods[lod].position_m;
    a.bound_rad = state.settings.replication.lods[lod].orientation_rad;
    a.discontinuity_tick = e.discontinuity_tick[row];
    a.radii_tick = state.audited_radii[row].changed;
    a.breach_tick = state.replicator.switch_tick(client, a.entity);
    for (std::size_t k = 0; k < state.settings.replication.lods.size(); ++k) {
        a.breach_tick = std::max(
            a.breach_tick, state.replicator.breach_tick(a.entity, static_cast<std::uint8_t>(k)));
    }
    const auto fields = e.field_values(row);
    a.field_words.assign(fields.begin(), fields.end());
    for (const std::uint32_t tick : e.fields().changed(row, a.type)) {
        a.field_ticks.push_back(static_cast<Tick>(tick));
    }
    if (state.frozen) {
        a.quantized = frozen_integers(state, row);
    }
    return a;
}

enum class Filtered : std::uint8_t {
    kNo,
    kPerhaps,  ///< it came or went since the last record: the client may know of it or not
    kYes
};

/// The truth of this moment, asked again. The past counts only as far as answers may be stale, a
/// known entity stays known, and the client has had no record. Radii have a hysteresis, sight has
/// none: within a period an entity may go and come back, or come and go, and the news of the last
/// change is still on its way.
Filtered filtered(const ZoneState& state,
                  const RulesContext& context,
                  ClientId client,
                  world::Row avatar,
                  world::Row row) {
    const world::Entities& e = state.entities;
    if ((*state.settings.types)[e.type[row]].visibility_filter ==
        world::VisibilityFilter::kNothing) {
        return Filtered::kNo;
    }
    const bool seen = may_know(state, context, avatar, row);
    const FilteredPair* sight = find_filtered_pair(state, client, e.id[row]);
    const auto period = static_cast<Tick>(state.settings.audit.period_ticks);
    if (seen) {
        const bool settled =
            sight != nullptr && sight->since >= 0 && state.now - sight->since >= period;
        return settled ? Filtered::kNo : Filtered::kPerhaps;
    }
    const Tick past = static_cast<Tick>(state.settings.visibility_filter.grace_ticks) + period;
    const bool lately = sight != nullptr && sight->known >= 0 && state.now - sight->known <= past;
    return lately ? Filtered::kPerhaps : Filtered::kYes;
}

}  // namespace

void follow_radii(ZoneState& state) {
    const world::Entities& e = state.entities;
    std::vector<AuditedRadii>& radii = state.audited_radii;
    const bool aligned = std::equal(
        radii.begin(), radii.end(), e.id.begin(), e.id.end(), [](const auto& r, EntityId id) {
            return r.entity == id;
        });
    if (!aligned) {
        std::vector<AuditedRadii> before(std::move(radii));
        const auto by_entity = [](const AuditedRadii& a, const AuditedRadii& b) {
            return a.entity < b.entity;
        };
        std::sort(before.begin(), before.end(), by_entity);
        radii.clear();
        for (world::Row row = 0; row < e.size(); ++row) {
            const AuditedRadii fresh{e.id[row], e.stance[row], 0};
            const auto at = std::lower_bound(before.begin(), before.end(), fresh, by_entity);
            radii.push_back(at != before.end() && at->entity == fresh.entity ? *at : fresh);
        }
    }
    for (world::Row row = 0; row < e.size(); ++row) {
        if (radii[row].stance != e.stance[row]) {
            radii[row].stance = e.stance[row];
            radii[row].changed = state.now;
        }
    }
}

bool audit_due(const ZoneState& state, const ZoneClient& client) {
    if ((client.rights & mailbox::kRightAudit) == 0 || !state.settings.audit.enabled) {
        return false;
    }
    const auto period = static_cast<Tick>(state.settings.audit.period_ticks);
    return client.audit_due || (state.now + static_cast<Tick>(client.client.value)) % period == 0;
}

mailbox::AuditRecord audit(const ZoneState& state,
                           const RulesContext& context,
                           const ZoneClient& client) {
    mailbox::AuditRecord record;
    record.client = client.client;
    record.tick = state.now;
    record.zone = state.settings.id;
    record.frozen = state.frozen;
    const world::Row avatar = state.entities.find(client.avatar);
    if (avatar == world::kNoRow) {
        return record;
    }
    const Vec3& viewer = state.entities.position[avatar];
    copy_position(state.settings.region().origin() + viewer.cast<double>(), record.avatar_position);
    record.avatar_discontinuity_tick = state.entities.discontinuity_tick[avatar];
    record.avatar_radii_tick = state.audited_radii[avatar].changed;

    std::vector<world::Row> inner;
    std::vector<world::Row> outer;
    interest::brute_force(state.entities,
                          *state.settings.types,
                          {client.client, client.avatar},
                          state.settings.interest,
                          inner,
                          outer);
    for (const world::Row row : outer) {
        const Filtered hidden = filtered(state, context, client.client, avatar, row);
        if (hidden == Filtered::kYes) {
            continue;  // the client ought not to know of it
        }
        mailbox::AuditEntity entity = audit_entity(state, row, client.client, viewer);
        entity.must_know =
            hidden == Filtered::kNo && std::find(inner.begin(), inner.end(), row) != inner.end();
        record.entities.push_back(std::move(entity));
    }
    std::sort(record.entities.begin(), record.entities.end(), [](const auto& a, const auto& b) {
        return a.entity < b.entity;
    });
    record.updates_since = state.replicator.unacknowledged(client.client, record.updates);
    return record;
}

}  // namespace zoned::zone

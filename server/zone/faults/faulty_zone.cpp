#include "server/zone/faults/faulty_zone.h"

#include "server/zone/census.h"
#include "server/zone/faults/broken_rules.h"
#include "shared/core/assert.h"
#include "shared/wire/packet.h"

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

namespace zoned::zone {

namespace {

bool listed(const world::VisibleSet& set, EntityId entity) {
    return std::any_of(set.visible.begin(), set.visible.end(), [&](const world::Visible& v) {
        return v.entity == entity;
    });
}

/// The owned entity farthest from the viewer.
EntityId farthest(const ZoneState& state, const Vec3& from) {
    const world::Entities& e = state.entities;
    EntityId best;
    float best_d2 = -1.0F;
    for (world::Row row = 0; row < e.size(); ++row) {
        const float d2 = (e.position[row] - from).squaredNorm();
        if (!e.has(row, world::kHidden) && !e.client[row] && d2 > best_d2) {
            best_d2 = d2;
            best = e.id[row];
        }
    }
    return best;
}

/// The farthest owned entity enters the set of a viewer, whatever its radii are.
void leak_farthest(const ZoneState& state, const Vec3& viewer, world::VisibleSet& set) {
    const EntityId far = farthest(state, viewer);
    if (!far || listed(set, far)) {
        return;
    }
    const auto at = std::lower_bound(
        set.visible.begin(), set.visible.end(), far, [](const world::Visible& v, EntityId id) {
            return v.entity < id;
        });
    const auto lod = static_cast<std::uint8_t>(state.settings.replication.lods.size() - 1);
    set.visible.insert(at, {far, lod});
}

}  // namespace

FaultyZone::FaultyZone(ZoneSettings settings,
                       const FaultSettings& faults,
                       std::unique_ptr<Rules> rules,
                       Stopwatch stopwatch)
    : Zone(std::move(settings),
           faults.broken
               ? std::make_unique<BrokenRules>(std::move(rules), *faults.broken, faults.broken_at)
               : std::move(rules),
           stopwatch),
      faults_(faults) {
}

bool FaultyZone::stalled(Tick now) const {
    return faults_.stall_ticks > 0 && now >= faults_.stall_from &&
           now < faults_.stall_from + faults_.stall_ticks;
}

void FaultyZone::simulate(Tick now, std::span<const mailbox::InboxItem> inbox) {
    if (!stalled(now)) {
        Zone::simulate(now, inbox);
        drop_decisions();
        return;
    }
    ZoneState& s = state();
    s.now = now;
    s.out.clear();
    s.report = StepReport{};
    s.report.tick = now;
    s.report.census = take_census(s, inbox.size());
    s.report.plan.reason.fill("stalled on purpose");
}

void FaultyZone::publish() {
    if (!stalled(state().now)) {
        Zone::publish();
    }
}

/// Events that clients must confirm reach some of them never.
void FaultyZone::drop_decisions() {
    ZoneState& s = state();
    for (PendingEvent& pending : s.out.events) {
        if (pending.audience == Audience::kClient && pending.event.confirm) {
            std::erase_if(pending.event.recipients, [&](ClientId client) {
                return faults_.drop_decision.hits(client.value, s.now);
            });
        }
    }
}

void FaultyZone::alter_sets(const world::Visibility& sets) {
    const ZoneState& s = state();
    altered_ = sets;
    for (std::size_t i = 0; i < altered_.size(); ++i) {
        world::VisibleSet& set = altered_[i];
        set.changed = true;
        if (s.filters_visibility && faults_.leak_filtered.hits(set.client.value, s.now)) {
            ZONED_ASSERT(s.filtered.heard[i].client == set.client, "the filter keeps their order");
            set.visible = s.filtered.heard[i].visible;
        }
        std::erase_if(set.visible, [&](const world::Visible& v) {
            return faults_.hide.hits(v.entity.value, s.now);
        });
        const world::Row avatar = s.entities.find(s.viewers[i].avatar);
        if (avatar != world::kNoRow && faults_.leak.hits(set.client.value, s.now)) {
            leak_farthest(s, s.entities.position[avatar], set);
        }
    }
}

/// Some entities are shifted by the offset (sign +1) and back (sign -1).
void FaultyZone::shift_positions(float sign) {
    ZoneState& s = state();
    for (world::Row row = 0; row < s.entities.size(); ++row) {
        if (faults_.corrupt.hits(s.entities.id[row].value, s.now)) {
            s.entities.position[row].x() += sign * faults_.corrupt_offset_m;
        }
    }
}

/// The first declared field of some entities has another value, and then its own again.
void FaultyZone::shift_fields(bool there) {
    world::Entities& e = state().entities;
    if (!e.fields().any() || faults_.corrupt_field.share <= 0.0) {
        return;
    }
    true_fields_.resize(e.size());
    for (world::Row row = 0; row < e.size(); ++row) {
        const wire::FieldSchema* schema = e.fields().schema(e.type[row]);
        if (schema == nullptr || !faults_.corrupt_field.hits(e.id[row].value, state().now)) {
            continue;
        }
        if (!there) {
            e.put_field_block(row, true_fields_[row]);
            continue;
        }
        const auto block = e.fields().block(row, e.type[row]);
        true_fields_[row].assign(block.begin(), block.end());
        const wire::DeclaredField& first = schema->fields()[0];
        std::vector<std::uint32_t> shifted = true_fields_[row];
        if (first.kind == wire::DeclaredKind::kText) {
            wire::put_value(
                first, std::string_view("?"), wire::words_of(first, std::span(shifted)));
        } else {
            shifted[0] = shifted[0] < first.most ? shifted[0] + 1 : 0;
        }
        e.put_field_block(row, shifted);
    }
}

void FaultyZone::hide_wider_bounds() {
    for (mailbox::StatePacket& packet : state().out.packets) {
        const auto parsed = wire::read_down_head(packet.body);
        if (parsed.ok() && parsed->head.has_widened) {
            wire::rewrite_widened(wire::Widened{}, packet.body);
        }
    }
}

std::uint32_t FaultyZone::replicate(const world::Visibility& sets) {
    alter_sets(sets);
    shift_positions(1.0F);
    shift_fields(true);
    const std::uint32_t packets = Zone::replicate(altered_);
    shift_positions(-1.0F);
    shift_fields(false);
    if (faults_.silent_bound) {
        hide_wider_bounds();
    }
    return packets;
}

}  // namespace zoned::zone

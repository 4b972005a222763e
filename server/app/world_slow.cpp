#include "server/app/world.h"
#include "proto/session.pb.h"

#include <algorithm>

namespace zoned::app {

/// Changes that rules asked for, in the order of the zones: what comes later holds.
void World::change_clocks(std::vector<mailbox::OutboxItem>& out) {
    bool changed = false;
    for (const auto& zone : zones_) {
        for (const zone::ClockChange& change : zone->output().clocks) {
            const auto value = slow_->clock(change.clock).at(static_cast<double>(change.from));
            slow_->announce(change.clock, {change.from, value.value_or(0.0), change.rate_per_s});
            changed = true;
        }
    }
    if (changed) {
        std::vector<ClientId> everybody;
        for (const auto& [client, zone] : zone_of_) {
            everybody.push_back(client);
        }
        tell_slow_state(std::move(everybody), out);
    }
}

/// What both sides compute alike needs no news; it is told now and then all the same, so that
/// nothing that went wrong stays wrong.
void World::sync_slow_state(std::vector<mailbox::OutboxItem>& out) {
    if (now_ % slow_sync_ticks_ != 0) {
        return;
    }
    std::vector<ClientId> everybody;
    for (const auto& [client, zone] : zone_of_) {
        everybody.push_back(client);
    }
    tell_slow_state(std::move(everybody), out);
}

void World::tell_slow_state(std::vector<ClientId> recipients,
                            std::vector<mailbox::OutboxItem>& out) {
    if (recipients.empty()) {
        return;
    }
    proto::SlowState update;
    for (std::size_t c = 0; c < slow_->clocks(); ++c) {
        for (const clock::Course& course : slow_->clock(c).from(now_)) {
            proto::SlowState::Course& one = *update.add_courses();
            one.set_clock(static_cast<std::uint32_t>(c));
            one.set_from(course.from);
            one.set_value(course.value);
            one.set_rate_per_s(course.rate_per_s * (1.0 + wrong_clock_));
        }
    }
    for (std::size_t v = 0; v < slow_->variables(); ++v) {
        if (const auto cursor = slow_->cursor_at(v, now_)) {
            proto::SlowState::Cursor& one = *update.add_cursors();
            one.set_variable(static_cast<std::uint32_t>(v));
            one.set_number(cursor->number);
            one.set_since(cursor->since);
            one.set_phase(cursor->phase);
            one.set_before(cursor->before);
        }
    }
    mailbox::EventOut event;
    event.event = own_event_id();
    event.tick = now_;
    event.kind = proto::CORE_EVENT_SLOW_STATE;
    event.payload.resize(update.ByteSizeLong());
    update.SerializeToArray(event.payload.data(), static_cast<int>(event.payload.size()));
    event.recipients = std::move(recipients);
    out.emplace_back(std::move(event));
}

void World::add_slow_truth(mailbox::AuditRecord& record) const {
    for (std::size_t c = 0; c < slow_->clocks(); ++c) {
        record.shared_clocks.push_back(slow_->clock_at(c, record.tick).value_or(0.0));
    }
    for (std::size_t v = 0; v < slow_->variables(); ++v) {
        record.slow_variables.push_back(slow_->value_at(v, record.tick).value_or(0.0));
    }
}

}  // namespace zoned::app

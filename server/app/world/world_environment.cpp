#include "server/app/world/world.h"
#include "proto/session.pb.h"

#include <algorithm>

namespace zoned::app {

/// Changes that rules asked for, in the order of the zones: the last one holds.
void World::change_environment(std::vector<mailbox::OutboxItem>& out) {
    bool changed = false;
    for (const auto& zone : zones_) {
        for (const zone::ClockChange& change : zone->output().clocks) {
            const auto value =
                environment_->clock(change.clock).at(static_cast<double>(change.from));
            environment_->announce(change.clock,
                                   {change.from, value.value_or(0.0), change.rate_per_s});
            changed = true;
        }
        for (const zone::DoorChange& change : zone->output().doors) {
            changed = door_courses_->announce(change.door, change.course, now_) || changed;
        }
        for (const zone::PlatformChange& change : zone->output().platforms) {
            changed = announce_platform(change) || changed;
        }
    }
    if (changed) {
        std::vector<ClientId> everybody;
        for (const auto& [client, zone] : zone_of_) {
            everybody.push_back(client);
        }
        send_environment(std::move(everybody), out);
    }
}

/// It travels on from where earlier courses will have it.
bool World::announce_platform(const zone::PlatformChange& change) {
    const motion::PlatformCourse* before = platform_courses_->at(change.platform, change.from);
    Tick along = before != nullptr ? before->along_at(change.from) : 0;
    if (before == nullptr) {
        for (const zone::PlatformName& name : states_.front()->settings.platforms) {
            along = name.platform == change.platform ? name.start : along;
        }
    }
    return platform_courses_->announce(change.platform, {change.from, along, change.to}, now_);
}

/// Both sides compute the environment alike, so it needs no updates. It is sent now and then all
/// the same, so that an error does not last.
void World::sync_environment(std::vector<mailbox::OutboxItem>& out) {
    if (now_ % environment_sync_ticks_ != 0) {
        return;
    }
    std::vector<ClientId> everybody;
    for (const auto& [client, zone] : zone_of_) {
        everybody.push_back(client);
    }
    send_environment(std::move(everybody), out);
}

void World::send_environment(std::vector<ClientId> recipients,
                             std::vector<mailbox::OutboxItem>& out) {
    if (recipients.empty()) {
        return;
    }
    proto::SharedEnvironment update;
    for (std::size_t c = 0; c < environment_->clocks(); ++c) {
        for (const clock::ClockCourse& course : environment_->clock(c).from(now_)) {
            proto::SharedEnvironment::Course& one = *update.add_courses();
            one.set_clock(static_cast<std::uint32_t>(c));
            one.set_from(course.from);
            one.set_value(course.value);
            one.set_rate_per_s(course.rate_per_s);
        }
    }
    for (std::size_t v = 0; v < environment_->variables(); ++v) {
        if (const auto cursor = environment_->cursor_at(v, now_)) {
            proto::SharedEnvironment::Cursor& one = *update.add_cursors();
            one.set_variable(static_cast<std::uint32_t>(v));
            one.set_number(cursor->number);
            one.set_since(cursor->since);
            one.set_phase(cursor->phase);
            one.set_before(cursor->before);
        }
    }
    for (std::uint32_t d = 0; door_courses_ && d < door_courses_->size(); ++d) {
        for (const motion::DoorCourse& course : door_courses_->from(d, now_)) {
            proto::SharedEnvironment::DoorCourse& one = *update.add_doors();
            one.set_door(d);
            one.set_from(course.from);
            one.set_open(course.open);
        }
    }
    for (std::uint32_t p = 0; platform_courses_ && p < platform_courses_->size(); ++p) {
        for (const motion::PlatformCourse& course : platform_courses_->from(p, now_)) {
            proto::SharedEnvironment::PlatformCourse& one = *update.add_platforms();
            one.set_platform(p);
            one.set_from(course.from);
            one.set_along(course.along);
            one.set_to(course.to);
        }
    }
    mailbox::EventOut event;
    event.event = own_event_id();
    event.tick = now_;
    event.kind = proto::CORE_EVENT_SHARED_ENVIRONMENT;
    event.payload.resize(update.ByteSizeLong());
    update.SerializeToArray(event.payload.data(), static_cast<int>(event.payload.size()));
    event.recipients = std::move(recipients);
    out.emplace_back(std::move(event));
}

void World::add_environment_truth(mailbox::AuditRecord& record) const {
    for (std::size_t c = 0; c < environment_->clocks(); ++c) {
        record.shared_clocks.push_back(environment_->clock_at(c, record.tick).value_or(0.0));
    }
    for (std::size_t v = 0; v < environment_->variables(); ++v) {
        record.shared_variables.push_back(environment_->value_at(v, record.tick).value_or(0.0));
    }
    add_moved_by_rules(record.tick, record.doors, record.platforms);
}

void World::add_moved_by_rules(Tick tick,
                               std::vector<std::uint32_t>& doors,
                               std::vector<Tick>& platforms) const {
    const auto& all = states_.front()->settings.doors;
    for (std::uint32_t d = 0; d < all.size(); ++d) {
        if (all[d].by_rules) {
            const bool open = door_courses_->open_at(d, tick).value_or(all[d].starts_open);
            doors.push_back(open ? 1 : 0);
        }
    }
    for (const zone::PlatformName& name : states_.front()->settings.platforms) {
        const motion::PlatformCourse* course = platform_courses_->at(name.platform, tick);
        platforms.push_back(course == nullptr ? name.start : course->along_at(tick));
    }
}

}  // namespace zoned::app

// A zone whose rules threw stops, and its clients leave; what the world itself tells them.
#include "server/app/world/world.h"
#include "proto/session.pb.h"

#include <utility>

namespace zoned::app {

namespace {

/// Other zones and the world still need these of a tick that was not finished.
void keep_departures(zone::StepOutput& out) {
    std::vector<zone::Handoff> handoffs = std::move(out.handoffs);
    std::vector<ClientId> departed = std::move(out.departed);
    out.clear();
    out.handoffs = std::move(handoffs);
    out.departed = std::move(departed);
}

}  // namespace

void World::stop_zone(std::size_t index, const std::string& text) {
    zone::ZoneState& state = zones_[index]->state();
    StoppedZone fault;
    fault.zone = state.settings.id;
    fault.tick = now_;
    fault.place = state.running ? "the pass " + std::string(zone::pass_name(*state.running))
                                : "the exchange with its neighbours";
    fault.text = text;
    fault.clients = state.clients.size();
    state.running.reset();
    keep_departures(state.out);
    fault_of_[index] = std::move(fault);
}

void World::clear_stopped() {
    if (stopped_.empty()) {
        return;
    }
    for (std::size_t i = 0; i < zones_.size(); ++i) {
        if (!runs(i)) {
            zone::ZoneState& state = zones_[i]->state();
            state.out.clear();
            state.report = zone::StepReport{};
            state.report.tick = now_;
            state.report.census.entities = static_cast<std::uint32_t>(state.entities.size());
            state.report.plan.reason.fill("the zone has stopped: its rules threw");
            state.ghosts_out_changed = false;
            if (fault_of_[i]->tick + 1 == now_) {
                zones_[i]->stand_still();
            }
        }
    }
}

void World::stop() {
    store_requests_.clear();
    for (std::size_t i = 0; i < zones_.size(); ++i) {
        zone::StepOutput& out = zones_[i]->output();
        out.clear();
        if (!runs(i)) {
            continue;
        }
        try {
            zones_[i]->stop();
        } catch (const std::exception& error) {
            out.lines.push_back("on_stop threw: " + std::string(error.what()));
        }
        std::move(out.store.begin(), out.store.end(), std::back_inserter(store_requests_));
    }
}

void World::end_clients(std::vector<mailbox::OutboxItem>& out) {
    for (std::size_t i = 0; i < zones_.size(); ++i) {
        if (runs(i) || zones_[i]->state().clients.empty()) {
            continue;
        }
        zone::ZoneState& state = zones_[i]->state();
        for (const zone::ZoneClient& client : state.clients) {
            zone_of_.erase(client.client);
            leave_groups(client.client);
            topics_.remove(client.client);
            mailbox::Kick kick;
            kick.client = client.client;
            kick.reason = "this part of the world has stopped after a fault of the game";
            out.emplace_back(std::move(kick));
        }
        state.clients.clear();
        state.viewers.clear();
    }
    for (const auto& fault : fault_of_) {
        if (fault && !is_known(fault->zone)) {
            stopped_.push_back(*fault);
        }
    }
}

bool World::is_known(ZoneId zone) const {
    for (const StoppedZone& known : stopped_) {
        if (known.zone == zone) {
            return true;
        }
    }
    return false;
}

void World::notify(const mailbox::Notice& notice) {
    proto::Notice text;
    text.set_text(notice.text);
    mailbox::EventOut event;
    event.event = own_event_id();
    event.tick = now_ + 1;  // of the step that follows
    event.kind = proto::CORE_EVENT_NOTICE;
    event.payload.resize(text.ByteSizeLong());
    text.SerializeToArray(event.payload.data(), static_cast<int>(event.payload.size()));
    for (const auto& [client, zone] : zone_of_) {
        if (!notice.client || client == notice.client) {
            event.recipients.push_back(client);
        }
    }
    answers_.emplace_back(std::move(event));
}

void World::refuse_order(std::uint64_t number, const std::string& text) {
    answers_.emplace_back(mailbox::OrderDone{number, EntityId(), text});
}

}  // namespace zoned::app

#include "server/app/world/world.h"

#include "server/app/log/current_zone.h"
#include "server/app/world/world_faults.h"
#include "server/app/world/world_rules.h"
#include "server/app/world/world_settings.h"
#include "server/zone/border/zone_portal_exchange.h"
#include "server/zone/zone_setup.h"
#include "proto/session.pb.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <string>
#include <utility>

namespace zoned::app {

namespace {

std::string zone_topic(ZoneId zone) {
    return "zone/" + std::to_string(zone.value);
}

mailbox::Bytes bytes_of(const google::protobuf::MessageLite& message) {
    mailbox::Bytes bytes(message.ByteSizeLong());
    message.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
    return bytes;
}

proto::ParticleBurst describe_burst(const zone::BurstOut& from) {
    proto::ParticleBurst out;
    out.set_system(from.system);
    out.set_seed(from.burst.seed);
    out.set_count(from.burst.count);
    for (int axis = 0; axis < 3; ++axis) {
        out.add_position(from.burst.position[axis]);
        out.add_velocity(from.burst.velocity[axis]);
    }
    return out;
}

/// A zone as the config asks for it: only one with faults on purpose is decorated.
std::unique_ptr<zone::Zone> make_zone(
    const config::Settings& settings,
    ZoneId id,
    const std::shared_ptr<const world::TypeTable>& types,
    const std::shared_ptr<const motion::DoorCourses>& doors,
    const std::shared_ptr<const motion::PlatformCourses>& platforms,
    zone::Stopwatch stopwatch) {
    zone::ZoneSettings of_zone = zone_settings(settings, id, types, doors, platforms);
    of_zone.maps_later = true;
    std::unique_ptr<zone::Rules> rules = make_world_rules(settings.script, settings.rules, *types);
    const zone::FaultSettings faults = zone_faults(settings, id);
    if (faults != zone::FaultSettings{}) {
        return std::make_unique<zone::FaultyZone>(
            std::move(of_zone), faults, std::move(rules), stopwatch);
    }
    return std::make_unique<zone::Zone>(std::move(of_zone), std::move(rules), stopwatch);
}

/// Null where rules move no door.
std::shared_ptr<motion::DoorCourses> courses_of(const config::Settings& settings) {
    const bool any = std::any_of(
        settings.doors.begin(), settings.doors.end(), [](const config::NamedDoor& named) {
            return named.door.by_rules.has_value();
        });
    return any ? std::make_shared<motion::DoorCourses>(settings.doors.size()) : nullptr;
}

/// Null where rules move no platform.
std::shared_ptr<motion::PlatformCourses> platform_courses_of(const config::Settings& settings) {
    const auto& platforms = settings.platforms;
    const bool any =
        std::any_of(platforms.begin(), platforms.end(), [](const config::NamedPlatform& named) {
            return named.platform.path.by_rules.has_value();
        });
    return any ? std::make_shared<motion::PlatformCourses>(platforms.size()) : nullptr;
}

std::uint64_t hash_of(const config::Settings& settings) {
    core::StateHash hash;
    hash.add_bytes(
        {reinterpret_cast<const std::uint8_t*>(settings.text.data()), settings.text.size()});
    return hash.value();
}

}  // namespace

World::World(const config::Settings& settings, unsigned threads, zone::Stopwatch stopwatch)
    : config_hash_(hash_of(settings)),
      rules_settings_(settings.rules),
      script_(settings.script),
      spawn_points_(settings.spawn_points),
      regions_(regions_of(settings)),
      teams_(regions_.size()),
      pool_(threads),
      door_courses_(courses_of(settings)),
      platform_courses_(platform_courses_of(settings)),
      faults_(make_world_faults(settings)) {
    const auto types = std::make_shared<const world::TypeTable>(settings.types);
    for (const zone::Region& region : regions_) {
        zones_.push_back(
            make_zone(settings, region.id, types, door_courses_, platform_courses_, stopwatch));
        states_.push_back(&zones_.back()->state());
        compute::Team& team = teams_[zones_.size() - 1];
        team.join_pool(pool_);
        zones_.back()->state().scene.work_with(&team);
        zones_.back()->state().team = &team;
    }
    bake_maps();
    zone::join_paths(states_);
    if (!settings.environment.empty() || door_courses_ || platform_courses_) {
        environment_ = std::make_shared<clock::SharedEnvironment>(settings.environment,
                                                                  1.0 / settings.tick_rate_hz);
        environment_->begin(settings.environment);
        environment_sync_ticks_ = settings.environment.sync_ticks;
        for (zone::ZoneState* state : states_) {
            state->settings.environment = environment_;
        }
    }
    make_groups(settings);
    inboxes_.resize(zones_.size());
    fault_of_.resize(zones_.size());
    populate(settings, regions_, zones_);
    topics_.keep(settings.server.topics);
}

World::~World() = default;

void World::bake_maps() {
    std::vector<std::exception_ptr> wrong(states_.size());
    pool_.run(states_.size(), [&](std::size_t z) {
        try {
            if (states_[z]->settings.first_state == nullptr) {  // else it opens later
                zone::make_paths(*states_[z]);
            }
        } catch (...) {
            wrong[z] = std::current_exception();  // a task of the pool must not throw
        }
    });
    const auto first = std::find_if(wrong.begin(), wrong.end(), [](auto& e) { return !!e; });
    if (first != wrong.end()) {
        std::rethrow_exception(*first);
    }
}

void World::use_device(compute::Device* device,
                       const compute::Crossover& of_falling,
                       const compute::Crossover& of_flocks) {
    for (const auto& zone : zones_) {
        zone->state().particles.simulated.use_device(device, of_falling, of_flocks);
    }
}

void World::hash_zones(std::vector<std::uint64_t>& out) const {
    out.clear();
    for (const auto& zone : zones_) {
        out.push_back(zone->state_hash());
    }
}

std::uint64_t World::state_hash() const {
    std::vector<std::uint64_t> zones;
    hash_zones(zones);
    return world_hash(zones);
}

std::uint64_t world_hash(std::span<const std::uint64_t> zones) {
    core::StateHash hash;
    for (const std::uint64_t zone : zones) {
        hash.add(zone);
    }
    return hash.value();
}

void World::sum_traffic(wire::TrafficTable& out) const {
    for (const auto& zone : zones_) {
        if (const wire::TrafficTable* traffic = zone->state().replicator.traffic()) {
            out.add(*traffic);
        }
    }
}

bool World::idle() const {
    return std::all_of(zones_.begin(), zones_.end(), [](const auto& zone) {
        const zone::StepPlan& plan = zone->report().plan;
        return !plan.has(zone::Pass::kRules) && !plan.has(zone::Pass::kAgents) &&
               !plan.has(zone::Pass::kMovement) && !plan.has(zone::Pass::kPhysics) &&
               !plan.has(zone::Pass::kParticles) && !plan.has(zone::Pass::kInterest);
    });
}

std::size_t World::spawn_zone(mailbox::Join& join) const {
    if (join.placed) {
        const std::size_t zone = zone_at(join.spawn[0], join.spawn[2]);
        const bool in_a_copy =
            instances_ && zone < zones_.size() && instances_->is_copy(states_[zone]->settings.id);
        if (zone < zones_.size() && runs(zone) && !in_a_copy) {
            return zone;
        }
    }
    const std::vector<const zone::SpawnPoint*> points =
        zone::spawn_points_of(spawn_points_, join.team);
    // Clients come with consecutive numbers: a stride that is coprime to most list lengths spreads
    // them over the map.
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Vec3d& point = points[(join.client.value * 7919ULL + k) % points.size()]->position;
        const std::size_t zone = zone_at(point.x(), point.z());
        ZONED_ASSERT(zone < zones_.size(), "spawn points were checked to lie in a zone");
        if (runs(zone)) {
            join.spawn[0] = point.x();
            join.spawn[1] = point.y();
            join.spawn[2] = point.z();
            return zone;
        }
    }
    return zones_.size();
}

std::size_t World::zone_of_answer(const mailbox::StoreAnswer& answer) const {
    const auto owner = std::find_if(zones_.begin(), zones_.end(), [&](const auto& zone) {
        return answer.target ? zone->owns(answer.target) : zone->state().settings.id == answer.zone;
    });
    const auto index = static_cast<std::size_t>(owner - zones_.begin());
    return index < zones_.size() && runs(index) ? index : zones_.size();
}

std::size_t World::zone_at(double x, double z) const {
    std::size_t zone = 0;
    while (zone < regions_.size() && regions_[zone].outside(x, z) != 0.0) {
        ++zone;
    }
    return zone;
}

void World::route(const mailbox::InboxItem& item) {
    if (const auto* join = std::get_if<mailbox::Join>(&item)) {
        mailbox::Join placed = *join;
        const std::size_t zone = spawn_zone(placed);
        if (zone == zones_.size()) {
            mailbox::Kick kick;
            kick.client = placed.client;
            kick.reason = "every zone with a place to appear has stopped after a fault";
            answers_.emplace_back(std::move(kick));
            return;
        }
        zone_of_[placed.client] = zone;
        inboxes_[zone].emplace_back(std::move(placed));
        return;
    }
    if (std::holds_alternative<mailbox::Freeze>(item) ||
        std::holds_alternative<mailbox::CodecPrice>(item) ||
        std::holds_alternative<mailbox::NewBrains>(item)) {
        if (const auto* brains = std::get_if<mailbox::NewBrains>(&item)) {
            reload_scripts(*brains->config);
        }
        for (ZoneInbox& inbox : inboxes_) {
            inbox.push_back(item);
        }
        return;
    }
    if (const auto* order = std::get_if<mailbox::SpawnOrder>(&item)) {
        const std::size_t zone = zone_at(order->position[0], order->position[2]);
        if (zone < zones_.size() && runs(zone)) {
            inboxes_[zone].push_back(item);
        } else {
            refuse_order(order->number, "no running zone is there");
        }
        return;
    }
    if (const auto* order = std::get_if<mailbox::MoveOrder>(&item)) {
        const auto owner = std::find_if(zones_.begin(), zones_.end(), [order](const auto& zone) {
            return zone->owns(order->entity);
        });
        const bool inside = zone_at(order->position[0], order->position[2]) < zones_.size();
        if (owner != zones_.end() && inside &&
            runs(static_cast<std::size_t>(owner - zones_.begin()))) {
            inboxes_[static_cast<std::size_t>(owner - zones_.begin())].push_back(item);
        } else {
            refuse_order(order->number,
                         inside ? "no running zone has that entity" : "no zone is there");
        }
        return;
    }
    if (const auto* answer = std::get_if<mailbox::StoreAnswer>(&item)) {
        const std::size_t zone = zone_of_answer(*answer);
        if (zone < zones_.size()) {
            inboxes_[zone].push_back(item);
        } else {
            ++undeliverable_;
        }
        return;
    }
    if (const auto* notice = std::get_if<mailbox::Notice>(&item)) {
        notify(*notice);
        return;
    }
    if (std::holds_alternative<mailbox::SessionBegun>(item) ||
        std::holds_alternative<mailbox::SessionProgress>(item) ||
        std::holds_alternative<mailbox::StoreKept>(item)) {
        return;  // see server/app/recovery/run_ledger.h
    }
    const ClientId client = std::visit(
        [](const auto& message) {
            if constexpr (requires { message.client; }) {
                return message.client;
            } else {
                return ClientId();
            }
        },
        item);
    const auto it = zone_of_.find(client);
    if (it == zone_of_.end()) {
        ++undeliverable_;
        return;
    }
    inboxes_[it->second].push_back(item);
}

void World::tick(std::span<const mailbox::InboxItem> items, std::vector<mailbox::OutboxItem>& out) {
    for (ZoneInbox& inbox : inboxes_) {
        inbox.clear();
    }
    for (const mailbox::InboxItem& item : items) {
        route(item);
    }
    step(out);
}

void World::for_each_zone(void (World::*work)(std::size_t)) {
    if (idle()) {
        // Waking the workers would cost more than there is to do.
        for (std::size_t i = 0; i < zones_.size(); ++i) {
            (this->*work)(i);
        }
        return;
    }
    pool_.run(zones_.size(), [this, work](std::size_t i) { (this->*work)(i); });
}

void World::step(std::vector<mailbox::OutboxItem>& out) {
    const std::size_t before = out.size();
    std::move(answers_.begin(), answers_.end(), std::back_inserter(out));
    answers_.clear();
    store_requests_.clear();
    ++now_;
    clear_stopped();
    if (environment_) {
        environment_->advance(now_);
    }
    for_each_zone(&World::simulate_zone);
    begin_groups();
    carry_handoffs(out);
    apply_topics(out);
    update_groups(out);
    deliver_messages();
    for (const auto& zone : zones_) {
        zone->publish_ghosts();
    }
    for_each_zone(&World::import_ghosts);
    for_each_zone(&World::publish_zone);
    end_clients(out);
    resolve_events(out);
    resolve_bursts(out);
    if (environment_) {
        change_environment(out);
        sync_environment(out);
    }
    for (const auto& zone : zones_) {
        zone::StepOutput& from = zone->output();
        for (mailbox::OutboxItem& message : from.messages) {
            if (const auto* joined = std::get_if<mailbox::Joined>(&message)) {
                const mailbox::Joined here = *joined;
                out.push_back(std::move(message));
                enter_zone(here.client, here.zone, out);
                if (parties_) {
                    seat_party_member(here, out);
                }
                if (environment_) {
                    send_environment({here.client}, out);
                }
                continue;
            }
            if (auto* record = std::get_if<mailbox::AuditRecord>(&message);
                record && environment_) {
                add_environment_truth(*record);
            }
            out.push_back(std::move(message));
        }
        for (mailbox::StatePacket& packet : from.packets) {
            out.emplace_back(std::move(packet));
        }
        std::move(from.store.begin(), from.store.end(), std::back_inserter(store_requests_));
        for (const ClientId client : from.departed) {
            zone_of_.erase(client);
            topics_.remove(client);
        }
    }
    if (faults_) {
        faults_->alter(now_, zone_of_, std::span(out).subspan(before));
    }
}

template <class Work>
void World::guarded(std::size_t index, Work&& work) {
    if (!runs(index)) {
        return;
    }
    const CurrentZone here(zones_[index]->state());
    try {
        work();
    } catch (const std::exception& error) {
        stop_zone(index, error.what());
    } catch (...) {
        stop_zone(index, "an exception that is no std::exception");
    }
}

void World::simulate_zone(std::size_t index) {
    guarded(index, [&] { zones_[index]->simulate(now_, inboxes_[index]); });
}

void World::import_ghosts(std::size_t index) {
    guarded(index, [&] { zones_[index]->follow_ghosts(states_); });
}

void World::publish_zone(std::size_t index) {
    guarded(index, [&] { zones_[index]->publish(); });
}

void World::carry_handoffs(std::vector<mailbox::OutboxItem>& out) {
    for (const auto& zone : zones_) {
        for (zone::Handoff& handoff : zone->output().handoffs) {
            const std::size_t to = handoff.to.value - 1U;
            if (!runs(to)) {
                // Its owner keeps it: behind the border nobody would move it.
                const std::size_t from = handoff.from.value - 1U;
                guarded(from, [&] { zones_[from]->accept_handoff(handoff); });
                continue;
            }
            guarded(to, [&] { zones_[to]->accept_handoff(handoff); });
            ++handoffs_;
            if (handoff.client) {
                const ClientId client = handoff.client->client;
                zone_of_[client] = to;
                ++client_handoffs_;
                topics_.unsubscribe(client, zone_topic(handoff.from));
                move_in_groups(client, handoff.to);
                enter_zone(client, handoff.to, out);
            }
        }
    }
}

EventId World::own_event_id() {
    return EventId(++next_event_ << 16U);  // zone 0: the world itself
}

void World::enter_zone(ClientId client, ZoneId zone, std::vector<mailbox::OutboxItem>& out) {
    subscribe(client, zone_topic(zone), out);
    proto::ZoneEntered entered;
    entered.set_zone(zone.value);
    mailbox::EventOut event;
    event.event = own_event_id();
    event.tick = now_;
    event.kind = proto::CORE_EVENT_ZONE_ENTERED;
    event.payload = bytes_of(entered);
    event.recipients.push_back(client);
    out.emplace_back(std::move(event));
}

/// A new subscriber first gets the messages that it missed, then the new ones.
void World::subscribe(ClientId client,
                      const std::string& topic,
                      std::vector<mailbox::OutboxItem>& out) {
    topics_.subscribe(client, topic);
    missed_.clear();
    topics_.take_missed(client, topic, missed_);
    for (interest::PastEvent& past : missed_) {
        mailbox::EventOut event;
        event.event = past.event;
        event.tick = past.tick;
        event.kind = past.kind;
        event.history = true;
        event.topic = topic;
        event.payload = std::move(past.payload);
        event.recipients.push_back(client);
        out.emplace_back(std::move(event));
    }
}

void World::apply_topics(std::vector<mailbox::OutboxItem>& out) {
    for (const auto& zone : zones_) {
        for (const zone::TopicChange& change : zone->output().topics) {
            if (change.subscribe) {
                subscribe(change.client, change.topic, out);
            } else {
                topics_.unsubscribe(change.client, change.topic);
            }
        }
    }
    // A client that left in this tick gets no more notices. Where many leave at once, a notice to
    // each of all the others would be a square of messages that nobody gets.
    for (const auto& zone : zones_) {
        for (const ClientId client : zone->output().departed) {
            topics_.remove(client);
        }
    }
}

void World::deliver_to_zones(ZoneId to, const zone::RulesMessage& message) {
    if (to.value > zones_.size()) {
        ++undeliverable_;
        return;
    }
    for (std::size_t z = 0; z < zones_.size(); ++z) {
        if (to && to.value != z + 1) {
            continue;
        }
        if (runs(z)) {
            zones_[z]->deliver(message);
        } else {
            ++undeliverable_;
        }
    }
}

void World::deliver_messages() {
    for (const auto& zone : zones_) {
        for (zone::RulesMessage& message : zone->output().rules_messages) {
            if (message.zone) {
                deliver_to_zones(*message.zone, message);
                continue;
            }
            const auto owner = std::find_if(zones_.begin(), zones_.end(), [&](const auto& z) {
                return z->owns(message.target);
            });
            if (owner == zones_.end() || !runs(static_cast<std::size_t>(owner - zones_.begin()))) {
                ++undeliverable_;
                continue;
            }
            (*owner)->deliver(std::move(message));
        }
    }
}

void World::resolve_events(std::vector<mailbox::OutboxItem>& out) {
    for (const auto& zone : zones_) {
        for (zone::PendingEvent& pending : zone->output().events) {
            std::vector<ClientId>& recipients = pending.event.recipients;
            if (pending.audience == zone::Audience::kTopic) {
                recipients = topics_.subscribers(pending.event.topic);
                topics_.remember(pending.event.topic,
                                 {0,
                                  pending.event.event,
                                  pending.event.tick,
                                  pending.event.kind,
                                  pending.event.payload});
            } else if (pending.audience == zone::Audience::kViewers) {
                for (const auto& other : zones_) {
                    other->recipients_of(pending.source, recipients);
                }
                std::sort(recipients.begin(), recipients.end());
                recipients.erase(std::unique(recipients.begin(), recipients.end()),
                                 recipients.end());
            }
            if (!recipients.empty()) {
                out.emplace_back(std::move(pending.event));
            }
        }
    }
}

void World::resolve_bursts(std::vector<mailbox::OutboxItem>& out) {
    for (const auto& zone : zones_) {
        for (const zone::BurstOut& burst : zone->output().bursts) {
            mailbox::EventOut event;
            for (const auto& other : zones_) {
                other->recipients_near(burst.burst.position.cast<double>(),
                                       burst.aura_m,
                                       burst.line_of_sight,
                                       event.recipients);
            }
            if (event.recipients.empty()) {
                continue;
            }
            std::sort(event.recipients.begin(), event.recipients.end());
            event.event = own_event_id();
            event.tick = burst.burst.start;
            event.kind = proto::CORE_EVENT_PARTICLE_BURST;
            event.payload = bytes_of(describe_burst(burst));
            out.emplace_back(std::move(event));
            ++bursts_sent_;
        }
    }
}

}  // namespace zoned::app

// PlainRules: minimal rules that give each new player an avatar and count all calls.
#pragma once

#include "server/zone/groups/instance.h"
#include "server/zone/groups/match.h"
#include "server/zone/groups/party.h"
#include "server/zone/rules.h"

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace zoned::scenario {

/// The calls that PlainRules received; shared by all zones of a test, which may run on several
/// threads.
struct PlainLog {
    std::mutex guard;  ///< protects the members below while zones run
    std::map<ClientId, EntityId> avatars;
    zone::ContactWish wish;  ///< for all types; set before the zones are made
    std::vector<zone::EntityContact> contacts;
    std::vector<std::pair<EntityId, zone::Bytes>> messages;
    std::vector<std::uint16_t> commands;
    std::vector<zone::BrokenJoint> broken;
    std::vector<std::pair<ZoneId, Tick>> starts;
    std::vector<std::pair<ZoneId, zone::DueTimer>> timers;  ///< those that were due, and where
    std::vector<std::pair<ZoneId, zone::LeverUse>> uses;
    std::vector<std::string> triggers;                               ///< "1 +goal 7", "2 -goal 7"
    std::vector<std::pair<ZoneId, zone::PartyChange>> parties;       ///< what was told, and where
    std::vector<std::pair<ZoneId, zone::InstanceChange>> instances;  ///< likewise
    std::vector<std::pair<ZoneId, zone::MatchChange>> matches;       ///< likewise
    /// Called by each zone's on_start; set before the zones are made.
    std::function<void(zone::RulesContext&)> at_start;
    /// Called by each zone's on_stop.
    std::function<void(zone::StopContext&)> at_stop;
    bool busy = false;  ///< each_tick is called also where no player is
    /// Called by each zone's on_tick; set before the world runs.
    std::function<void(zone::RulesContext&)> each_tick;
    /// Whether a viewer may know of an entity that conceals itself; all may where it is not set.
    std::function<bool(EntityId viewer, EntityId entity)> may_hear;
};

class PlainRules final : public zone::Rules {
  public:
    explicit PlainRules(std::shared_ptr<PlainLog> log) : log_(std::move(log)) {}

    void on_start(zone::RulesContext& context) override {
        const std::lock_guard lock(log_->guard);
        log_->starts.emplace_back(context.zone(), context.now());
        if (log_->at_start) {
            log_->at_start(context);
        }
    }

    void on_stop(zone::StopContext& context) const override {
        if (log_->at_stop) {
            log_->at_stop(context);
        }
    }

    void on_timer(zone::RulesContext& context, const zone::DueTimer& timer) override {
        const std::lock_guard lock(log_->guard);
        log_->timers.emplace_back(context.zone(), timer);
    }

    void on_party(zone::RulesContext& context, const zone::PartyChange& change) override {
        const std::lock_guard lock(log_->guard);
        log_->parties.emplace_back(context.zone(), change);
    }

    void on_match(zone::RulesContext& context, const zone::MatchChange& change) override {
        const std::lock_guard lock(log_->guard);
        log_->matches.emplace_back(context.zone(), change);
    }

    void on_instance(zone::RulesContext& context, const zone::InstanceChange& change) override {
        const std::lock_guard lock(log_->guard);
        log_->instances.emplace_back(context.zone(), change);
    }

    void on_trigger(zone::RulesContext& context, const zone::TriggerEvent& event) override {
        const std::lock_guard lock(log_->guard);
        log_->triggers.push_back(std::to_string(context.zone().value) +
                                 (event.entered ? " +" : " -") + std::string(event.trigger) + " " +
                                 std::to_string(event.entity.value));
    }

    void on_use(zone::RulesContext& context, const zone::LeverUse& use) override {
        const std::lock_guard lock(log_->guard);
        log_->uses.emplace_back(context.zone(), use);
    }

    EntityId on_join(zone::RulesContext& context, const zone::JoinRequest& request) override {
        zone::SpawnDef def;
        def.type = 0;
        def.position = request.spawn_position;
        def.client = request.client;
        const EntityId avatar = context.spawn(def);
        const std::lock_guard lock(log_->guard);
        log_->avatars[request.client] = avatar;
        return avatar;
    }

    void on_leave(zone::RulesContext& context, ClientId client, EntityId avatar) override {
        context.despawn(avatar);
        const std::lock_guard lock(log_->guard);
        log_->avatars.erase(client);
    }

    void on_command(zone::RulesContext& context,
                    ClientId,
                    EntityId avatar,
                    std::uint16_t kind,
                    std::span<const std::uint8_t> payload) override {
        zone::RulesEvent event;
        event.payload.assign(payload.begin(), payload.end());
        context.announce(avatar, event);
        const std::lock_guard lock(log_->guard);
        log_->commands.push_back(kind);
    }

    void on_input(zone::RulesContext&,
                  EntityId,
                  const motion::InputCommand&,
                  std::uint16_t) override {}

    void on_contact(zone::RulesContext&, const zone::EntityContact& contact) override {
        const std::lock_guard lock(log_->guard);
        log_->contacts.push_back(contact);
    }

    void on_joint_broken(zone::RulesContext&, const zone::BrokenJoint& joint) override {
        const std::lock_guard lock(log_->guard);
        log_->broken.push_back(joint);
    }

    [[nodiscard]] zone::ContactWish contact_wish(TypeIndex) const override { return log_->wish; }

    [[nodiscard]] bool may_hear(const zone::RulesContext&,
                                EntityId viewer,
                                EntityId entity) const override {
        return !log_->may_hear || log_->may_hear(viewer, entity);
    }

    void on_tick(zone::RulesContext& context) override {
        if (log_->each_tick) {
            log_->each_tick(context);
        }
    }

    void on_confirm(zone::RulesContext&, ClientId, EventId) override {}

    void on_message(zone::RulesContext&,
                    EntityId target,
                    std::span<const std::uint8_t> payload) override {
        const std::lock_guard lock(log_->guard);
        log_->messages.emplace_back(target, zone::Bytes(payload.begin(), payload.end()));
    }

    /// Each entity carries a counter that rises with every handoff: proof that state travels along.
    zone::Bytes take_entity(EntityId entity) override {
        const std::uint8_t moves = moves_[entity];
        moves_.erase(entity);
        return {static_cast<std::uint8_t>(moves + 1)};
    }

    void load_entity(EntityId entity, std::span<const std::uint8_t> state) override {
        moves_[entity] = state.empty() ? 0 : state[0];
    }

    // Their log is the test's: no state of theirs.

    [[nodiscard]] bool save(zone::Bytes& out) const override {
        for (const auto& [entity, moves] : moves_) {
            for (int shift = 0; shift < 32; shift += 8) {
                out.push_back(static_cast<std::uint8_t>(entity.value >> shift));
            }
            out.push_back(moves);
        }
        return true;
    }

    std::string load(std::span<const std::uint8_t> bytes) override {
        moves_.clear();
        for (; bytes.size() >= 5; bytes = bytes.subspan(5)) {
            std::uint32_t id = 0;
            for (std::size_t i = 0; i < 4; ++i) {
                id |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
            }
            moves_[EntityId(id)] = bytes[4];
        }
        return {};
    }

    [[nodiscard]] bool busy() const override { return log_->busy; }

    void hash(core::StateHash& hash) const override { hash.add(moves_.size()); }

    [[nodiscard]] std::uint8_t moves(EntityId entity) const {
        const auto it = moves_.find(entity);
        return it == moves_.end() ? 0 : it->second;
    }

  private:
    std::shared_ptr<PlainLog> log_;
    std::map<EntityId, std::uint8_t> moves_;
};

}  // namespace zoned::scenario

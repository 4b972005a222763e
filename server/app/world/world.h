// World: steps all zones of a process tick by tick; it takes and gives messages, and has no sockets
// and no clock.
#pragma once

#include "server/compute/worker_pool.h"
#include "server/config/settings.h"
#include "server/interest/topics.h"
#include "server/mailbox/messages.h"
#include "server/zone/groups/instance_book.h"
#include "server/zone/groups/match_book.h"
#include "server/zone/groups/party_book.h"
#include "server/zone/zone.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::core {
struct ArchiveSection;
}

namespace zoned::app {

class WorldFaults;

/// A zone whose rules threw: it is not stepped any more.
struct StoppedZone {
    ZoneId zone;
    Tick tick = 0;
    std::string place;  ///< the pass that ran
    std::string text;   ///< what the exception says
    std::size_t clients = 0;
};

/// What a zone is given before a tick.
using ZoneInbox = std::vector<mailbox::InboxItem>;

/// World::state_hash() from the hashes of its zones.
std::uint64_t world_hash(std::span<const std::uint64_t> zones);

/// Knows the zones and topics of clients. Decides the order of everything that crosses zones, so
/// that a run does not depend on the number of threads.
class World {
  public:
    /// `threads` counts the caller. Throws std::runtime_error when the rules refuse their settings.
    World(const config::Settings& settings, unsigned threads, zone::Stopwatch stopwatch = nullptr);
    ~World();

    /// From now on large particle systems may be moved on a device, which must outlive the world.
    /// The results stay the same bits.
    void use_device(compute::Device* device,
                    const compute::Crossover& of_falling,
                    const compute::Crossover& of_flocks = {});

    /// One tick: routes `items` to the zones in their order, steps, collects the output.
    void tick(std::span<const mailbox::InboxItem> items, std::vector<mailbox::OutboxItem>& out);

    /// After the last tick: tells the rules of each zone that runs. Their requests to the store are
    /// in store_requests(), their lines in the zones' output; nothing else changes. Rules that
    /// throw leave a line.
    void stop();

    [[nodiscard]] Tick now() const { return now_; }

    [[nodiscard]] std::span<const std::unique_ptr<zone::Zone>> zones() const { return zones_; }

    /// The state hash of each zone. It visits the whole state: once a tick is enough.
    void hash_zones(std::vector<std::uint64_t>& out) const;
    /// Hash over all zones' hashes.
    [[nodiscard]] std::uint64_t state_hash() const;

    /// The zones' requests to the store in the last tick, by zone.
    [[nodiscard]] std::vector<mailbox::StoreRequest>& store_requests() { return store_requests_; }

    [[nodiscard]] std::uint64_t handoffs() const { return handoffs_; }

    [[nodiscard]] std::uint64_t client_handoffs() const { return client_handoffs_; }

    /// Messages for clients or entities that nobody owns (they left meanwhile).
    [[nodiscard]] std::uint64_t undeliverable() const { return undeliverable_; }

    /// Calls of scripts that failed or overran so far, in all zones (world_scripts.cpp).
    [[nodiscard]] std::uint64_t script_errors() const;

    /// Null: the config has none (world_groups.cpp).
    [[nodiscard]] const zone::PartyBook* parties() const { return parties_.get(); }

    [[nodiscard]] const zone::InstanceBook* instances() const { return instances_.get(); }

    [[nodiscard]] const zone::MatchBook* matches() const { return matches_.get(); }

    /// Appends doors (1: open) and platforms (ticks of travel from the first stop) that rules move,
    /// as they are at a tick; in the order of the config (world_environment.cpp).
    void add_moved_by_rules(Tick tick,
                            std::vector<std::uint32_t>& doors,
                            std::vector<Tick>& platforms) const;

    /// Cosmetic bursts that reached a client.
    [[nodiscard]] std::uint64_t bursts_sent() const { return bursts_sent_; }

    /// The use of the bytes in the state packets of all zones so far; empty where
    /// replication::ReplicationSettings::meter is off.
    void sum_traffic(wire::TrafficTable& out) const;

    /// True when no zone has anything awake, moving or watched: the next tick will change nothing
    /// by itself.
    [[nodiscard]] bool idle() const;

    [[nodiscard]] const compute::WorkerPool& pool() const { return pool_; }

    /// Everything that later ticks depend on, between two ticks. Empty text: done; otherwise a part
    /// that has no saved form, by its place.
    /// `sections`, where not null: the parts by name, inner ones before outer ones.
    std::string save(std::vector<std::uint8_t>& out,
                     std::vector<core::ArchiveSection>* sections = nullptr) const;
    /// Into a world of the same config that has not ticked yet. Empty text: done, and it goes on as
    /// the other does, given the same items. Otherwise the place and the error; the world is of no
    /// use then.
    std::string load(std::span<const std::uint8_t> bytes);

    /// Zones whose rules threw, in the order in which they stopped. Such a zone stands still, its
    /// neighbours keep what they would hand to it, and its clients are told and leave.
    [[nodiscard]] std::span<const StoppedZone> stopped() const { return stopped_; }

  private:
    template <class Archive>
    void serialize(Archive& archive);  // world_snapshot.cpp
    /// The maps of all zones, on all threads; throws what a zone throws.
    void bake_maps();
    void route(const mailbox::InboxItem& item);
    void step(std::vector<mailbox::OutboxItem>& out);
    void for_each_zone(void (World::*work)(std::size_t));
    /// Runs a part of a zone's tick; when it throws, the zone stops. From any thread of the pool.
    template <class Work>
    void guarded(std::size_t index, Work&& work);
    void reload_scripts(const std::string& config_text);  // world_scripts.cpp
    // world_stops.cpp
    void stop_zone(std::size_t index, const std::string& text);
    [[nodiscard]] bool is_known(ZoneId zone) const;

    [[nodiscard]] bool runs(std::size_t index) const { return !fault_of_[index]; }

    void clear_stopped();
    /// Tells the clients of zones that stopped just now.
    void end_clients(std::vector<mailbox::OutboxItem>& out);
    void refuse_order(std::uint64_t number, const std::string& text);
    void notify(const mailbox::Notice& notice);
    [[nodiscard]] std::size_t zone_at(double x, double z) const;
    void simulate_zone(std::size_t index);
    void import_ghosts(std::size_t index);
    void publish_zone(std::size_t index);
    void carry_handoffs(std::vector<mailbox::OutboxItem>& out);
    void apply_topics(std::vector<mailbox::OutboxItem>& out);
    void subscribe(ClientId client,
                   const std::string& topic,
                   std::vector<mailbox::OutboxItem>& out);
    void deliver_messages();
    void deliver_to_zones(ZoneId to, const zone::RulesMessage& message);
    void resolve_events(std::vector<mailbox::OutboxItem>& out);
    void resolve_bursts(std::vector<mailbox::OutboxItem>& out);
    // world_groups.cpp
    void make_groups(const config::Settings& settings);
    void begin_groups();
    void update_groups(std::vector<mailbox::OutboxItem>& out);
    void update_instances();
    void update_matches(std::vector<mailbox::OutboxItem>& out);
    [[nodiscard]] zone::ZoneUse use_of(ZoneId zone) const;
    void move_in_groups(ClientId client, ZoneId zone);
    void leave_groups(ClientId client);
    void update_parties(std::vector<mailbox::OutboxItem>& out);
    void seat_party_member(const mailbox::Joined& joined, std::vector<mailbox::OutboxItem>& out);
    void follow_party_topics(std::size_t from, std::vector<mailbox::OutboxItem>& out);
    [[nodiscard]] std::optional<zone::PartyPlayer> player_of(EntityId avatar) const;
    // world_environment.cpp
    void change_environment(std::vector<mailbox::OutboxItem>& out);
    bool announce_platform(const zone::PlatformChange& change);
    void sync_environment(std::vector<mailbox::OutboxItem>& out);
    void send_environment(std::vector<ClientId> recipients, std::vector<mailbox::OutboxItem>& out);
    void add_environment_truth(mailbox::AuditRecord& record) const;
    [[nodiscard]] EventId own_event_id();
    void enter_zone(ClientId client, ZoneId zone, std::vector<mailbox::OutboxItem>& out);
    /// Number of zones when all have stopped.
    [[nodiscard]] std::size_t spawn_zone(mailbox::Join& join) const;
    /// Number of the zone that an answer of the store goes to; that of all when it has stopped.
    [[nodiscard]] std::size_t zone_of_answer(const mailbox::StoreAnswer& answer) const;

    std::uint64_t config_hash_ = 0;  // snapshots belong to one config
    zone::RulesSettings rules_settings_;
    std::optional<scripting::ScriptSettings> script_;  // none: the linked rules
    std::vector<zone::SpawnPoint> spawn_points_;
    std::vector<zone::Region> regions_;
    std::vector<compute::Team>
        teams_;  // of the zones: a thread without a zone to step helps another
    std::vector<std::unique_ptr<zone::Zone>> zones_;
    std::vector<zone::ZoneState*> states_;
    std::vector<ZoneInbox> inboxes_;
    std::map<ClientId, std::size_t> zone_of_;  // index of the zone that a client's avatar lives in
    interest::Topics topics_;
    std::vector<interest::PastEvent> missed_;  // scratch
    compute::WorkerPool pool_;
    std::shared_ptr<motion::DoorCourses> door_courses_;          // null: rules move no door
    std::shared_ptr<motion::PlatformCourses> platform_courses_;  // null: rules move no platform
    Tick now_ = 0;
    std::shared_ptr<clock::SharedEnvironment>
        environment_;  // null: the world has no clocks, no variables, and no doors or platforms of
                       // the rules
    Tick environment_sync_ticks_ = 0;
    std::unique_ptr<zone::PartyBook> parties_;       // null: the config has none
    std::unique_ptr<zone::MatchBook> matches_;       // likewise
    std::unique_ptr<zone::InstanceBook> instances_;  // likewise
    std::unique_ptr<const WorldFaults> faults_;      // null: the config has no `testing` settings
    std::vector<std::optional<StoppedZone>> fault_of_;  // by zone
    std::vector<StoppedZone> stopped_;
    std::vector<mailbox::OutboxItem> answers_;  // of the world itself, in this tick
    std::vector<mailbox::StoreRequest> store_requests_;
    std::uint64_t next_event_ = 0;
    std::uint64_t bursts_sent_ = 0;
    std::uint64_t handoffs_ = 0;
    std::uint64_t client_handoffs_ = 0;
    std::uint64_t undeliverable_ = 0;
};

}  // namespace zoned::app

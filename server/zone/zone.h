// Zone: one region of the world with its full simulation; its step lists the stages of the server
// in order.
#pragma once

#include "server/zone/zone_state.h"
#include "shared/core/result.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>

namespace zoned::zone {

/// Monotonic nanoseconds for the pass timers of a report; the simulation never reads it.
using Stopwatch = std::uint64_t (*)();

/// A tick has two halves. Between them the world carries handoffs and ghosts from zone to zone. So
/// the publication of a tick is the truth of that very tick, whichever zone owns an entity. One
/// zone is never stepped by two threads at once, but different zones may be stepped in parallel:
/// the result does not depend on it.
class Zone {
  public:
    Zone(ZoneSettings settings, std::unique_ptr<Rules> rules, Stopwatch stopwatch = nullptr);
    Zone(const Zone&) = delete;
    Zone& operator=(const Zone&) = delete;
    virtual ~Zone() = default;

    /// Spawns the first entities of the world; only before the first tick.
    EntityId spawn(const SpawnDef& def);

    /// First half: inbox -> rules -> agents -> movement -> representation -> soft bodies ->
    /// motors -> physics -> contacts -> handoffs out.
    virtual void simulate(Tick now, std::span<const mailbox::InboxItem> inbox);

    /// Makes a joint between placed entities, `a` none: the world; only before the first tick.
    /// `number`: of ZoneSettings::placed_joints. Fails with the reason.
    core::Result<EntityJointId> join_placed(EntityId a, EntityId b, std::uint16_t number);

    /// Between the halves, in this order: all handoffs, then every export, then every import.
    void accept_handoff(Handoff& handoff);
    void publish_ghosts();
    void follow_ghosts(std::span<ZoneState* const> zones);

    /// After the last tick: Rules::on_stop. The output holds its requests and lines alone.
    void stop();

    /// For good: nothing moves any more, and neighbours see all at rest. In place of both halves.
    void stand_still();

    /// Second half: interest -> replication -> audit -> hash.
    virtual void publish();

    /// Appends the clients of this zone that hear of an entity, its own client included.
    void recipients_of(EntityId source, std::vector<ClientId>& out) const;

    /// Appends the clients of this zone that hear a place (world coordinates, m): the distance of
    /// their avatar is, horizontally, at most its nimbus and `aura_m`; with `line_of_sight` only
    /// those whose avatar sees it.
    void recipients_near(const Vec3d& place,
                         float aura_m,
                         bool line_of_sight,
                         std::vector<ClientId>& out) const;

    /// A message of the rules for an entity of this zone; handled in the next tick's first half.
    /// The names by which rules find placed entities of all zones.
    void name_entities(std::map<std::string, EntityId, std::less<>> names) {
        state_->entity_names = std::move(names);
    }

    void deliver(RulesMessage message) { state_->messages_in.push_back(std::move(message)); }

    [[nodiscard]] bool owns(EntityId entity) const;

    [[nodiscard]] ZoneState& state() { return *state_; }

    [[nodiscard]] const ZoneState& state() const { return *state_; }

    [[nodiscard]] StepOutput& output() { return state_->out; }

    [[nodiscard]] const StepReport& report() const { return state_->report; }

    /// Hash over all ticks so far: equal hashes mean equal histories.
    [[nodiscard]] std::uint64_t state_hash() const { return state_->hash.value(); }

  protected:
    /// Sends clients the changes of the entities in their sets. Returns the number of packets.
    virtual std::uint32_t replicate(const world::Visibility& sets);

  private:
    template <class Work>
    void pass(Pass which, Work&& work);

    std::unique_ptr<ZoneState> state_;
    Stopwatch stopwatch_;
};

}  // namespace zoned::zone

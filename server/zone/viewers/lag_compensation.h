// PoseHistory: where rewindable entities were in the last ticks, and rays through the world as a
// client saw it.
//
// Rewinding as in Bernier, "Latency Compensating Methods in Client/Server In-game Protocol Design
// and Optimization" (GDC 2001), section "Lag Compensation", with one difference. There the server
// guesses what was displayed from the round trip and the interpolation delay. Here the client says
// what it displayed, and is believed as far as what the server has told it explains that: so a
// prediction, and the blending after it, are judged as they were seen, and a lie gains no more than
// `slack_m` and the jump of a blend.
#pragma once

#include "server/world/entities.h"
#include "server/zone/rules.h"

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace zoned::zone {

struct ZoneState;

struct RewindSettings {
    Tick most_ticks = 15;   ///< what is displayed is never looked for farther back; >= 0
    float slack_m = 0.15F;  ///< how far a claim may be from what explains it
};

/// Bodies of rewindable types are in this category, all others are not.
inline constexpr std::uint32_t kRewindableCategory = 1u << 1;

struct Pose {
    Vec3 position = Vec3::Zero();
    Quat orientation = Quat::Identity();
};

/// A ring of ticks, in columns ascending by entity. Allocates only until each slot has held as many
/// entities as it ever will.
class PoseHistory {
  public:
    /// Keeps so many ticks; 0: nothing.
    void resize(Tick ticks) { slots_.resize(static_cast<std::size_t>(ticks)); }

    [[nodiscard]] bool empty() const { return slots_.empty(); }

    /// Begins the slot of a tick; entities are added in ascending order.
    void begin(Tick tick);
    void add(EntityId entity, const Pose& pose);

    /// Where the entity was at a tick with its fraction; none where that was not recorded. Between
    /// two ticks straight on from one to the other.
    [[nodiscard]] std::optional<Pose> at(EntityId entity, Tick tick, float fraction) const;

    [[nodiscard]] std::size_t recorded(Tick tick) const;

  private:
    struct PosesOfTick {
        Tick tick = -1;
        std::vector<EntityId> entity;
        std::vector<Vec3> position;
        std::vector<Quat> orientation;
    };

    [[nodiscard]] const PosesOfTick* find(Tick tick) const;
    [[nodiscard]] static std::optional<Pose> in(const PosesOfTick& slot, EntityId entity);

    std::vector<PosesOfTick> slots_;
    Tick newest_ = 0;
};

/// Records this tick: what is of a rewindable type, not hidden, and heard of by somebody or
/// somebody's avatar; ghosts too. Returns how many entities.
std::uint32_t record_history(ZoneState& state);

/// The ray through the world as the client says it saw it. What it names among Seen::entities
/// stands where it was displayed, as far as that is explained: for a view of the present by what
/// the publication predicts that it was predicted from, which must have been sent to this client
/// and have been the newest within RewindSettings::most_ticks; for a view of the past by where the
/// entity was at that tick. Other rewindable entities stand where they were then, and doors as they
/// did; all else is where it is now. Nothing is hit that has appeared, respawned or jumped since,
/// or is hidden now.
SeenHit ray_cast_as_seen(const ZoneState& state,
                         ClientId client,
                         const Seen& seen,
                         const Vec3& origin,
                         const Vec3& direction,
                         float max_distance,
                         EntityId ignore);

}  // namespace zoned::zone

// PoseHistory: the poses of rewindable entities in the last ticks.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace zoned::zone {

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

    template <class Archive>
    void serialize(Archive& archive) {
        const std::size_t kept = slots_.size();
        archive(slots_, newest_);
        if constexpr (Archive::kReads) {
            bool fits = slots_.size() == kept;
            for (const PosesOfTick& slot : slots_) {
                fits = fits && slot.position.size() == slot.entity.size() &&
                       slot.orientation.size() == slot.entity.size();
            }
            if (!fits) {
                archive.fail("poses of earlier ticks are more or fewer than their entities");
            }
        }
    }

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

}  // namespace zoned::zone

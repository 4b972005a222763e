// RulesTimers: the calls that the rules of a zone asked for, by the tick in which they are due.
#pragma once

#include "server/zone/rules_context.h"
#include "shared/core/state_hash.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace zoned::zone {

/// More than these a zone does not hold: rules that start one a tick and forget it meet an end.
inline constexpr std::size_t kMostTimers = 100'000;

struct RulesTimer {
    Tick due = 0;
    DueTimer call;
};

/// A binary heap by tick and id: due timers come in an order that depends on nothing else.
class RulesTimers {
  public:
    [[nodiscard]] bool empty() const { return heap_.empty(); }

    [[nodiscard]] std::size_t size() const { return heap_.size(); }

    /// Whether one is due in tick `now` or was before.
    [[nodiscard]] bool due(Tick now) const { return !heap_.empty() && heap_.front().due <= now; }

    /// None: there are kMostTimers.
    TimerId start(ZoneId zone, Tick due, EntityId entity, std::uint16_t kind, Bytes payload);
    void stop(TimerId timer);

    /// The first of those that are due, which is gone with it; none: no other is.
    std::optional<DueTimer> next(Tick now);

    /// The timers of an entity that goes to another zone, and of one that came here. All timers are
    /// looked at, as by stop().
    std::vector<RulesTimer> take(EntityId entity);
    void give(std::vector<RulesTimer> timers);

    /// All of them, as if each was stopped.
    void clear();

    /// Chains the changes since the last call.
    void hash_changes(core::StateHash& hash);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(heap_, started_, changes_, changed_);
    }

  private:
    void add(RulesTimer timer);
    void note(const RulesTimer& timer);
    template <class Which>
    std::vector<RulesTimer> remove(Which&& which);

    std::vector<RulesTimer> heap_;
    std::uint64_t started_ = 0;
    std::uint64_t changes_ = 0;  ///< a mix of them since the last hash
    bool changed_ = false;
};

}  // namespace zoned::zone

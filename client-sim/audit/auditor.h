// Auditor: compares the states that one client predicted and displayed at a tick with the server's
// truth.
#pragma once

#include "client-sim/audit/audited_client.h"
#include "client-sim/audit/tally.h"
#include "client-sim/audit/update_age.h"

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace zoned::audit {

/// Outcome of the comparison in a frozen world.
struct FrozenState {
    bool seen = false;       ///< a frozen record came
    bool converged = false;  ///< the newest one matched exactly
    std::string difference;  ///< the first difference of the newest record
};

/// Audits one client. A record is compared a little after its tick, when losses and late packets
/// around it are known.
class Auditor {
  public:
    /// `spread_s` as in bound.h.
    explicit Auditor(std::size_t index, double spread_s = 0.0)
        : index_(index),
          spread_s_(spread_s) {}

    void add(const wire::AuditRecordMessage& record);
    /// Compares every record that is due.
    void settle(const view::Player& player, const AuditedClient& client, Tally& tally);

    [[nodiscard]] const FrozenState& frozen() const { return frozen_; }

    void forget_frozen() { frozen_ = {}; }

    /// A resume, a new session or a view that was set back: no entity was known before.
    void restart();

    static constexpr std::size_t kMaxWaiting = 16;

  private:
    struct ListedEntity {
        Tick must_know_since = -1;  ///< first record of an unbroken row of records; -1: not now
        Tick listed = -1;           ///< newest record that listed it
    };

    struct Context {
        const view::View* view = nullptr;
        const AuditedClient* client = nullptr;
        const view::WorldInfo* world = nullptr;
        Tick tick = 0;
        Tick shown_at = 0;  ///< the view tick at which `tick` was displayed
        double rtt_s = 0.0;
        clock::RoundTrip path;  ///< the same with its variation
        link::UpdateAge age;
        bool stale = false;
        bool lost_again = false;
        bool all_named = false;  ///< as `complete` of age_of()
        Tick grace = 0;          ///< ticks that an update about appearing or leaving may take
        Tick postponed = 0;      ///< of one entity: as SentUpdates
        Tick avatar_discontinuity = 0;
        Tick avatar_radii = 0;
    };

    /// The context for one entity, with the greatest age of its updates.
    [[nodiscard]] Context about(const Context& context, EntityId entity) const;
    /// True when the budget delayed the entity, and the client was notified.
    [[nodiscard]] static bool was_postponed(const Context& context);

    void compare(const view::Player& player,
                 const AuditedClient& client,
                 const wire::AuditRecordMessage& record,
                 Tally& tally);
    static void compare_environment(const view::View& view,
                                    const wire::AuditRecordMessage& record,
                                    Tally& tally);
    void compare_entity(const Context& context,
                        const wire::AuditEntityMessage& truth,
                        Tally& tally);
    void compare_state(const Context& context,
                       const wire::AuditEntityMessage& truth,
                       const view::Entity& entity,
                       const view::Version& version,
                       Tally& tally) const;
    /// The declared fields of an entity, which are exact.
    void compare_fields(const Context& context,
                        const wire::AuditEntityMessage& truth,
                        const view::Entity& entity,
                        Tally& tally) const;
    [[nodiscard]] bool is_leaving(const Context& context,
                                  const wire::AuditEntityMessage& truth,
                                  const view::Entity& entity) const;
    /// The view's version of an entity for a tick near the record's.
    [[nodiscard]] static const view::Version* held(const Context& context,
                                                   const view::Entity& entity,
                                                   Tick tick);
    void find_extra(const Context& around, Tally& tally);
    void remember(const wire::AuditRecordMessage& record);
    void compare_frozen(const view::View& view,
                        EntityId avatar,
                        const wire::AuditRecordMessage& record);
    [[nodiscard]] double promised_bound(const Context& context,
                                        const wire::AuditEntityMessage& truth,
                                        bool orientation) const;

    std::size_t index_;
    double spread_s_;
    std::deque<wire::AuditRecordMessage> waiting_;
    std::map<std::uint32_t, ListedEntity> seen_;
    std::map<std::uint32_t, SentUpdates> sent_updates_;  ///< of the record being compared
    Tick previous_tick_ = -1;
    double least_rtt_s_ = std::numeric_limits<double>::infinity();
    FrozenState frozen_;
};

}  // namespace zoned::audit

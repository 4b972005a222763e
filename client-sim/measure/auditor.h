// Auditor: compares the states that one bot predicted and displayed at a tick with the server's
// truth.
#pragma once

#include "client-sim/bot/bot.h"
#include "client-sim/measure/update_age.h"
#include "shared/core/histogram.h"

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace zoned::measure {

enum class FindingKind : std::uint8_t {
    kPosition,     ///< predicted position beyond the promised bound
    kOrientation,  ///< predicted orientation beyond the promised bound
    kMissing,      ///< must be known, is not in the view
    kExtra,        ///< in the view, must not be known: a leak
    kField,        ///< a declared field has another value, and had time to come
};

/// One departure from the promise.
struct Finding {
    FindingKind kind = FindingKind::kPosition;
    std::size_t bot = 0;
    Tick tick = 0;
    EntityId entity;
    std::string type;
    double error = 0.0;    ///< m or rad
    double allowed = 0.0;  ///< m or rad
    double age_s = 0.0;    ///< D
    double distance_m = 0.0;
    bool loss = false;
};

/// The findings of all auditors of a run.
struct Tally {
    static constexpr std::size_t kWorst = 20;

    core::Histogram predicted_m;
    core::Histogram displayed_m;
    core::Histogram predicted_rad;
    core::Histogram displayed_rad;
    core::Histogram update_age_s;
    core::Histogram usual_age_s;  ///< the age on the same network path without any disturbance
    std::uint64_t records = 0;
    std::uint64_t samples = 0;
    std::uint64_t samples_after_loss = 0;  ///< of samples: judged with the allowance for a resend
    std::uint64_t samples_lost_again =
        0;                                ///< of these: with more than one resend, see update_age.h
    std::uint64_t samples_stale = 0;      ///< of samples: judged with an age that is_stale()
    std::uint64_t skipped_late = 0;       ///< records older than the history
    std::uint64_t skipped_unsettled = 0;  ///< records before clock and view had settled
    std::uint64_t skipped_undisplayed = 0;  ///< records of ticks that an interpolating view jumped
    std::uint64_t skipped_unmeasured = 0;   ///< records without any packet around
    std::uint64_t skipped_discontinuity = 0;  ///< samples within D after a spawn or teleport
    std::uint64_t skipped_leaving = 0;        ///< samples of entities whose removal was in flight
    std::uint64_t samples_widened = 0;  ///< of samples: under bounds that the server declared wider
    std::uint64_t samples_unbounded = 0;  ///< not judged: the server declared no bound
    /// Not judged: the budget delayed exactly these, and the client was notified that entities are
    /// missing.
    std::uint64_t missing_notified = 0;
    std::uint64_t position_violations = 0;
    std::uint64_t orientation_violations = 0;
    std::uint64_t missing = 0;
    std::uint64_t extra = 0;
    std::uint64_t malformed = 0;
    std::uint64_t field_samples = 0;  ///< values of declared fields
    std::uint64_t field_violations = 0;
    std::uint64_t field_recent = 0;    ///< not judged: changed so lately that it may be on its way
    std::uint64_t field_notified = 0;  ///< not judged: the client was notified that it is late
    std::uint64_t environment_samples = 0;     ///< values of clocks and shared variables
    std::uint64_t environment_violations = 0;  ///< of these: values that differ from the server's
    double environment_error_max = 0.0;
    std::vector<Finding> worst;  ///< by the excess over the allowed error, largest first

    void add(const Finding& finding);
};

/// Outcome of the comparison in a frozen world.
struct FrozenState {
    bool seen = false;       ///< a frozen record came
    bool converged = false;  ///< the newest one matched exactly
    std::string difference;  ///< the first difference of the newest record
};

/// Audits one bot. A record is compared a little after its tick, when losses and late packets
/// around it are known.
class Auditor {
  public:
    /// `spread_s` as in bound.h.
    explicit Auditor(std::size_t bot, double spread_s = 0.0) : bot_(bot), spread_s_(spread_s) {}

    void add(const wire::AuditRecordMessage& record);
    /// Compares every record that is due.
    void settle(const bot::Bot& bot, Tally& tally);

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
        const bot::Bot* bot = nullptr;
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

    void compare(const bot::Bot& bot, const wire::AuditRecordMessage& record, Tally& tally);
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
    void compare_frozen(const bot::Bot& bot, const wire::AuditRecordMessage& record);
    [[nodiscard]] double promised_bound(const Context& context,
                                        const wire::AuditEntityMessage& truth,
                                        bool orientation) const;

    std::size_t bot_;
    double spread_s_;
    std::deque<wire::AuditRecordMessage> waiting_;
    std::map<std::uint32_t, ListedEntity> seen_;
    std::map<std::uint32_t, SentUpdates> sent_updates_;  ///< of the record being compared
    Tick previous_tick_ = -1;
    double least_rtt_s_ = std::numeric_limits<double>::infinity();
    FrozenState frozen_;
};

}  // namespace zoned::measure

#include "client-sim/audit/auditor.h"

#include "client-sim/audit/bound.h"
#include "shared/core/elementary/elementary.h"
#include "shared/motion/dead_reckoning.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

namespace zoned::audit {

namespace {

/// Wait this long after a record's tick, so that late packets are no longer taken for lost ones.
constexpr double kHoldS = 0.3;
/// The next packet shows the age of the updates at a tick: wait this long for it.
constexpr double kPatienceS = 2.0;

/// A thousand years: beyond it arithmetic with ticks could overflow.
bool is_tick(std::int64_t tick) {
    return tick >= -(Tick{1} << 40) && tick <= (Tick{1} << 40);
}

/// Codes beyond a range differ from all that a client can hold, and are found so.
bool sound_fields(const wire::AuditEntityMessage& e, const wire::FieldSchema* schema) {
    const std::size_t words = schema != nullptr ? schema->words() : 0;
    const std::size_t fields = schema != nullptr ? schema->fields().size() : 0;
    return e.field_words.size() == words && e.field_ticks.size() == fields &&
           std::all_of(e.field_ticks.begin(), e.field_ticks.end(), is_tick);
}

bool well_formed(const wire::AuditRecordMessage& record, const view::WorldInfo& world) {
    if (!is_tick(record.tick) || !is_tick(record.avatar_discontinuity_tick) ||
        !is_tick(record.avatar_radii_tick) || !is_tick(record.updates_since)) {
        return false;
    }
    const auto sound = [](const wire::AuditUpdateMessage& update) {
        return update.ticks.size() == update.sequences.size() && is_tick(update.postponed_tick) &&
               std::all_of(update.ticks.begin(), update.ticks.end(), is_tick);
    };
    if (!std::all_of(record.updates.begin(), record.updates.end(), sound)) {
        return false;
    }
    return std::all_of(
        record.entities.begin(), record.entities.end(), [&](const wire::AuditEntityMessage& e) {
            return e.position.size() == 3 && e.orientation.size() == 4 &&
                   e.type < world.types.size() && is_tick(e.breach_tick) &&
                   is_tick(e.discontinuity_tick) && is_tick(e.radii_tick) &&
                   sound_fields(e, wire::schema_of(world.fields, static_cast<TypeIndex>(e.type)));
        });
}

std::map<std::uint32_t, SentUpdates> sent_updates_of(const wire::AuditRecordMessage& record) {
    std::map<std::uint32_t, SentUpdates> all;
    for (const wire::AuditUpdateMessage& update : record.updates) {
        SentUpdates& sent_updates = all[update.entity];
        sent_updates.postponed_tick = update.postponed_tick;
        sent_updates.leaving = update.leaving;
        for (std::size_t i = 0; i < update.ticks.size(); ++i) {
            sent_updates.packets.push_back({update.ticks[i], update.sequences[i]});
        }
    }
    return all;
}

Tick grace_ticks(const link::UpdateAge& age, double rtt_s, double tick_s) {
    // News of appearing or going may take D, and one round trip is granted beside.
    return static_cast<Tick>(std::ceil((age.age_s + rtt_s) / tick_s)) + 1;
}

}  // namespace

void Auditor::add(const wire::AuditRecordMessage& record) {
    // More waiting records than this come from a server that floods: the oldest goes.
    if (waiting_.size() >= kMaxWaiting) {
        waiting_.pop_front();
    }
    waiting_.push_back(record);
}

void Auditor::restart() {
    waiting_.clear();
    seen_.clear();
    previous_tick_ = -1;
}

void Auditor::settle(const view::Player& player, const AuditedClient& client, Tally& tally) {
    const view::View* view = player.view();
    if (view == nullptr) {
        waiting_.clear();
        return;
    }
    const double tick_s = view->world().tick_s;
    const auto hold =
        static_cast<Tick>(std::ceil((kHoldS + player.client().clock().rtt_s()) / tick_s));
    const auto patience = static_cast<Tick>(kPatienceS / tick_s);
    while (!waiting_.empty()) {
        const wire::AuditRecordMessage& record = waiting_.front();
        if (!well_formed(record, view->world())) {
            ++tally.malformed;
            waiting_.pop_front();
            continue;
        }
        // An interpolating view comes to the tick later; where it never does (it jumped), the time
        // that it takes at most counts instead.
        const Tick latest = record.tick + 2 * view::Playout::kMaxDelay;
        const Tick shown = view->shown_at(record.tick).value_or(latest);
        const Tick past = view->tick() - shown;
        const bool known = client.arrivals().newest_tick() >= shown || past >= patience;
        if (!record.frozen && (past < hold || !known)) {
            return;
        }
        if (record.frozen) {
            compare_frozen(*view, client.avatar(), record);
        } else {
            compare(player, client, record, tally);
        }
        waiting_.pop_front();
    }
}

void Auditor::compare(const view::Player& player,
                      const AuditedClient& client,
                      const wire::AuditRecordMessage& record,
                      Tally& tally) {
    ++tally.records;
    const view::View& view = *player.view();
    const double rtt_s = player.client().clock().rtt_s();
    const clock::RoundTrip& path = player.client().clock().round_trip();
    Context context;
    context.view = &view;
    context.client = &client;
    context.world = &view.world();
    context.tick = record.tick;
    const std::optional<Tick> shown_at = view.shown_at(record.tick);
    context.shown_at = shown_at.value_or(record.tick);
    context.age = client.arrivals().at(context.shown_at, path);
    least_rtt_s_ = std::min(least_rtt_s_, player.client().clock().min_rtt_s());
    context.stale = is_stale(
        context.age.age_s, least_rtt_s_, context.world->tick_s, context.age.loss, spread_s_);
    context.avatar_discontinuity = record.avatar_discontinuity_tick;
    context.avatar_radii = record.avatar_radii_tick;
    context.rtt_s = rtt_s;
    context.path = path;
    const double resend_s = rtt_s + context.world->tick_s;
    context.all_named =
        record.updates_since > 0 &&
        static_cast<double>(record.tick - record.updates_since) * context.world->tick_s >=
            context.age.plain_s + resend_s;
    context.grace = grace_ticks(context.age, rtt_s, context.world->tick_s);
    if (context.shown_at != context.tick) {
        const link::UpdateAge then = client.arrivals().at(context.tick, path);
        const double behind_s =
            static_cast<double>(context.shown_at - context.tick) * context.world->tick_s;
        context.age.age_s = past_age_s(context.age, then, behind_s);
        context.age.plain_s = past_plain_s(context.age, then, behind_s);
        context.age.loss = context.age.loss || then.loss;
        context.age.widened.step = std::max(context.age.widened.step, then.widened.step);
        context.age.widened.incomplete |= then.widened.incomplete;
    }
    if (client.settled_tick() < 0 || record.tick < client.settled_tick()) {
        ++tally.skipped_unsettled;
    } else if (view.tick() - record.tick > view::EntityStore::kHistoryTicks) {
        ++tally.skipped_late;
    } else if (!shown_at) {
        ++tally.skipped_undisplayed;
    } else if (!context.age.measured || client.arrivals().newest_tick() < context.shown_at) {
        ++tally.skipped_unmeasured;
    } else {
        tally.update_age_s.add(context.age.age_s);
        tally.usual_age_s.add(
            usual_age_s(least_rtt_s_, context.world->tick_s, context.age.loss, spread_s_));
        sent_updates_ = sent_updates_of(record);
        for (const wire::AuditEntityMessage& truth : record.entities) {
            compare_entity(about(context, EntityId(truth.entity)), truth, tally);
        }
        compare_environment(view, record, tally);
        remember(record);
        find_extra(context, tally);
        previous_tick_ = record.tick;
        return;
    }
    remember(record);
    previous_tick_ = record.tick;
}

Auditor::Context Auditor::about(const Context& context, EntityId entity) const {
    static const SentUpdates kNothing;
    const auto found = sent_updates_.find(entity.value);
    const SentUpdates& sent_updates = found != sent_updates_.end() ? found->second : kNothing;
    Context own = context;
    const double tick_s = context.world->tick_s;
    own.postponed = sent_updates.postponed_tick;
    own.age = age_of(context.age,
                     sent_updates,
                     context.all_named,
                     context.client->arrivals(),
                     context.tick,
                     static_cast<double>(context.shown_at) * tick_s,
                     context.path,
                     tick_s);
    own.lost_again = own.age.age_s > context.age.age_s;
    own.grace = std::max(own.grace, grace_ticks(own.age, context.rtt_s, tick_s));
    own.stale = is_stale(own.age.age_s, least_rtt_s_, tick_s, own.age.loss, spread_s_);
    return own;
}

bool Auditor::was_postponed(const Context& context) {
    return context.age.widened.incomplete && context.postponed > 0 &&
           context.tick - context.postponed <= context.grace;
}

const view::Version* Auditor::held(const Context& context, const view::Entity& entity, Tick tick) {
    return context.view->held(entity, tick, context.shown_at + tick - context.tick);
}

/// Both sides compute with the same numbers: equal to the last bit, or wrong.
void Auditor::compare_environment(const view::View& view,
                                  const wire::AuditRecordMessage& record,
                                  Tally& tally) {
    const clock::SharedEnvironment& environment = view.environment();
    const auto compare = [&](std::optional<double> mine, double truth) {
        ++tally.environment_samples;
        const double error =
            mine ? std::abs(*mine - truth) : std::numeric_limits<double>::infinity();
        if (!(error <= 0.0)) {
            ++tally.environment_violations;
            tally.environment_error_max = std::max(tally.environment_error_max, error);
        }
    };
    const auto known_by_both = [](std::size_t known, int count) {
        return std::min(known, static_cast<std::size_t>(count));
    };
    for (std::size_t c = 0; c < known_by_both(environment.clocks(), record.shared_clocks.size());
         ++c) {
        compare(environment.clock_at(c, record.tick), record.shared_clocks[c]);
    }
    for (std::size_t v = 0;
         v < known_by_both(environment.variables(), record.shared_variables.size());
         ++v) {
        compare(environment.value_at(v, record.tick), record.shared_variables[v]);
    }
    std::size_t number = 0;
    for (std::uint32_t d = 0; d < view.world().doors.size(); ++d) {
        const view::DoorInfo& door = view.world().doors[d];
        if (door.by_rules && number < record.doors.size()) {
            const bool open = view.door_courses()
                                  .open_at(d, record.tick)
                                  .value_or(door.times.open_at(record.tick));
            compare(open ? 1.0 : 0.0, record.doors[number++]);
        }
    }
    number = 0;
    for (std::uint32_t p = 0; p < view.world().platforms.size(); ++p) {
        const motion::PlatformPath& path = view.world().platforms[p].path;
        if (path.by_rules && number < record.platforms.size()) {
            const motion::PlatformCourse* course = view.platform_courses().at(p, record.tick);
            compare(
                static_cast<double>(course == nullptr ? path.start : course->along_at(record.tick)),
                static_cast<double>(record.platforms[number++]));
        }
    }
}

void Auditor::compare_entity(const Context& context,
                             const wire::AuditEntityMessage& truth,
                             Tally& tally) {
    const EntityId id(truth.entity);
    if (id == context.client->avatar()) {
        return;
    }
    const view::Entity* entity = context.view->store().find(id);
    const view::Version* version =
        entity != nullptr ? held(context, *entity, context.tick) : nullptr;
    if (version != nullptr && version->present) {
        if (context.tick - truth.discontinuity_tick <= context.grace &&
            truth.discontinuity_tick > 0) {
            ++tally.skipped_discontinuity;
            return;
        }
        if (is_leaving(context, truth, *entity)) {
            ++tally.skipped_leaving;
            return;
        }
        compare_state(context, truth, *entity, *version, tally);
        if (!truth.field_words.empty() && context.tick - version->event_tick >= 2 * context.grace) {
            compare_fields(context, truth, *entity, tally);
        }
        return;
    }
    const auto before = seen_.find(truth.entity);
    // Only an unbroken row of records counts: the one before must have listed the entity as well.
    const bool due =
        truth.must_know && before != seen_.end() && before->second.listed >= previous_tick_ &&
        before->second.must_know_since >= 0 && truth.discontinuity_tick <= previous_tick_ &&
        context.avatar_discontinuity <= previous_tick_ &&
        context.tick - before->second.must_know_since >= context.grace &&
        context.tick - truth.discontinuity_tick >= context.grace &&
        context.tick - context.avatar_discontinuity >= context.grace &&
        // A change of stance changes the entities in reach from one tick to the next. Where one
        // came after the record before, the entity may have gone since and have come back just now.
        truth.radii_tick <= previous_tick_ && context.avatar_radii <= previous_tick_ &&
        context.tick - truth.radii_tick >= context.grace &&
        context.tick - context.avatar_radii >= context.grace &&
        // The entity may have been out of reach or sight between two records, as where somebody
        // looks round through a spyglass. Nobody knows when it came back: perhaps just now.
        (version == nullptr || (version->event_tick <= previous_tick_ &&
                                context.tick - version->event_tick >= context.grace));
    if (due && was_postponed(context)) {
        ++tally.missing_notified;
    } else if (due) {
        Finding finding;
        finding.kind = FindingKind::kMissing;
        finding.client = index_;
        finding.tick = context.tick;
        finding.entity = id;
        finding.type = context.world->types[truth.type].name;
        finding.error = static_cast<double>(context.tick - before->second.must_know_since) *
                        context.world->tick_s;
        finding.allowed = static_cast<double>(context.grace) * context.world->tick_s;
        finding.age_s = context.age.age_s;
        finding.distance_m = static_cast<double>(truth.distance_m);
        finding.loss = context.age.loss;
        tally.add(finding);
    }
}

/// Values are exact: what the client has of publications up to the tick is what the server had, but
/// for changes that may be on their way. One may wait for the field's rate limit, and for two news:
/// the second where the entity passes to another stream while the first was lost.
void Auditor::compare_fields(const Context& context,
                             const wire::AuditEntityMessage& truth,
                             const view::Entity& entity,
                             Tally& tally) const {
    const wire::FieldSchema& schema =
        *wire::schema_of(context.world->fields, static_cast<TypeIndex>(truth.type));
    const std::span<const std::uint32_t> mine = view::EntityStore::fields_at(entity, context.tick);
    for (std::size_t i = 0; i < schema.fields().size(); ++i) {
        const wire::DeclaredField& field = schema.fields()[i];
        const Tick since = context.tick - truth.field_ticks[i];
        const Tick allowed = field.interval + 2 * context.grace;
        if (since < allowed) {
            ++tally.field_recent;
            continue;
        }
        ++tally.field_samples;
        const bool same = !mine.empty() && std::equal(mine.begin() + field.word,
                                                      mine.begin() + field.word + field.words,
                                                      truth.field_words.begin() + field.word);
        if (same) {
            continue;
        }
        if (was_postponed(context)) {
            ++tally.field_notified;
            continue;
        }
        Finding finding;
        finding.kind = FindingKind::kField;
        finding.client = index_;
        finding.tick = context.tick;
        finding.entity = EntityId(truth.entity);
        finding.type = context.world->types[truth.type].name + " field '" + field.name + "'";
        finding.error = static_cast<double>(since) * context.world->tick_s;
        finding.allowed = static_cast<double>(allowed) * context.world->tick_s;
        finding.age_s = context.age.age_s;
        finding.distance_m = static_cast<double>(truth.distance_m);
        finding.loss = context.age.loss;
        tally.add(finding);
    }
}

/// Between the radii and the radii with hysteresis an entity may be known or not, and nothing is
/// promised of an entity that is no longer received. Where the update about its leaving came within
/// the time that updates may take, it had left.
bool Auditor::is_leaving(const Context& context,
                         const wire::AuditEntityMessage& truth,
                         const view::Entity& entity) const {
    if (truth.must_know) {
        return false;
    }
    const view::Version* later = held(context, entity, context.tick + context.grace);
    return later != nullptr && !later->present;
}

double Auditor::promised_bound(const Context& context,
                               const wire::AuditEntityMessage& truth,
                               bool orientation) const {
    const std::size_t lods = context.world->lods.size();
    const auto wider = [&](std::size_t lod) {
        return wire::widening(context.age.widened.step, lod, lods);
    };
    const double now = static_cast<double>(orientation ? truth.bound_rad : truth.bound_m) *
                       wider(lod_at(*context.world, static_cast<double>(truth.distance_m)));
    // The client's state was promised D ago, when the entity may have been farther away.
    const auto ago = static_cast<Tick>(std::ceil(context.age.age_s / context.world->tick_s));
    const Tick then = context.tick - ago;
    const view::EntityStore& store = context.view->store();
    const view::Entity* entity = store.find(EntityId(truth.entity));
    const view::Version* version = entity != nullptr ? held(context, *entity, then) : nullptr;
    const auto here = context.view->own().position_at(then);
    if (version == nullptr || !version->present || !here) {
        return now;
    }
    const Vec3d apart = store.predicted(*version, then).position - *here;
    const std::size_t level = lod_at(*context.world, elementary::hypot(apart.x(), apart.z()));
    const view::Lod& lod = context.world->lods[level];
    const double past =
        static_cast<double>(orientation ? lod.orientation_bound_rad : lod.position_bound_m) *
        wider(level);
    return std::max(now, past);
}

void Auditor::compare_state(const Context& context,
                            const wire::AuditEntityMessage& truth,
                            const view::Entity& entity,
                            const view::Version& version,
                            Tally& tally) const {
    if (context.age.widened.step == wire::kNoBound) {
        ++tally.samples_unbounded;
        return;
    }
    tally.samples_widened += context.age.widened.step > 0 ? 1 : 0;
    const view::TypeInfo& type = context.world->types[truth.type];
    const wire::Quantization q = wire::at_lod(context.world->quantization, version.lod);
    const view::EntityStore& store = context.view->store();
    const view::WorldState predicted = store.predicted(version, context.tick);
    const view::WorldState displayed =
        context.view->displayed(entity, version, context.tick, context.shown_at);
    const Vec3d position(truth.position[0], truth.position[1], truth.position[2]);
    const Quat orientation(
        truth.orientation[0], truth.orientation[1], truth.orientation[2], truth.orientation[3]);
    const double error_m = (predicted.position - position).norm();
    const auto error_rad =
        static_cast<double>(motion::angle_between(predicted.orientation, orientation));
    ++tally.samples;
    tally.samples_after_loss += context.age.loss ? 1 : 0;
    tally.samples_lost_again += context.lost_again ? 1 : 0;
    tally.samples_stale += context.stale ? 1 : 0;
    tally.predicted_m.add(error_m);
    tally.predicted_rad.add(error_rad);
    tally.displayed_m.add((displayed.position - position).norm());
    tally.displayed_rad.add(
        static_cast<double>(motion::angle_between(displayed.orientation, orientation)));

    BoundInputs inputs;
    inputs.age_s = context.age.age_s;
    if (truth.breach_tick > 0) {
        inputs.since_breach_s =
            static_cast<double>(context.tick - truth.breach_tick) * context.world->tick_s;
    }
    Finding finding;
    finding.client = index_;
    finding.tick = context.tick;
    finding.entity = EntityId(truth.entity);
    finding.type = type.name;
    finding.age_s = inputs.age_s;
    finding.distance_m = static_cast<double>(truth.distance_m);
    finding.loss = context.age.loss;

    inputs.bound = promised_bound(context, truth, false);
    inputs.quantum = static_cast<double>(q.position_quantum_m());
    finding.error = error_m;
    finding.allowed = allowed_position_error(inputs,
                                             static_cast<double>(type.max_acceleration_mps2),
                                             static_cast<double>(type.max_velocity_jump_mps));
    // Written so that an error that is not a number counts as a violation.
    if (!(finding.error <= finding.allowed)) {
        finding.kind = FindingKind::kPosition;
        tally.add(finding);
    }
    inputs.bound = promised_bound(context, truth, true);
    inputs.quantum = static_cast<double>(q.orientation_quantum_rad(type.upright));
    finding.error = error_rad;
    finding.allowed = allowed_orientation_error(
        inputs, type.character, static_cast<double>(type.max_spin_jump_rps));
    if (!(finding.error <= finding.allowed)) {
        finding.kind = FindingKind::kOrientation;
        tally.add(finding);
    }
}

void Auditor::find_extra(const Context& around, Tally& tally) {
    if (previous_tick_ < 0 || around.tick - previous_tick_ < around.grace ||
        around.tick - around.avatar_discontinuity < around.grace) {
        return;
    }
    for (const auto& [id, entity] : around.view->store().entities()) {
        const view::Version* version = held(around, entity, around.tick);
        // In the view all the time between two records, and in neither of them.
        if (version == nullptr || !version->present || entity.present_since > previous_tick_ ||
            id == around.client->avatar()) {
            continue;
        }
        const auto seen = seen_.find(id.value);
        if (seen != seen_.end() && seen->second.listed >= previous_tick_) {
            continue;
        }
        // Only word of its leaving that was lost, or had to wait, excuses that it is still there.
        const auto sent_updates = sent_updates_.find(id.value);
        const bool leaving = sent_updates != sent_updates_.end() && sent_updates->second.leaving;
        const Context context = leaving ? about(around, id) : around;
        if (was_postponed(context)) {
            ++tally.missing_notified;
            continue;
        }
        if (context.tick - previous_tick_ < context.grace) {
            continue;
        }
        Finding finding;
        finding.kind = FindingKind::kExtra;
        finding.client = index_;
        finding.tick = context.tick;
        finding.entity = id;
        finding.type = entity.typed ? context.world->types[entity.type].name : "?";
        finding.error = static_cast<double>(context.tick - previous_tick_) * context.world->tick_s;
        finding.allowed = static_cast<double>(context.grace) * context.world->tick_s;
        finding.age_s = context.age.age_s;
        finding.loss = context.age.loss;
        tally.add(finding);
    }
}

void Auditor::remember(const wire::AuditRecordMessage& record) {
    std::erase_if(seen_, [&](const auto& entry) { return entry.second.listed < previous_tick_; });
    for (const wire::AuditEntityMessage& truth : record.entities) {
        auto [at, fresh] = seen_.try_emplace(truth.entity);
        ListedEntity& seen = at->second;
        // An entity that was away or elsewhere between two records became known anew.
        const bool jumped = truth.discontinuity_tick > previous_tick_ ||
                            record.avatar_discontinuity_tick > previous_tick_;
        const bool unbroken =
            !fresh && !jumped && seen.listed >= previous_tick_ && seen.must_know_since >= 0;
        if (!truth.must_know) {
            seen.must_know_since = -1;
        } else if (!unbroken) {
            seen.must_know_since = record.tick;
        }
        seen.listed = record.tick;
    }
}

}  // namespace zoned::audit

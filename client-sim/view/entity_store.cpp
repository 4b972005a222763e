#include "client-sim/view/entity_store.h"

#include "shared/motion/dead_reckoning.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::view {

namespace {

/// A removed entity's keyframes are kept this long: older ones are no longer referred to.
constexpr Tick kTombstoneTicks = 1800;

}  // namespace

EntityStore::EntityStore(const WorldInfo& world, const DisplaySettings& settings)
    : world_(&world),
      settings_(settings) {
    settings_.keep_history = settings.keep_history || settings.past;
}

Vec3d EntityStore::origin(ZoneId zone) const {
    const ZoneInfo* info = world_->zone(zone);
    return info != nullptr ? info->origin : Vec3d::Zero();
}

const Entity* EntityStore::find(EntityId entity) const {
    const auto found = entities_.find(entity);
    return found == entities_.end() ? nullptr : &found->second;
}

const ReceivedKeyframe* EntityStore::keyframe(EntityId entity,
                                              ZoneId zone,
                                              std::uint8_t lod,
                                              std::uint8_t number) const {
    const Entity* known = find(entity);
    if (known == nullptr) {
        return nullptr;
    }
    for (const ReceivedKeyframe& k : known->keyframes) {
        if (k.number == number && k.lod == lod && k.zone == zone) {
            return &k;
        }
    }
    return nullptr;
}

void EntityStore::store_keyframe(Entity& entity,
                                 const Record& record,
                                 const wire::QuantizedState& state) {
    const ReceivedKeyframe fresh{
        record.zone, record.head.lod, record.head.keyframe, record.sequence, state};
    for (ReceivedKeyframe& k : entity.keyframes) {
        if (k.number == fresh.number && k.lod == fresh.lod && k.zone == fresh.zone) {
            // Numbers come round: a packet that was late must not bring an older one back.
            if (fresh.sequence >= k.sequence) {
                k = fresh;
            }
            return;
        }
    }
    if (entity.keyframes.size() < kKeyframes) {
        entity.keyframes.push_back(fresh);
        return;
    }
    *std::min_element(entity.keyframes.begin(),
                      entity.keyframes.end(),
                      [](const ReceivedKeyframe& a, const ReceivedKeyframe& b) {
                          return a.sequence < b.sequence;
                      }) = fresh;
}

bool EntityStore::newer(const Version& shown, const Record& record) {
    if (!shown.present) {
        return record.sequence > shown.sequence;
    }
    if (shown.zone == record.zone && shown.lod == record.head.lod) {
        return record.publication_tick > shown.publication_tick;
    }
    return record.sequence > shown.sequence;
}

ApplyOutcome EntityStore::apply(const Record& record,
                                const wire::QuantizedState& state,
                                const wire::DeclaredUpdate* declared) {
    auto found = entities_.find(record.head.entity);
    if (found == entities_.end()) {
        if (record.head.kind != wire::RecordKind::kAbsolute || entities_.size() >= kMaxEntities) {
            return ApplyOutcome::kNoKeyframe;
        }
        found = entities_.emplace(record.head.entity, Entity{}).first;
    }
    Entity& entity = found->second;
    if (record.head.kind == wire::RecordKind::kAbsolute) {
        entity.type = record.head.type;
        entity.typed = true;
        if (!record.coded) {
            store_keyframe(entity, record, state);
        }
    }
    if (!entity.versions.empty()) {
        Version& shown = entity.versions.back();
        if (!newer(shown, record)) {
            const bool again = shown.present && shown.zone == record.zone &&
                               shown.lod == record.head.lod &&
                               shown.publication_tick == record.publication_tick;
            if (again) {
                shown.sequence = std::max(shown.sequence, record.sequence);
                entity.heard_s = record.now_s;
                entity.confirmed = true;
            }
            return again ? ApplyOutcome::kOld : keep_late(entity, record, state);
        }
    }
    show(entity, record, state);
    if (!world_->fields.empty()) {
        follow_fields(entity, record, declared);
    }
    return ApplyOutcome::kShown;
}

/// The newest publication says of each field that changed since a record which this client holds,
/// so what is known of all others still is.
void EntityStore::follow_fields(Entity& entity,
                                const Record& record,
                                const wire::DeclaredUpdate* declared) {
    const wire::FieldSchema* schema = wire::schema_of(world_->fields, entity.type);
    if (schema == nullptr) {
        entity.fields.clear();
        return;
    }
    wire::DeclaredUpdate nothing;
    nothing.whole = record.head.kind == wire::RecordKind::kAbsolute;
    if (declared == nullptr) {
        declared = &nothing;
    }
    const bool known =
        !entity.fields.empty() && entity.fields.back().words.size() == schema->words();
    if (known && !declared->whole && declared->mask == 0) {
        return;
    }
    if (!known) {
        entity.fields.assign(1, {record.publication_tick, {}});
    } else if (settings_.keep_history) {
        // A row holds until the next one: the newest of those beyond the history stays.
        const Tick oldest = record.publication_tick - 2 * kHistoryTicks;
        const auto recent = std::find_if(
            entity.fields.begin() + 1, entity.fields.end(), [oldest](const FieldRow& row) {
                return row.publication_tick > oldest;
            });
        entity.fields.erase(entity.fields.begin(), recent - 1);
        entity.fields.push_back(entity.fields.back());
    }
    entity.fields.back().publication_tick = record.publication_tick;
    wire::apply_declared(*schema, *declared, entity.fields.back().words);
}

std::span<const std::uint32_t> EntityStore::fields_at(const Entity& entity, Tick tick) {
    for (auto row = entity.fields.rbegin(); row != entity.fields.rend(); ++row) {
        if (row->publication_tick <= tick) {
            return row->words;
        }
    }
    return {};
}

Version EntityStore::version_of(const Entity& entity,
                                const Record& record,
                                const wire::QuantizedState& state) const {
    Version version;
    version.from_tick = record.view_tick + 1;
    version.present = true;
    version.zone = record.zone;
    version.lod = record.head.lod;
    version.publication_tick = record.publication_tick;
    version.event_tick = record.publication_tick;
    version.sequence = record.sequence;
    version.quantized = state;
    version.state = wire::dequantize(
        state, upright(entity.type), wire::at_lod(world_->quantization, record.head.lod));
    return version;
}

/// A publication that was overtaken held until that of the same stream which overtook it.
ApplyOutcome EntityStore::keep_late(Entity& entity,
                                    const Record& record,
                                    const wire::QuantizedState& state) {
    const Version& newest = entity.versions.back();
    const auto same = [&](const Version& v) {
        return v.publication_tick == record.publication_tick && v.zone == record.zone &&
               v.lod == record.head.lod;
    };
    const bool known =
        std::ranges::any_of(entity.versions, same) || std::ranges::any_of(entity.late, same);
    if (!settings_.past || known || !newest.present || newest.zone != record.zone ||
        newest.lod != record.head.lod ||
        record.publication_tick < record.view_tick - kHistoryTicks) {
        return ApplyOutcome::kOld;
    }
    std::erase_if(entity.late,
                  [&](const Version& v) { return v.from_tick < record.view_tick - kHistoryTicks; });
    entity.late.push_back(version_of(entity, record, state));
    return ApplyOutcome::kLate;
}

void EntityStore::show(Entity& entity, const Record& record, const wire::QuantizedState& state) {
    Version next = version_of(entity, record, state);
    const bool same_stream = entity.present() && entity.versions.back().zone == next.zone &&
                             entity.versions.back().lod == next.lod;
    if (!same_stream) {
        next.event_tick = std::max(record.packet_tick, record.publication_tick);
    }
    if (entity.present()) {
        const Version& before = entity.versions.back();
        motion::KinematicState shown = local_display(before, static_cast<double>(record.view_tick));
        if (before.zone != next.zone) {
            shown.position += (origin(before.zone) - origin(next.zone)).cast<float>();
        }
        // Blending starts where the new prediction was at that tick, even before its publication.
        const motion::KinematicState now =
            local_base(next, static_cast<double>(record.view_tick), true);
        next.converging = settings_.convergence != motion::ConvergenceMethod::kSnap &&
                          (shown.position - now.position).norm() < kSnapM;
        next.convergence.begin(shown, now, next.converging ? kBlendS : 0.0F);
    } else {
        entity.present_since = next.from_tick;
        ++present_count_;
    }
    entity.heard_s = record.now_s;
    entity.confirmed = true;
    push_version(entity, next, record.view_tick);
}

bool EntityStore::remove(EntityId id, std::uint64_t sequence, Tick packet_tick, Tick view_tick) {
    const auto found = entities_.find(id);
    if (found == entities_.end()) {
        // The remove overtook the first record: remembered, so that the late record stays out.
        if (entities_.size() >= kMaxEntities) {
            return false;
        }
        Version gone;
        gone.from_tick = view_tick + 1;
        gone.event_tick = packet_tick;
        gone.sequence = sequence;
        entities_[id].versions.push_back(gone);
        return false;
    }
    Entity& entity = found->second;
    if (entity.versions.empty()) {
        return false;
    }
    Version& shown = entity.versions.back();
    if (sequence <= shown.sequence) {
        return false;
    }
    if (!shown.present) {
        shown.sequence = sequence;
        return false;
    }
    Version gone;
    gone.from_tick = view_tick + 1;
    gone.event_tick = packet_tick;
    gone.sequence = sequence;
    --present_count_;
    push_version(entity, gone, view_tick);
    return true;
}

void EntityStore::push_version(Entity& entity, Version version, Tick view_tick) {
    std::vector<Version>& versions = entity.versions;
    if (!settings_.keep_history) {
        versions.clear();
    } else {
        // Between two evaluations only the newest counts: nothing else was ever displayed.
        if (!settings_.past && !versions.empty() &&
            versions.back().from_tick >= version.from_tick) {
            versions.pop_back();
        }
        std::size_t old = 0;
        while (old + 1 < versions.size() &&
               versions[old + 1].from_tick < view_tick - kHistoryTicks) {
            ++old;
        }
        versions.erase(versions.begin(), versions.begin() + static_cast<std::ptrdiff_t>(old));
    }
    versions.push_back(std::move(version));
}

void EntityStore::prune(Tick view_tick) {
    std::erase_if(entities_, [&](const auto& entry) {
        const Entity& entity = entry.second;
        return !entity.present() && (entity.versions.empty() || entity.versions.back().from_tick <
                                                                    view_tick - kTombstoneTicks);
    });
}

void EntityStore::begin_reset() {
    for (auto& [id, entity] : entities_) {
        entity.confirmed = false;
        entity.keyframes.clear();
    }
}

std::size_t EntityStore::end_reset(Tick view_tick) {
    std::size_t gone = 0;
    for (auto& [id, entity] : entities_) {
        if (!entity.confirmed && entity.present()) {
            Version end;
            end.from_tick = view_tick + 1;
            end.event_tick = view_tick + 1;
            end.sequence = entity.versions.back().sequence;
            --present_count_;
            push_version(entity, end, view_tick);
            ++gone;
        }
        entity.confirmed = true;
    }
    return gone;
}

void EntityStore::set_back(Tick view_tick) {
    for (auto& [id, entity] : entities_) {
        entity.late.clear();
        if (entity.versions.empty()) {
            continue;
        }
        Version newest = std::move(entity.versions.back());
        newest.from_tick = std::min(newest.from_tick, view_tick);
        newest.converging = false;  // its blend began at a tick that is yet to come
        entity.versions.assign(1, std::move(newest));
        entity.present_since = std::min(entity.present_since, view_tick);
    }
}

const Version* EntityStore::version_at(const Entity& entity, Tick tick) {
    for (auto it = entity.versions.rbegin(); it != entity.versions.rend(); ++it) {
        if (it->from_tick <= tick) {
            return &*it;
        }
    }
    return nullptr;
}

const Version* EntityStore::implied(const Entity& entity, Tick tick, Tick known_by) {
    const Version* found = nullptr;
    const auto look = [&](const Version& v) {
        if (v.from_tick <= known_by && v.event_tick <= tick &&
            (found == nullptr || v.event_tick >= found->event_tick)) {
            found = &v;
        }
    };
    std::for_each(entity.late.begin(), entity.late.end(), look);
    std::for_each(entity.versions.begin(), entity.versions.end(), look);
    return found;
}

const Version* EntityStore::following(const Entity& entity, Tick tick, Tick known_by) {
    const Version* found = nullptr;
    const auto look = [&](const Version& v) {
        if (v.from_tick <= known_by && v.event_tick > tick &&
            (found == nullptr || v.event_tick < found->event_tick)) {
            found = &v;
        }
    };
    std::for_each(entity.late.begin(), entity.late.end(), look);
    std::for_each(entity.versions.begin(), entity.versions.end(), look);
    return found;
}

motion::KinematicState EntityStore::local_prediction(const Version& version,
                                                     double tick,
                                                     bool before) const {
    // News from the future (a clock estimate that runs late) is shown as it came.
    const double since = tick - static_cast<double>(version.publication_tick);
    const double elapsed = before ? since : std::max(0.0, since);
    // At rest nothing depends on how long ago that was (and the tick's low bits may have come
    // round).
    if (version.quantized.at_rest) {
        return version.state;
    }
    return motion::predict(version.state,
                           version.quantized.order,
                           static_cast<float>(elapsed) * static_cast<float>(world_->tick_s));
}

motion::KinematicState EntityStore::local_base(const Version& version,
                                               double tick,
                                               bool before) const {
    return settings_.displayed_state == DisplayedState::kPredicted
               ? local_prediction(version, tick, before)
               : motion::predict(version.state, motion::PredictorOrder::kStatic, 0.0F);
}

motion::KinematicState EntityStore::local_display(const Version& version, double tick) const {
    const motion::KinematicState now = local_base(version, tick);
    if (!version.converging) {
        return now;
    }
    const auto begun = static_cast<double>(version.from_tick - 1);
    const float elapsed =
        static_cast<float>(std::max(0.0, tick - begun)) * static_cast<float>(world_->tick_s);
    return version.convergence.display(settings_.convergence, now, elapsed);
}

std::optional<WorldState> EntityStore::interpolated(const Entity& entity,
                                                    double tick,
                                                    Tick known_by,
                                                    double* remaining_error_m) const {
    const auto whole = static_cast<Tick>(std::floor(tick));
    const Version* held = implied(entity, whole, known_by);
    if (held == nullptr || !held->present) {
        return std::nullopt;
    }
    motion::KinematicState shown = local_prediction(*held, tick);
    const Version* next = following(entity, whole, known_by);
    double remaining_m = 0.0;
    if (next != nullptr && next->present) {
        const Tick lead =
            std::min(Playout::lead_ticks(world_->tick_s), next->event_tick - held->event_tick);
        const double left = static_cast<double>(next->event_tick) - tick;
        const auto meeting = static_cast<double>(next->event_tick);
        motion::KinematicState there = local_prediction(*next, meeting);
        there.position += (origin(next->zone) - origin(held->zone)).cast<float>();
        motion::KinematicState here = local_prediction(*held, meeting);
        const float jump = (there.position - here.position).norm();
        if (left < static_cast<double>(lead) && jump < kSnapM) {
            // Convergence from the next publication back to what holds, in a time that runs
            // backwards: so velocities change their sign.
            there.velocity = -there.velocity;
            here.velocity = -here.velocity;
            const auto tick_s = static_cast<float>(world_->tick_s);
            const float period_s = static_cast<float>(lead) * tick_s;
            const float ago_s = static_cast<float>(left) * tick_s;
            motion::Convergence back;
            back.begin(there, here, period_s);
            shown.velocity = -shown.velocity;
            shown = back.display(motion::ConvergenceMethod::kHermite, shown, ago_s);
            shown.velocity = -shown.velocity;
            remaining_m = static_cast<double>(
                motion::Convergence::remaining_error(motion::ConvergenceMethod::kHermite,
                                                     jump,
                                                     ago_s,
                                                     period_s,
                                                     (there.velocity - here.velocity).norm()));
        }
    }
    if (remaining_error_m != nullptr) {
        *remaining_error_m = remaining_m;
    }
    return WorldState{
        origin(held->zone) + shown.position.cast<double>(), shown.orientation, shown.velocity};
}

WorldState EntityStore::predicted(const Version& version, Tick tick) const {
    const motion::KinematicState local = local_prediction(version, static_cast<double>(tick));
    return {
        origin(version.zone) + local.position.cast<double>(), local.orientation, local.velocity};
}

WorldState EntityStore::displayed(const Version& version, double tick) const {
    const motion::KinematicState local = local_display(version, tick);
    return {
        origin(version.zone) + local.position.cast<double>(), local.orientation, local.velocity};
}

}  // namespace zoned::view

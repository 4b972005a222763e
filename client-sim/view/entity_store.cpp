#include "client-sim/view/entity_store.h"

#include "shared/motion/dead_reckoning.h"

#include <algorithm>
#include <utility>

namespace zoned::view {

namespace {

/// A removed entity's keyframes are kept this long: older ones are no longer referred to.
constexpr Tick kTombstoneTicks = 1800;

}  // namespace

EntityStore::EntityStore(const World& world, motion::ConvergenceMethod method, bool keep_history)
    : world_(&world),
      method_(method),
      keep_history_(keep_history) {
}

Vec3d EntityStore::origin(ZoneId zone) const {
    const ZoneInfo* info = world_->zone(zone);
    return info != nullptr ? info->origin : Vec3d::Zero();
}

const Entity* EntityStore::find(EntityId entity) const {
    const auto found = entities_.find(entity);
    return found == entities_.end() ? nullptr : &found->second;
}

const Keyframe* EntityStore::keyframe(EntityId entity,
                                      ZoneId zone,
                                      std::uint8_t lod,
                                      std::uint8_t number) const {
    const Entity* known = find(entity);
    if (known == nullptr) {
        return nullptr;
    }
    for (const Keyframe& k : known->keyframes) {
        if (k.number == number && k.lod == lod && k.zone == zone) {
            return &k;
        }
    }
    return nullptr;
}

void EntityStore::store_keyframe(Entity& entity,
                                 const Record& record,
                                 const wire::QuantizedState& state) {
    const Keyframe fresh{
        record.zone, record.head.lod, record.head.keyframe, record.sequence, state};
    for (Keyframe& k : entity.keyframes) {
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
    *std::min_element(
        entity.keyframes.begin(), entity.keyframes.end(), [](const Keyframe& a, const Keyframe& b) {
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

Applied EntityStore::apply(const Record& record, const wire::QuantizedState& state) {
    auto found = entities_.find(record.head.entity);
    if (found == entities_.end()) {
        if (record.head.kind != wire::RecordKind::kAbsolute || entities_.size() >= kMaxEntities) {
            return Applied::kNoKeyframe;
        }
        found = entities_.emplace(record.head.entity, Entity{}).first;
    }
    Entity& entity = found->second;
    if (record.head.kind == wire::RecordKind::kAbsolute) {
        entity.type = record.head.type;
        entity.typed = true;
        store_keyframe(entity, record, state);
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
            return Applied::kOld;
        }
    }
    show(entity, record, state);
    return Applied::kShown;
}

void EntityStore::show(Entity& entity, const Record& record, const wire::QuantizedState& state) {
    Version next;
    next.from_tick = record.view_tick + 1;
    next.present = true;
    next.zone = record.zone;
    next.lod = record.head.lod;
    next.publication_tick = record.publication_tick;
    next.sequence = record.sequence;
    next.quantized = state;
    next.state = wire::dequantize(state, upright(entity.type), world_->quantization);
    if (entity.present()) {
        const Version& before = entity.versions.back();
        motion::KinematicState shown = local_display(before, record.view_tick);
        if (before.zone != next.zone) {
            shown.position += (origin(before.zone) - origin(next.zone)).cast<float>();
        }
        const motion::KinematicState now = local_prediction(next, record.view_tick);
        next.converging = method_ != motion::ConvergenceMethod::kSnap &&
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

bool EntityStore::remove(EntityId id, std::uint64_t sequence, Tick view_tick) {
    const auto found = entities_.find(id);
    if (found == entities_.end()) {
        // The remove overtook the first record: remembered, so that the late record stays out.
        if (entities_.size() >= kMaxEntities) {
            return false;
        }
        Version gone;
        gone.from_tick = view_tick + 1;
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
    gone.sequence = sequence;
    --present_count_;
    push_version(entity, gone, view_tick);
    return true;
}

void EntityStore::push_version(Entity& entity, Version version, Tick view_tick) {
    std::vector<Version>& versions = entity.versions;
    if (!keep_history_) {
        versions.clear();
    } else {
        // Between two evaluations only the newest counts: nothing else was ever displayed.
        if (!versions.empty() && versions.back().from_tick >= version.from_tick) {
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
            end.sequence = entity.versions.back().sequence;
            --present_count_;
            push_version(entity, end, view_tick);
            ++gone;
        }
        entity.confirmed = true;
    }
    return gone;
}

const Version* EntityStore::version_at(const Entity& entity, Tick tick) {
    for (auto it = entity.versions.rbegin(); it != entity.versions.rend(); ++it) {
        if (it->from_tick <= tick) {
            return &*it;
        }
    }
    return nullptr;
}

motion::KinematicState EntityStore::local_prediction(const Version& version, Tick tick) const {
    // News from the future (a clock estimate that runs late) is shown as it came.
    const Tick elapsed = std::max<Tick>(0, tick - version.publication_tick);
    // At rest nothing depends on how long ago that was (and the tick's low bits may have come
    // round).
    if (version.quantized.at_rest) {
        return version.state;
    }
    return motion::predict(version.state,
                           version.quantized.order,
                           static_cast<float>(elapsed) * static_cast<float>(world_->tick_s));
}

motion::KinematicState EntityStore::local_display(const Version& version, Tick tick) const {
    const motion::KinematicState now = local_prediction(version, tick);
    if (!version.converging) {
        return now;
    }
    const Tick begun = version.from_tick - 1;
    const float elapsed =
        static_cast<float>(std::max<Tick>(0, tick - begun)) * static_cast<float>(world_->tick_s);
    return version.convergence.display(method_, now, elapsed);
}

WorldState EntityStore::predicted(const Version& version, Tick tick) const {
    const motion::KinematicState local = local_prediction(version, tick);
    return {
        origin(version.zone) + local.position.cast<double>(), local.orientation, local.velocity};
}

WorldState EntityStore::displayed(const Version& version, Tick tick) const {
    const motion::KinematicState local = local_display(version, tick);
    return {
        origin(version.zone) + local.position.cast<double>(), local.orientation, local.velocity};
}

}  // namespace zoned::view

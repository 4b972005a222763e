#include "server/replication/stream_table.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <limits>

namespace zoned::replication {

namespace {

// The time that a replaced publication is watched. An older update (a second) belongs to a
// connection that is as good as lost.
constexpr Tick kWatchTicks = 30;

// A record left out of a packet has its next chance in the next tick. It must be worth its bound
// until then and while that packet is made.
constexpr float kTicksAhead = 2.0F;

bool same_place(const motion::KinematicState& a, const motion::KinematicState& b) {
    return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

}  // namespace

StreamTable::StreamTable(const ReplicationSettings& settings) : settings_(settings) {
    for (std::size_t lod = 0; lod < quantization_.size(); ++lod) {
        quantization_[lod] = wire::at_lod(settings.quantization, static_cast<std::uint8_t>(lod));
    }
}

// ---------------------------------------------------------------- subscriptions

StreamTable::EntityStreams& StreamTable::slot_of(EntityId entity) {
    const auto [it, is_new] = slot_index_.try_emplace(entity, 0);
    if (is_new) {
        if (free_slots_.empty()) {
            free_slots_.push_back(static_cast<std::uint32_t>(slots_.size()));
            slots_.emplace_back();
        }
        it->second = free_slots_.back();
        free_slots_.pop_back();
        slots_[it->second] = EntityStreams{};
        slots_[it->second].entity = entity;
        slots_[it->second].stream.fill(kNoStream);
    }
    return slots_[it->second];
}

StreamIndex StreamTable::find(EntityId entity, std::uint8_t lod) const {
    const auto it = slot_index_.find(entity);
    return it == slot_index_.end() || lod >= wire::kLods ? kNoStream
                                                         : slots_[it->second].stream[lod];
}

StreamIndex StreamTable::subscribe(EntityId entity, std::uint8_t lod) {
    ZONED_ASSERT(lod < settings_.lods.size(), "every level of detail has a bound");
    EntityStreams& slot = slot_of(entity);
    StreamIndex& index = slot.stream[lod];
    if (index == kNoStream) {
        if (free_streams_.empty()) {
            free_streams_.push_back(static_cast<StreamIndex>(streams_.size()));
            streams_.emplace_back();
            versions_.push_back(0);
        }
        index = free_streams_.back();
        free_streams_.pop_back();
        Stream& stream = streams_[index];
        stream.entity = entity;
        stream.lod = lod;
        versions_[index] = 0;
        ++used_;
        // A subscriber that comes from another level of detail still predicts from that one's
        // publication. It shares that publication's breach.
        for (const StreamIndex other : slot.stream) {
            if (other != kNoStream) {
                stream.breach_tick = std::max(stream.breach_tick, streams_[other].breach_tick);
            }
        }
    }
    ++streams_[index].subscribers;
    return index;
}

void StreamTable::unsubscribe(StreamIndex index) {
    ZONED_ASSERT(streams_[index].subscribers > 0, "a subscriber leaves once");
    if (--streams_[index].subscribers == 0) {
        abandoned_.push_back(index);
    }
}

void StreamTable::collect() {
    for (const StreamIndex index : abandoned_) {
        // It may have been taken up again, or be listed twice.
        if (streams_[index].subscribers == 0 && streams_[index].entity) {
            free_stream(index);
        }
    }
    abandoned_.clear();
}

/// Resets the stream for its next life; only the room of its byte vectors is kept.
void StreamTable::free_stream(StreamIndex index) {
    Stream& old = streams_[index];
    const auto it = slot_index_.find(old.entity);
    EntityStreams& slot = slots_[it->second];
    slot.stream[old.lod] = kNoStream;
    const bool unused = std::all_of(
        slot.stream.begin(), slot.stream.end(), [](StreamIndex s) { return s == kNoStream; });
    if (unused) {
        if (slot.fields != 0) {
            free_published_.push_back(slot.fields - 1);
        }
        slot.entity = EntityId();
        free_slots_.push_back(it->second);
        slot_index_.erase(it);
    }
    Stream fresh;
    fresh.absolute.swap(old.absolute);
    fresh.absolute.clear();
    for (std::size_t k = 0; k < kKeyframesKept; ++k) {
        fresh.keyframes[k].delta.swap(old.keyframes[k].delta);
    }
    old = std::move(fresh);
    free_streams_.push_back(index);
    --used_;
}

// ---------------------------------------------------------------- publications

void StreamTable::publish(Tick now,
                          const world::Entities& entities,
                          const world::TypeTable& types,
                          ReplicationReport& report) {
    report.streams = used_;
    for (EntityStreams& slot : slots_) {
        const world::Row row = slot.entity ? entities.find(slot.entity) : world::kNoRow;
        if (row == world::kNoRow) {
            continue;
        }
        const world::EntityType& type = types[entities.type[row]];
        const Truth truth = truth_of(now, entities, row, type, slot.estimate);
        // Of ghosts, too: the zone that owns one may have no viewers, and checks nothing then.
        if (slot.limits.exceeded(now,
                                 entities.discontinuity_tick[row],
                                 entities.position[row],
                                 entities.velocity[row],
                                 entities.angular_velocity[row],
                                 type,
                                 settings_.tick_s)) {
            report.limit_entity = entities.id[row];
            ++report.limit_exceeded;
        }
        const Tick fields_tick =
            settings_.fields.empty() ? 0 : follow_fields(slot, now, entities, row);
        for (const StreamIndex index : slot.stream) {
            if (index != kNoStream) {
                step_stream(streams_[index], now, entities, row, truth, type, fields_tick, report);
                versions_[index] = streams_[index].version;
            }
        }
    }
}

/// Publishes the declared fields that have changed, each as often as it may. Gives the tick of the
/// newest one: streams with an older publication owe it.
Tick StreamTable::follow_fields(EntityStreams& slot,
                                Tick now,
                                const world::Entities& entities,
                                world::Row row) {
    const TypeIndex type = entities.type[row];
    const wire::FieldSchema* schema = wire::schema_of(settings_.fields, type);
    if (schema == nullptr) {
        return 0;
    }
    const bool fresh = slot.fields == 0;
    if (fresh) {
        if (free_published_.empty()) {
            free_published_.push_back(static_cast<std::uint32_t>(published_.size()));
            published_.emplace_back();
        }
        slot.fields = free_published_.back() + 1;
        free_published_.pop_back();
    }
    const std::span<const std::uint32_t> values = entities.field_values(row);
    PublishedFields& published = published_[slot.fields - 1];
    if (fresh || published.type != type) {
        published.type = type;
        published.words.assign(values.begin(), values.end());
        published.changed.assign(schema->fields().size(), now);
        published.newest = now;
        return now;
    }
    if (std::equal(values.begin(), values.end(), published.words.begin())) {
        return published.newest;
    }
    for (std::size_t i = 0; i < schema->fields().size(); ++i) {
        const wire::DeclaredField& field = schema->fields()[i];
        const auto from = values.begin() + field.word;
        const auto to = published.words.begin() + field.word;
        if (now - published.changed[i] >= field.interval &&
            !std::equal(from, from + field.words, to)) {
            std::copy_n(from, field.words, to);
            published.changed[i] = now;
            published.newest = now;
        }
    }
    return published.newest;
}

wire::record::DeclaredValues StreamTable::declared_of(EntityId entity) const {
    const PublishedFields& published = published_[slots_[slot_index_.at(entity)].fields - 1];
    return {published.words, published.changed};
}

Tick StreamTable::fields_tick(EntityId entity) const {
    const auto slot = settings_.fields.empty() ? slot_index_.end() : slot_index_.find(entity);
    const std::uint32_t fields = slot != slot_index_.end() ? slots_[slot->second].fields : 0;
    return fields != 0 ? published_[fields - 1].newest : 0;
}

std::uint32_t StreamTable::declared_bytes(StreamIndex index, std::uint32_t held) const {
    if (settings_.fields.empty()) {
        return 0;
    }
    const Past* const from = held != 0 ? past(index, held) : nullptr;
    const wire::DeclaredPart part = part_of(streams_[index], from != nullptr ? from->tick : -1);
    return part.mask != 0 ? (wire::declared_bits(*part.schema, part.mask, part.words) + 7) / 8 : 0;
}

/// The fields that changed after `since`; below 0: those that are not initial.
wire::DeclaredPart StreamTable::part_of(const Stream& stream, Tick since) const {
    wire::DeclaredPart part;
    part.schema = wire::schema_of(settings_.fields, stream.type);
    if (part.schema == nullptr) {
        return part;
    }
    const wire::record::DeclaredValues values = declared_of(stream.entity);
    part.words = values.words;
    if (since < 0) {
        part.mask = wire::changed_from_initial(*part.schema, values.words);
        return part;
    }
    for (std::size_t i = 0; i < values.changed.size(); ++i) {
        part.mask |= values.changed[i] > since ? wire::FieldMask{1} << i : 0U;
    }
    return part;
}

/// The truth of a row as predictions start from it.
Truth StreamTable::truth_of(Tick now,
                            const world::Entities& entities,
                            world::Row row,
                            const world::EntityType& type,
                            MotionEstimate& estimate) const {
    Truth truth{entities.kinematic(row), &estimate, &type};
    if (!(truth.state.acceleration.norm() <= 1.001F * type.max_acceleration_mps2)) {
        // An impact, spread over a tick: it does not last, so nobody shall extrapolate it.
        truth.state.acceleration.setZero();
    }
    if (entities.has(row, world::kAtRest)) {
        estimate.rest();
        return truth;
    }
    // An acceleration counts when it takes an entity out of the bound within a second.
    estimate.observe(now,
                     entities.discontinuity_tick[row],
                     truth.state,
                     {settings_.tick_s,
                      settings_.quantization.gravity_mps2,
                      2.0F * settings_.lods.front().position_m});
    truth.state.velocity += estimate.centring();
    return truth;
}

void StreamTable::step_stream(Stream& stream,
                              Tick now,
                              const world::Entities& entities,
                              world::Row row,
                              const Truth& truth,
                              const world::EntityType& type,
                              Tick fields_tick,
                              ReplicationReport& report) {
    stream.truth = truth.state;
    const bool at_rest = entities.has(row, world::kAtRest);
    const std::uint16_t appearance = entities.appearance[row];
    const LodBound& bound = settings_.lods[stream.lod];
    if (stream.version == 0 || stream.type != entities.type[row]) {
        // Nobody holds anything that a delta could refer to; `upright` may have changed as well.
        for (Keyframe& keyframe : stream.keyframes) {
            keyframe.serial = 0;
        }
        stream.type = entities.type[row];
        stream.upright = type.upright();
        stream.priority = type.priority;
        stream.volatility.restart(now, truth.state);
        publish_state(stream, now, truth, at_rest, appearance, report);
        return;
    }
    const bool same_looks = appearance == stream.state.appearance && fields_tick <= stream.tick;
    if (at_rest && stream.at_rest && stream.watched_until <= now &&
        same_place(stream.settled, truth.state) && same_looks) {
        stream.alive_tick = now;
        return;
    }
    const bool breach = note_breach(stream, now, truth.state, type);
    if (at_rest) {
        // Rest is published exactly, so that a world that has come to rest is the same everywhere.
        const wire::QuantizedState rest = wire::quantize(truth.state,
                                                         motion::PredictorOrder::kStatic,
                                                         stream.upright,
                                                         true,
                                                         appearance,
                                                         quantization_[stream.lod]);
        if (rest == stream.state && same_looks) {
            stream.settled = truth.state;
            stream.alive_tick = now;
        } else {
            publish_state(stream, now, truth, true, appearance, report);
        }
        return;
    }
    stream.volatility.observe(
        now, truth, stream.upright, bound, quantization_[stream.lod], settings_);
    // An entity that wakes up is published when it has left the bound, not at once: it moves
    // steadily by then.
    const bool update = breach || !same_looks;
    if (update || now - stream.alive_tick >= static_cast<Tick>(settings_.heartbeat_ticks)) {
        publish_state(stream, now, truth, false, appearance, report);
        stream.heartbeat = !update;
    }
}

void StreamTable::publish_state(Stream& stream,
                                Tick now,
                                const Truth& truth,
                                bool at_rest,
                                std::uint16_t appearance,
                                ReplicationReport& report) {
    motion::PredictorOrder order = stream.volatility.best();
    if (settings_.forced_order >= 0) {
        order =
            fitting(*truth.estimate, static_cast<motion::PredictorOrder>(settings_.forced_order));
    }
    if (at_rest) {
        order = motion::PredictorOrder::kStatic;
    }
    if (stream.version > 0 && stream.breach_tick != now) {
        stream.watched_until = now + kWatchTicks;
        stream.past[stream.version % kPastKept].watched_until = stream.watched_until;
    }
    const auto quantized = [&](motion::PredictorOrder kind) {
        return wire::quantize(start_of(truth, kind, settings_),
                              kind,
                              stream.upright,
                              at_rest,
                              appearance,
                              quantization_[stream.lod]);
    };
    stream.state = quantized(order);
    const std::array<std::int32_t, 3> none{};
    if (order == motion::PredictorOrder::kQuadratic && stream.state.acceleration == none) {
        // The same prediction in fewer bits: an impact, or an entity that moves steadily for once.
        stream.state = quantized(motion::PredictorOrder::kLinear);
    }
    stream.from = wire::dequantize(stream.state, stream.upright, quantization_[stream.lod]);
    stream.settled = truth.state;
    stream.at_rest = at_rest;
    stream.tick = now;
    stream.alive_tick = now;
    Past& past = stream.past[++stream.version % kPastKept];
    if (past.watched_until > now) {
        stream.breach_tick = now;  // nobody looks any more whether truth leaves it
    }
    past = {stream.from, stream.state.order, now, stream.version, 0};
    stream.keyframe_due = ++stream.since_keyframe >= settings_.keyframe_every;
    stream.is_keyframe = false;
    stream.heartbeat = false;
    stream.absolute.clear();
    for (Keyframe& keyframe : stream.keyframes) {
        keyframe.delta_ready = false;
    }
    ++report.publications;
}

// ---------------------------------------------------------------- encoding

Encoded StreamTable::encode(StreamIndex index, std::uint32_t held) {
    Stream& stream = streams_[index];
    ZONED_ASSERT(stream.version > 0, "only what was published is encoded");
    wire::RecordHead head;
    head.entity = stream.entity;
    head.lod = stream.lod;
    head.tick_low = static_cast<std::uint8_t>(stream.tick & 0xFF);
    head.type = stream.type;
    const std::uint32_t serial = stream.last_serial + (stream.is_keyframe ? 0 : 1);
    if (stream.absolute.empty()) {
        head.kind = wire::RecordKind::kAbsolute;
        head.keyframe = static_cast<std::uint8_t>(serial % wire::kKeyframeNumbers);
        wire::encode_absolute(head,
                              stream.state,
                              stream.upright,
                              settings_.quantization,
                              stream.absolute,
                              part_of(stream, -1));
    }
    Keyframe& base = stream.keyframes[held % kKeyframesKept];
    if (held != 0 && base.serial == held && !stream.keyframe_due) {
        if (!base.delta_ready) {
            head.kind = wire::RecordKind::kDelta;
            head.keyframe = static_cast<std::uint8_t>(held % wire::kKeyframeNumbers);
            base.delta.clear();
            wire::encode_delta(head,
                               stream.state,
                               base.state,
                               stream.upright,
                               settings_.quantization,
                               base.delta,
                               part_of(stream, base.tick));
            base.delta_ready = true;
        }
        if (base.delta.size() < stream.absolute.size()) {
            return {&base.delta, 0};
        }
    }
    return {&stream.absolute, serial};
}

float StreamTable::excess(StreamIndex index, std::uint32_t version, Tick now) const {
    const Past* held = past(index, version);
    return held != nullptr ? excess(index, *held, 0.0F, 0.0F, now)
                           : std::numeric_limits<float>::infinity();
}

float StreamTable::excess(StreamIndex index,
                          const Past& held,
                          float off_m,
                          float off_rad,
                          Tick now) const {
    const Stream& stream = streams_[index];
    const LodBound& bound = settings_.lods[stream.lod];
    const float elapsed = elapsed_seconds(held.tick, now, settings_.tick_s);
    const motion::KinematicState there = motion::predict(held.from, held.order, elapsed);
    const float ahead_s = kTicksAhead * settings_.tick_s;
    const float apart_m = off_m + (there.position - stream.truth.position).norm() +
                          ahead_s * (there.velocity - stream.truth.velocity).norm();
    const float apart_rad =
        off_rad + motion::angle_between(there.orientation, stream.truth.orientation);
    return std::max(apart_m / bound.position_m, apart_rad / bound.orientation_rad);
}

std::optional<StreamTable::Predicted> StreamTable::past_at(StreamIndex index,
                                                           Tick publication,
                                                           std::uint32_t newest,
                                                           Tick at,
                                                           Tick since) const {
    // Views blend for less than this, and an update may be late by about as much.
    const auto blend_ticks = static_cast<Tick>(0.5F / settings_.tick_s);
    const Stream& stream = streams_[index];
    const auto kept = [&](std::uint32_t version) -> const Past* {
        const Past& past = stream.past[version % kPastKept];
        return version != 0 && past.version == version ? &past : nullptr;
    };
    const auto place = [&](const Past& past) {
        const float elapsed = elapsed_seconds(past.tick, std::max(at, past.tick), settings_.tick_s);
        return Vec3(motion::predict(past.from, past.order, elapsed).position);
    };
    for (std::uint32_t version = std::min(newest, stream.version); kept(version) != nullptr;
         --version) {
        const Past& past = *kept(version);
        if (past.tick > publication) {
            continue;
        }
        const Past* next = kept(version + 1);
        if (past.tick < publication || (next != nullptr && next->tick < since)) {
            return std::nullopt;
        }
        Predicted found{place(past), 0.0F};
        Vec3 newer = found.position;
        for (std::uint32_t before = version - 1; kept(before) != nullptr; --before) {
            const Past* replaced_by = kept(before + 1);
            if (replaced_by->tick < at - blend_ticks) {
                break;
            }
            const Vec3 older = place(*kept(before));
            found.blend_m += (older - newer).norm();
            newer = older;
        }
        return found;
    }
    return std::nullopt;
}

bool StreamTable::sent_absolute(StreamIndex index) {
    Stream& stream = streams_[index];
    if (stream.is_keyframe) {
        return false;
    }
    stream.is_keyframe = true;
    stream.since_keyframe = 0;
    ++stream.last_serial;
    Keyframe& keyframe = stream.keyframes[stream.last_serial % kKeyframesKept];
    keyframe.serial = stream.last_serial;
    keyframe.tick = stream.tick;
    keyframe.state = stream.state;
    keyframe.delta_ready = false;
    return true;
}

void StreamTable::hash(core::StateHash& hash) const {
    for (const EntityStreams& slot : slots_) {
        if (slot.entity && slot.fields != 0) {
            hash.add(published_[slot.fields - 1].newest);
            for (const std::uint32_t word : published_[slot.fields - 1].words) {
                hash.add(word);
            }
        }
    }
    for (const Stream& stream : streams_) {
        if (stream.entity) {
            hash.add(stream.entity.value);
            hash.add(stream.lod);
            hash.add(stream.version);
            hash.add(stream.last_serial);
            hash.add(stream.tick);
            for (const std::int32_t p : stream.state.position) {
                hash.add(p);
            }
        }
    }
}

bool StreamTable::find_slots() {
    const auto below = [](const auto& list, std::size_t size) {
        return std::all_of(list.begin(), list.end(), [size](auto i) { return i < size; });
    };
    bool sound = below(free_streams_, streams_.size()) && below(abandoned_, streams_.size()) &&
                 below(free_slots_, slots_.size()) && used_ <= streams_.size();
    versions_.clear();
    for (const Stream& stream : streams_) {
        sound = sound && stream.lod < settings_.lods.size();
        versions_.push_back(stream.version);
    }
    sound = sound && below(free_published_, published_.size());
    for (const PublishedFields& published : published_) {
        const wire::FieldSchema* schema = wire::schema_of(settings_.fields, published.type);
        sound = sound && (published.words.empty() ||
                          (schema != nullptr && published.words.size() == schema->words() &&
                           published.changed.size() == schema->fields().size()));
    }
    slot_index_.clear();
    for (std::uint32_t slot = 0; sound && slot < slots_.size(); ++slot) {
        for (const StreamIndex stream : slots_[slot].stream) {
            sound = sound && (stream == kNoStream || stream < streams_.size());
        }
        if (slots_[slot].entity) {
            sound = sound && slots_[slot].fields <= published_.size() &&
                    slot_index_.emplace(slots_[slot].entity, slot).second;
        }
    }
    return sound;
}

}  // namespace zoned::replication

#include "client-sim/view/view.h"

#include "shared/wire/record/record_traffic.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace zoned::view {

View::View(std::shared_ptr<const WorldInfo> world,
           const ViewSettings& settings,
           ViewListener* listener)
    : courses_(std::make_shared<motion::DoorCourses>(world->doors.size())),
      platform_courses_(std::make_shared<motion::PlatformCourses>(world->platforms.size())),
      world_(world->has_moved_parts() ? std::make_shared<const WorldInfo>(
                                            world->with_courses(courses_, platform_courses_))
                                      : std::move(world)),
      settings_(settings),
      listener_(listener),
      store_(*world_, display_settings()),
      own_(*world_),
      playout_(world_->tick_s),
      bursts_(*world_),
      environment_(world_->environment, world_->tick_s) {
}

DisplaySettings View::display_settings() const {
    const bool past = settings_.kind == ViewKind::kInterpolate;
    return {settings_.convergence, settings_.displayed_state, settings_.keep_history, past};
}

void View::evaluate(Tick tick) {
    if (tick <= tick_) {
        return;
    }
    if (settings_.kind == ViewKind::kInterpolate) {
        // After a stall of this process there is nothing to be displayed of the time between.
        const bool in_turn = playout_.running() && tick - tick_ <= Playout::kMaxDelay;
        for (Tick t = in_turn ? tick_ + 1 : tick; t <= tick; ++t) {
            playout_.advance(t);
        }
    }
    tick_ = tick;
}

Tick View::displayed_tick() const {
    return settings_.kind == ViewKind::kInterpolate
               ? static_cast<Tick>(std::floor(playout_.position()))
               : tick_;
}

double View::displayed_fraction() const {
    return settings_.kind == ViewKind::kInterpolate
               ? playout_.position() - std::floor(playout_.position())
               : 0.0;
}

std::optional<Tick> View::shown_at(Tick tick) const {
    return settings_.kind == ViewKind::kInterpolate ? playout_.shown_at(tick)
                                                    : std::optional<Tick>(tick);
}

const Version* View::held(const Entity& entity, Tick tick, Tick known_by) const {
    return settings_.kind == ViewKind::kInterpolate ? EntityStore::implied(entity, tick, known_by)
                                                    : EntityStore::version_at(entity, tick);
}

WorldState View::displayed(const Entity& entity,
                           const Version& version,
                           Tick tick,
                           Tick known_by) const {
    if (settings_.kind == ViewKind::kInterpolate) {
        const auto shown = store_.interpolated(entity, static_cast<double>(tick), known_by);
        if (shown) {
            return *shown;
        }
    }
    return store_.displayed(version, static_cast<double>(tick));
}

std::optional<WorldState> View::on_screen(const Entity& entity, double fraction) const {
    if (settings_.kind == ViewKind::kInterpolate) {
        return store_.interpolated(entity, playout_.position() + fraction, tick_);
    }
    const Version* version = EntityStore::version_at(entity, tick_);
    if (version == nullptr && entity.present()) {
        // Without a history an update replaces the version from which it is blended: blending
        // begins there.
        version = &entity.versions.back();
    }
    return version != nullptr && version->present
               ? std::optional<WorldState>(
                     store_.displayed(*version, static_cast<double>(tick_) + fraction))
               : std::nullopt;
}

void View::set_back(Tick tick) {
    tick_ = tick;
    store_.set_back(tick);
    playout_ = Playout(world_->tick_s);
    own_ = OwnAvatar(*world_);
}

void View::diverged(const char* reason) {
    if (!resetting_ && wish_.empty()) {
        wish_ = reason;
    }
}

PacketResult View::apply(const link::OpenedPacket& packet, double now_s) {
    PacketResult taken;
    if (world_->zone(packet.head.zone) == nullptr) {
        ++stats_.malformed_records;
        diverged("a packet names an unknown zone");
        return taken;
    }
    if (packet.sequence > newest_sequence_) {
        if (zone_ && zone_ != packet.head.zone) {
            ++stats_.zone_changes;
        }
        zone_ = packet.head.zone;
        newest_sequence_ = packet.sequence;
    }
    if (packet.head.has_own) {
        taken.correction = own_.reconcile(packet.head.own, packet.head.zone);
        if (taken.correction.applied && packet.head.own.input_missing) {
            ++stats_.input_missing;
        }
    }
    oldest_update_ = packet.head.tick;
    taken.read = true;
    if (settings_.meter) {
        count_packet(packet);
    }
    if (packet.head.coded) {
        taken.read = apply_coded(packet, now_s);
    } else {
        apply_records(packet, now_s);
    }
    playout_.on_update(tick_ + 1 - oldest_update_);
    return taken;
}

void View::count_packet(const link::OpenedPacket& packet) {
    traffic_.add_packet(packet.head_bytes, packet.head_bytes - wire::down_head_bytes(packet.head));
}

/// Counts the record that was just applied.
void View::count_record(wire::RecordReader& gauge) {
    const std::size_t begin = gauge.byte_offset();
    wire::RecordBits bits;
    const auto head = gauge.measure_next(bits);
    if (!head) {
        traffic_.add_unread(gauge.byte_offset() - begin);
    } else if (head->kind == wire::RecordKind::kRemove) {
        traffic_.add_removal(8 * (gauge.byte_offset() - begin));
    } else {
        const Entity* entity = store_.find(head->entity);
        if (entity != nullptr && entity->typed) {
            traffic_.add_record(entity->type, reason_, bits);
            const wire::FieldSchema* schema = wire::schema_of(world_->fields, entity->type);
            if (head->declared && schema != nullptr) {
                traffic_.add_declared(*schema, gauge.measured_declared(*schema));
            }
        } else {
            traffic_.add_unread(gauge.byte_offset() - begin);
        }
    }
}

/// Counts records that are about to be applied.
void View::count_coded(const wire::record::RecordFrame& frame, std::size_t bytes) {
    wire::record::add_traffic(traffic_, frame, bytes, world_->fields, [&](const auto& record) {
        const Entity* before = store_.find(record.entity);
        if (before == nullptr || !before->present()) {
            return wire::TrafficReason::kJoin;
        }
        return before->versions.back().publication_tick >= record.tick
                   ? wire::TrafficReason::kRepeat
                   : wire::TrafficReason::kUpdate;
    });
}

/// All or nothing: an invalid message changes nothing.
void View::apply_environment(const wire::EventMessage& event) {
    const auto sensible = [](Tick tick) {
        return tick >= 0 && tick < (Tick{1} << 50);
    };
    wire::SharedEnvironmentMessage update;
    bool good = wire::decode_message(wire::bytes_of(event.payload), update);
    for (const auto& c : update.courses) {
        good = good && c.clock < environment_.clocks() && sensible(c.from) &&
               std::isfinite(c.value) && std::isfinite(c.rate_per_s);
    }
    for (const auto& c : update.cursors) {
        good = good && c.variable < environment_.variables() && sensible(c.since) &&
               c.phase < environment_.variable(c.variable).def().phases.size() &&
               std::isfinite(c.before);
    }
    for (const auto& c : update.doors) {
        good = good && c.door < world_->doors.size() && world_->doors[c.door].by_rules &&
               sensible(c.from);
    }
    for (const auto& c : update.platforms) {
        good = good && c.platform < world_->platforms.size() &&
               world_->platforms[c.platform].path.by_rules && sensible(c.from) && c.along >= 0 &&
               c.along <= world_->platforms[c.platform].path.length() && c.to >= 0 &&
               c.to <= world_->platforms[c.platform].path.length();
    }
    if (!good) {
        ++stats_.environment_malformed;
        return;
    }
    ++stats_.environment_updates;
    for (const auto& c : update.courses) {
        const clock::ClockCourse course{c.from, c.value, c.rate_per_s};
        const auto known = environment_.clock_at(c.clock, event.tick);
        if (course.from <= event.tick && known) {
            const auto mine = environment_.clock(c.clock).from(course.from);
            stats_.environment_corrected += mine.empty() || !(mine[0] == course) ? 1 : 0;
        }
        environment_.announce(c.clock, course);
    }
    for (const auto& c : update.cursors) {
        stats_.environment_corrected +=
            environment_.place(c.variable, {c.number, c.since, c.phase, c.before}) > 0.0 ? 1 : 0;
    }
    for (const auto& c : update.doors) {
        courses_->announce(c.door, {c.from, c.open}, event.tick);
    }
    for (const auto& c : update.platforms) {
        platform_courses_->announce(c.platform, {c.from, c.along, c.to}, event.tick);
    }
}

void View::apply(const wire::EventMessage& event) {
    if (event.kind == wire::kEventSharedEnvironment) {
        apply_environment(event);
        return;
    }
    if (event.kind != wire::kEventParticleBurst) {
        return;
    }
    switch (bursts_.apply(event, tick_)) {
        case Bursts::BurstOutcome::kTaken:
            ++stats_.bursts;
            break;
        case Bursts::BurstOutcome::kMalformed:
            ++stats_.bursts_malformed;
            break;
        case Bursts::BurstOutcome::kNoRoom:
            ++stats_.bursts_refused;
            break;
    }
}

bool View::apply_record(wire::RecordReader& reader,
                        const link::OpenedPacket& packet,
                        double now_s) {
    const auto head = reader.next_head();
    if (!head) {
        ++stats_.malformed_records;
        diverged("malformed record");
        return false;
    }
    ++stats_.records;
    if (head->kind == wire::RecordKind::kRemove) {
        ++stats_.removes;
        reason_ = wire::TrafficReason::kRemoval;
        store_.remove(head->entity, packet.sequence, packet.head.tick, tick_);
        return true;
    }
    EntityStore::Record record = record_of(packet, now_s);
    record.head = *head;
    record.publication_tick = wire::expand_tick(head->tick_low, packet.head.tick);
    core::Result<wire::QuantizedState> state = wire::QuantizedState{};
    if (head->kind == wire::RecordKind::kAbsolute) {
        ++stats_.absolutes;
        if (head->type >= world_->types.size()) {
            ++stats_.malformed_records;
            diverged("a record names an unknown type");
            return false;
        }
        state = reader.read_absolute(store_.upright(head->type));
    } else {
        const Entity* known = store_.find(head->entity);
        const ReceivedKeyframe* keyframe =
            store_.keyframe(head->entity, record.zone, head->lod, head->keyframe);
        if (known == nullptr || !known->typed || keyframe == nullptr) {
            ++stats_.unknown_keyframes;
            diverged("a delta refers to an unknown keyframe");
            // Without the type not even the length of the record is known.
            return known != nullptr && known->typed &&
                   reader.skip_delta(store_.upright(known->type)).ok();
        }
        state = reader.read_delta(keyframe->state, store_.upright(known->type));
    }
    if (!state) {
        ++stats_.malformed_records;
        diverged("malformed record");
        return false;
    }
    std::optional<wire::DeclaredUpdate> declared;
    if (head->declared) {
        declared.emplace();
        const bool whole = head->kind == wire::RecordKind::kAbsolute;
        const TypeIndex type = whole ? head->type : store_.find(head->entity)->type;
        const wire::DeclaredFault fault =
            reader.read_declared(wire::schema_of(world_->fields, type), *declared);
        if (fault != wire::DeclaredFault::kNone) {
            refuse_fields(fault);
            return false;
        }
    }
    const Entity* before = store_.find(head->entity);
    const bool joins = before == nullptr || !before->present();
    const ApplyOutcome applied = show(record, *state, declared ? &*declared : nullptr);
    if (applied == ApplyOutcome::kOld) {
        reason_ = wire::TrafficReason::kRepeat;
    } else if (joins) {
        reason_ = wire::TrafficReason::kJoin;
    } else {
        reason_ = head->kind == wire::RecordKind::kAbsolute ? wire::TrafficReason::kKeyframe
                                                            : wire::TrafficReason::kUpdate;
    }
    return true;
}

void View::refuse_fields(wire::DeclaredFault fault) {
    ++stats_.malformed_records;
    ++stats_.refused_fields[static_cast<std::size_t>(fault)];
    diverged(wire::kDeclaredFaultTexts[static_cast<std::size_t>(fault)]);
}

/// A received publication, from a shared record or from one for this client alone.
ApplyOutcome View::show(const EntityStore::Record& record,
                        const wire::QuantizedState& state,
                        const wire::DeclaredUpdate* declared) {
    const ApplyOutcome applied = store_.apply(record, state, declared);
    if (applied == ApplyOutcome::kShown) {
        ++stats_.shown;
        ++stats_.by_order[static_cast<std::size_t>(state.order) % stats_.by_order.size()];
        const Version& shown = store_.find(record.head.entity)->versions.back();
        oldest_update_ = std::min(oldest_update_, shown.event_tick);
        if (listener_ != nullptr) {
            listener_->on_shown(record.head.entity,
                                record.publication_tick,
                                std::max(tick_ + 1, record.publication_tick + delay()));
        }
    } else if (applied == ApplyOutcome::kLate) {
        oldest_update_ = std::min(oldest_update_, record.publication_tick);
    }
    return applied;
}

/// Shared records, one after another; the meter reads along.
void View::apply_records(const link::OpenedPacket& packet, double now_s) {
    wire::RecordReader reader(packet.records, world_->quantization);
    wire::RecordReader gauge(packet.records, world_->quantization);
    bool applied = true;
    while (!reader.done() && applied) {
        reason_ = wire::TrafficReason::kUnread;
        applied = apply_record(reader, packet, now_s);
        if (settings_.meter) {
            count_record(gauge);
        }
    }
    if (settings_.meter) {
        traffic_.add_unread(packet.records.size() - gauge.byte_offset());
    }
}

/// Records that are coded for this client alone; false: they could not be decoded.
bool View::apply_coded(const link::OpenedPacket& packet, double now_s) {
    if (!coded_) {
        coded_.emplace(wire::record::RecordFormat(
            world_->quantization, static_cast<float>(world_->tick_s), world_->fields));
    }
    const auto frame = coded_->decode(static_cast<wire::entropy::PacketNumber>(packet.sequence),
                                      packet.head.tick,
                                      packet.head.zone,
                                      packet.records,
                                      settings_.meter);
    if (!frame) {
        for (std::size_t fault = 1; fault < wire::kDeclaredFaults; ++fault) {
            stats_.refused_fields[fault] += frame.error() == wire::kDeclaredFaultTexts[fault];
        }
        not_decoded(packet);
        return false;
    }
    newest_decoded_ = std::max(newest_decoded_, packet.sequence);
    undecoded_ = 0;
    if (settings_.meter) {
        count_coded(**frame, packet.records.size());
    }
    show_coded(**frame, packet, now_s);
    return true;
}

/// The packet counts as lost: it is not acknowledged, so the server never builds on it and sends
/// its updates again. But where packet after packet can't be decoded, the knowledge of the two
/// sides differs.
void View::not_decoded(const link::OpenedPacket& packet) {
    if (settings_.meter) {
        traffic_.add_unread(packet.records.size());
    }
    if (packet.sequence < newest_decoded_) {
        ++stats_.overtaken_packets;
        return;
    }
    ++stats_.undecoded_packets;
    if (++undecoded_ >= kUndecodedForReset) {
        undecoded_ = 0;
        diverged("packets could not be decoded");
    }
}

void View::show_coded(const wire::record::RecordFrame& frame,
                      const link::OpenedPacket& packet,
                      double now_s) {
    for (const wire::record::CodedRecord& coded : frame.records) {
        ++stats_.records;
        if (coded.remove) {
            ++stats_.removes;
            store_.remove(coded.entity, packet.sequence, packet.head.tick, tick_);
            continue;
        }
        if (coded.type >= world_->types.size() || coded.upright != store_.upright(coded.type)) {
            ++stats_.malformed_records;
            diverged("a record contradicts its type");
            return;
        }
        EntityStore::Record record = record_of(packet, now_s);
        record.head.kind = wire::RecordKind::kAbsolute;
        record.head.entity = coded.entity;
        record.head.type = coded.type;
        record.head.upright = coded.upright;
        record.head.lod = coded.lod;
        record.publication_tick = coded.tick;
        record.coded = true;
        show(record,
             coded.state,
             coded.declared != 0 ? &frame.declared[coded.declared - 1] : nullptr);
    }
}

EntityStore::Record View::record_of(const link::OpenedPacket& packet, double now_s) const {
    EntityStore::Record record;
    record.sequence = packet.sequence;
    record.packet_tick = packet.head.tick;
    record.zone = packet.head.zone;
    record.view_tick = tick_;
    record.now_s = now_s;
    return record;
}

std::optional<wire::FieldValue> View::field(EntityId id, std::string_view name) const {
    const Entity* const entity = store_.find(id);
    const wire::FieldSchema* const schema =
        entity != nullptr && entity->present() && entity->typed && !entity->fields.empty()
            ? wire::schema_of(world_->fields, entity->type)
            : nullptr;
    const wire::DeclaredField* const field =
        schema != nullptr ? schema->find(wire::field_id(name)) : nullptr;
    if (field == nullptr || field->name != name ||
        entity->fields.back().words.size() != schema->words()) {
        return std::nullopt;
    }
    return wire::value_of(*field, wire::words_of(*field, std::span(entity->fields.back().words)));
}

void View::maintain(double now_s) {
    environment_.advance(tick_);
    store_.prune(tick_);
    const double silent_s = static_cast<double>(kSilentTicks) * world_->tick_s;
    for (const auto& [id, entity] : store_.entities()) {
        if (entity.present() && !entity.versions.back().quantized.at_rest &&
            now_s - entity.heard_s > silent_s) {
            ++stats_.silent_entities;
            diverged("a moving entity fell silent");
            break;
        }
    }
}

std::string View::take_reset_wish(double now_s) {
    if (resetting_) {
        if (now_s < reset_until_s_) {
            return {};
        }
        resetting_ = false;
        stats_.dropped_by_reset += store_.end_reset(tick_);
    }
    if (wish_.empty()) {
        return {};
    }
    ++stats_.resets;
    resetting_ = true;
    reset_until_s_ = now_s + kResetS;
    store_.begin_reset();
    return std::exchange(wish_, {});
}

}  // namespace zoned::view

#include "shared/wire/record/record_knowledge.h"

#include <algorithm>
#include <utility>

namespace zoned::wire::record {

namespace {

/// Number of residuals in the mean.
constexpr float kMeanOf = 32.0F;
/// Before anything was learned, steps.
constexpr float kExpectedAtFirst = 4.0F;
constexpr float kExpectedFromNothing = 256.0F;

bool is_known(const CodedRecord& record) {
    return record.lod < kLods && static_cast<std::int32_t>(record.state.order) < kMotions;
}

/// The record of an entity, or the end.
std::vector<CodedRecord>::const_iterator record_in(const RecordFrame& frame, EntityId entity) {
    const auto it = std::lower_bound(
        frame.records.begin(), frame.records.end(), entity, [](const CodedRecord& r, EntityId id) {
            return r.entity < id;
        });
    return it != frame.records.end() && it->entity == entity ? it : frame.records.end();
}

}  // namespace

// ---------------------------------------------------------------- bases

bool RecordBaselines::is_sound() const {
    const auto there = [this](Slot slot) {
        return slot < versions_.size();
    };
    bool sound = std::ranges::all_of(free_, there) && (superseding_.empty() || !ticks_.empty());
    for (const BaselineVersion& version : versions_) {
        sound = sound && is_known(version.record);
    }
    for (std::size_t i = 0; sound && i < entries_.size(); ++i) {
        sound =
            there(entries_[i].newest) && (i == 0 || entries_[i - 1].entity < entries_[i].entity);
        for (Slot slot = entries_[i].newest; sound && slot != kNone;) {
            const Slot older = versions_[slot].older;
            sound = older == kNone ||
                    (there(older) && versions_[older].number < versions_[slot].number);
            slot = older;
        }
    }
    return sound;
}

std::vector<RecordBaselines::BaselineEntry>::const_iterator RecordBaselines::lower_bound(
    EntityId entity) const {
    return std::lower_bound(
        entries_.begin(), entries_.end(), entity, [](const BaselineEntry& entry, EntityId id) {
            return entry.entity < id;
        });
}

/// The newest version of an entity that was learned up to `newest`.
RecordBaselines::Slot RecordBaselines::version_at(Slot newest_of_entity,
                                                  entropy::PacketNumber newest) const {
    Slot slot = newest_of_entity;
    while (slot != kNone && versions_[slot].number > newest) {
        slot = versions_[slot].older;
    }
    return slot;
}

const CodedRecord* RecordBaselines::find(EntityId entity,
                                         ZoneId zone,
                                         entropy::PacketNumber newest) const {
    const auto it = lower_bound(entity);
    if (it == entries_.end() || it->entity != entity) {
        return nullptr;
    }
    const Slot slot = version_at(it->newest, newest);
    if (slot == kNone || versions_[slot].record.remove || versions_[slot].zone != zone) {
        return nullptr;
    }
    return &versions_[slot].record;
}

RecordBaselines::Cursor::Cursor(const RecordBaselines& bases, EntityId entity) : bases_(bases) {
    const auto it = bases.lower_bound(entity);
    slot_ = it == bases.entries_.end() || it->entity != entity ? kNone : it->newest;
}

void RecordBaselines::moving(ZoneId zone,
                             entropy::PacketNumber newest,
                             Tick since,
                             std::vector<EntityId>& out) const {
    if (moved_tick_ < since) {
        return;
    }
    for (const BaselineEntry& entry : entries_) {
        const Slot slot = version_at(entry.newest, newest);
        if (slot == kNone || versions_[slot].zone != zone) {
            continue;
        }
        const CodedRecord& record = versions_[slot].record;
        if (moves(record) && record.tick >= since) {
            out.push_back(entry.entity);
        }
    }
}

RecordBaselines::Slot RecordBaselines::keep(const RecordFrame& frame,
                                            const CodedRecord& record,
                                            Slot older) {
    if (free_.empty()) {
        free_.push_back(static_cast<Slot>(versions_.size()));
        versions_.emplace_back();
    }
    const Slot slot = free_.back();
    free_.pop_back();
    versions_[slot] = {frame.number, frame.zone, older, record};
    return slot;
}

void RecordBaselines::learning(const RecordFrame& frame) {
    if (ticks_.empty() || ticks_.back().tick != frame.tick) {
        ticks_.emplace_back();
    }
    ticks_.back() = {frame.number, frame.tick};
    for (const CodedRecord& record : frame.records) {
        if (moves(record)) {
            moved_tick_ = std::max(moved_tick_, record.tick);
        }
        auto it = entries_.begin() + (lower_bound(record.entity) - entries_.cbegin());
        if (it == entries_.end() || it->entity != record.entity) {
            it = entries_.insert(it, {record.entity, kNone});
        } else if (versions_[it->newest].number >= frame.number) {
            continue;  // learned by another state of knowledge before
        }
        if (it->newest != kNone || record.remove) {
            superseding_.push_back({frame.number, record.entity});
        }
        it->newest = keep(frame, record, it->newest);
    }
}

/// Frees a version and all that are older.
void RecordBaselines::drop(Slot& first) {
    for (Slot slot = std::exchange(first, kNone); slot != kNone; slot = versions_[slot].older) {
        free_.push_back(slot);
    }
}

void RecordBaselines::forget(EntityId entity, entropy::PacketNumber oldest) {
    const auto it = entries_.begin() + (lower_bound(entity) - entries_.cbegin());
    if (it == entries_.end() || it->entity != entity) {
        return;
    }
    const Slot still_needed = version_at(it->newest, oldest);
    if (still_needed == kNone) {
        return;
    }
    // Where it was before is looked at where it moves.
    Slot oldest_needed = still_needed;
    while (versions_[oldest_needed].number > ticks_.front().number &&
           moves(versions_[oldest_needed].record) && versions_[oldest_needed].older != kNone) {
        oldest_needed = versions_[oldest_needed].older;
    }
    drop(versions_[oldest_needed].older);
    if (still_needed == it->newest && versions_[still_needed].record.remove) {
        drop(it->newest);
        entries_.erase(it);
    }
}

/// Packets before those at which a course is looked at from packet `oldest` on.
void RecordBaselines::forget_ticks(entropy::PacketNumber oldest) {
    const auto behind = std::upper_bound(
        ticks_.begin(), ticks_.end(), oldest, [](entropy::PacketNumber n, const CoursePacket& p) {
            return n < p.number;
        });
    const auto looked_at = static_cast<std::ptrdiff_t>(CourseKnowledge::kPackets);
    ticks_.erase(ticks_.begin(), behind - std::min(behind - ticks_.begin(), looked_at));
}

void RecordBaselines::forget_before(entropy::PacketNumber oldest) {
    forget_ticks(oldest);
    const auto kept =
        std::ranges::find_if(superseding_, [&](const Superseding& s) { return s.number > oldest; });
    for (auto s = superseding_.begin(); s != kept; ++s) {
        forget(s->entity, oldest);
    }
    superseding_.erase(superseding_.begin(), kept);
}

const CodedRecord* KnownBaselines::find(EntityId entity,
                                        ZoneId zone,
                                        entropy::PacketNumber newest) const {
    for (auto frame = frames.rbegin(); frame != frames.rend(); ++frame) {
        const auto it = record_in(**frame, entity);
        if (it != (*frame)->records.end()) {
            return it->remove || (*frame)->zone != zone ? nullptr : &*it;
        }
    }
    return common.find(entity, zone, newest);
}

void KnownBaselines::find_course(EntityId entity,
                                 ZoneId zone,
                                 std::span<const entropy::PacketNumber> upto,
                                 std::span<const CodedRecord*> out) const {
    auto frame = frames.rbegin();
    RecordBaselines::Cursor common_one(common, entity);
    const CodedRecord* found = nullptr;
    entropy::PacketNumber number = 0;
    // To the newest publication up to packet `newest` that is older than the one found.
    const auto go_back = [&](entropy::PacketNumber newest) {
        for (; frame != frames.rend(); ++frame) {
            const auto it = record_in(**frame, entity);
            if ((*frame)->number <= newest && it != (*frame)->records.end()) {
                const bool is_known = !it->remove && (*frame)->zone == zone;
                found = is_known ? &*it : found;
                number = (*frame)->number;
                ++frame;
                return is_known;
            }
        }
        for (; !common_one.at_end() && common_one.number() > newest;) {
            common_one.older();
        }
        if (common_one.at_end() || common_one.record().remove || common_one.zone() != zone) {
            return false;
        }
        found = &common_one.record();
        number = common_one.number();
        common_one.older();
        return true;
    };
    bool more = go_back(upto[0]);
    for (std::size_t i = 0; i < upto.size(); ++i) {
        while (more && number > upto[i] && moves(*found) && !found->plain) {
            more = go_back(number - 1);
        }
        out[i] = found;
    }
}

void KnownBaselines::moving(ZoneId zone,
                            entropy::PacketNumber newest,
                            Tick since,
                            std::vector<EntityId>& out) const {
    out.clear();
    common.moving(zone, newest, since, out);
    for (const std::shared_ptr<const RecordFrame>& frame : frames) {
        for (const CodedRecord& record : frame->records) {
            const auto at = std::lower_bound(out.begin(), out.end(), record.entity);
            const bool there = at != out.end() && *at == record.entity;
            const bool is = frame->zone == zone && moves(record) && record.tick >= since;
            if (is && !there) {
                out.insert(at, record.entity);
            } else if (there && !is) {
                out.erase(at);
            }
        }
    }
}

// ---------------------------------------------------------------- models

bool is_sound(const RecordFrame& frame) {
    bool sound = std::ranges::all_of(frame.records, is_known);
    for (const RecordModelUpdate& lesson : frame.model_updates) {
        const std::size_t symbols_of_it = lesson.model >= RecordModels::kFirstBit ? 2 : 16;
        sound = sound && lesson.model < RecordModels::kFirstBit + RecordModels::kBits &&
                lesson.reach < kReaches && lesson.symbol < symbols_of_it;
    }
    return sound;
}

RecordModels::RecordModels() {
    for (auto& by_reach : expected) {
        by_reach.fill(kExpectedAtFirst);
        by_reach[kFromNothing] = kExpectedFromNothing;
    }
    // The same start gives the same result.
    bits.fill(entropy::BitModel(7u << 13));
    bits[kPlain] = bits[kPlain + 1] = entropy::BitModel(1u << 12);
}

void RecordModels::learning(const std::vector<RecordModelUpdate>& model_updates) {
    for (const RecordModelUpdate& lesson : model_updates) {
        if (lesson.model >= kFirstBit) {
            bits[lesson.model - kFirstBit].learning(lesson.symbol != 0);
        } else if (lesson.model >= kFirstSymbol) {
            symbols[lesson.model - kFirstSymbol].learning(lesson.symbol);
        } else {
            const std::size_t what = lesson.model / entropy::kScaleClasses;
            residuals[what].of(lesson.model % entropy::kScaleClasses).learning(lesson.symbol);
            float& mean = expected[what][lesson.reach];
            mean += (entropy::typical_magnitude(lesson.symbol) - mean) / kMeanOf;
        }
    }
}

// ---------------------------------------------------------------- knowledge

RecordKnowledge::RecordKnowledge(const RecordFormat& /*format*/) {
    velocity_.fill(entropy::LeastSquares<1>({1.0}));
}

void RecordKnowledge::learning(const std::shared_ptr<const RecordFrame>& frame) {
    models_.learning(frame->model_updates);
    for (std::size_t i = 0; i < velocity_.size(); ++i) {
        if (frame->velocity[i].any) {
            velocity_[i].learning(frame->velocity[i]);
            velocity_[i].solve();
        }
    }
    course_.learning(frame->number, frame->tick, frame->course);
    learned_.add(frame->number);
}

}  // namespace zoned::wire::record

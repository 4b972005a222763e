#include "server/replication/packer.h"

#include "shared/wire/record/record_traffic.h"

#include <algorithm>

namespace zoned::replication {

namespace {

// A removal is small and ends a wrong picture; what the client has never seen comes before what it
// merely predicts a little wrong; further copies come last.
constexpr float kRemovalWeight = 4.0F;
constexpr float kUnknownWeight = 2.0F;
constexpr float kRepeatWeight = 0.25F;

// Where the budget is short, packets wait until headers are no more than a fifth of them.
constexpr double kWorthwhileBytes = 5.0 * kPacketOverheadBytes;
// What a head and a record take, about; only for the decision to wait.
constexpr double kTypicalHeadBytes = 10.0;
constexpr double kTypicalRecordBytes = 24.0;

// Under pressure: never sent before anything else, as if that were so many bounds off; a bound's
// worth of urgency for every second of waiting; an error that is not known is this large.
constexpr float kUnseenScore = 16.0F;
constexpr float kWaitingScore = 1.0F / 30.0F;
constexpr float kWorstExcess = 1e4F;
// A few bytes that end a wrong picture, of which no bound says how wrong it is, come before all.
constexpr float kRemovalScore = 1e9F;
// Bounds are told with so much to spare, and narrowed half the way in so many ticks.
constexpr float kMargin = 1.2F;
constexpr Tick kNarrowEvery = 8;
constexpr Tick kSwitchTicks = 3;

/// What the client is taken to predict from: what was sent last unless that was lost.
std::uint32_t held_version(const Subscription& s) {
    return s.delivery.in_flight > 0 ? s.sent_version : s.delivered_version;
}

/// Ticks' worth of time for coding that may gather.
constexpr double kCodingBurst = 4.0;

/// Head and end of coded records, about.
constexpr std::size_t kCodedHeadBytes = 6;

wire::record::CodedRecord coded_record(const Stream& stream, Tick now) {
    wire::record::CodedRecord record;
    record.entity = stream.entity;
    record.lod = stream.lod;
    record.type = stream.type;
    record.upright = stream.upright;
    // What has rested for long may have done so for longer still.
    record.tick = std::max(stream.tick, now - wire::record::kOldestTicks);
    record.state = stream.state;
    return record;
}

wire::record::CodedRecord coded_removal(EntityId entity) {
    wire::record::CodedRecord record;
    record.entity = entity;
    record.remove = true;
    return record;
}

bool same_state(const motion::CharacterState& a, const motion::CharacterState& b) {
    return a.position == b.position && a.velocity == b.velocity && a.yaw == b.yaw &&
           a.grounded == b.grounded;
}

}  // namespace

void Packer::allow_coding(const mailbox::CodecPrice& price) {
    price_ = price;
    const double tick_ns = 1e3 * static_cast<double>(settings_.codec_budget_us);
    coding_ns_ = std::min(coding_ns_ + tick_ns, kCodingBurst * tick_ns);
}

void Packer::pack(Tick now,
                  ZoneId zone,
                  const OwnNow& own,
                  ClientState& client,
                  StreamTable& streams,
                  Report& report,
                  std::vector<mailbox::StatePacket>& out) {
    client.refill(settings_);
    codes_ = client.coder != nullptr &&
             (settings_.codec != Codec::kAuto || coding_ns_ >= client.demand.cost_ns(price_));
    gather(now, client, streams);
    OwnTrack& track = client.own;
    const bool silence = client.packet_tick < 0 ||
                         now - client.packet_tick >= static_cast<Tick>(settings_.silence_ticks);
    // Own state and signs of life may go into debt; the records then wait until it is paid.
    const bool due = client.away() ? silence || client.sign_due(now)
                                   : silence || (own_due(now, own, track) && client.tokens >= 0.0);
    track.input_missing = own.present && own.state.input_missing;
    if (candidates_.empty() && !due) {
        return;
    }
    if (client.away()) {
        widen(now, client, streams);  // it is told that it is told of nothing
    }
    const double need = static_cast<double>(kPacketOverheadBytes) + kTypicalHeadBytes +
                        kTypicalRecordBytes * static_cast<double>(candidates_.size());
    tight_ = need > client.tokens;
    if (tight_) {
        order_by_error(now, client, streams);
        order_unseen_by_distance(own, client, streams);
    }
    const bool wait = client.tokens < std::min(need, kWorthwhileBytes);
    if (wait && !due) {
        ++report.over_budget;
        widen(now, client, streams);
        return;
    }
    const bool own_is_known = track.sent_tick >= 0 && same_state(track.sent, own.state.state) &&
                              track.acked_stamp == track.stamp && !own.state.input_missing;
    // A packet that goes out anyway takes the own state along, but not more often than needed.
    const bool own_is_recent =
        track.sent_tick >= 0 &&
        2 * (now - track.sent_tick) < static_cast<Tick>(settings_.own_state_every_ticks);
    head_.has_widened = tight_ || client.widened != wire::Widened{};
    begin(
        now, zone, own.present && (due || !(own_is_known || own_is_recent)) ? &own.state : nullptr);
    const std::size_t packets_before = out.size();
    write_records(now, zone, client, streams, report, out);
    if (!entries_.empty() || (due && out.size() == packets_before)) {
        finish(now, client, report, out);
    }
    report.over_budget += candidates_.empty() ? 0 : 1;
    widen(now, client, streams);
    tell(client, std::span(out).subspan(packets_before), report);
}

/// Where not everything fits, those go first whose error is largest beside the bound that holds for
/// them, by the weight of their type; what waits for another reason (rest, looks) gains by waiting.
void Packer::order_by_error(Tick now, const ClientState& client, const StreamTable& streams) {
    for (Candidate& c : candidates_) {
        if (c.removal) {
            c.score += kRemovalScore;
            continue;
        }
        const Subscription& s = client.subscriptions[c.index];
        const Stream& stream = streams[s.stream];
        const auto waited = static_cast<float>(now - s.delivery.owed_tick);
        if (s.sent_version == 0) {
            // Nearest first; who was never shown comes before who is shown a little wrong.
            c.score = kUnseenScore * stream.priority * (1.0F + waited) /
                      static_cast<float>(1 + s.lod * s.lod);
            continue;
        }
        const float excess = std::min(streams.excess(s.stream, held_version(s), now), kWorstExcess);
        const auto wider = static_cast<float>(wire::widening(
            std::min(client.widened.step, wire::kMostWidening), s.lod, settings_.lods.size()));
        c.score = stream.priority * (excess / wider + kWaitingScore * waited);
    }
    sort_candidates();
}

/// Who was never shown comes nearest first within a level of detail, by exact distance (less the
/// more its type matters); which places in the order the unseen have is not changed.
void Packer::order_unseen_by_distance(const OwnNow& own,
                                      const ClientState& client,
                                      const StreamTable& streams) {
    if (!own.present) {
        return;
    }
    for (std::uint8_t lod = 0; lod < settings_.lods.size(); ++lod) {
        unseen_.clear();
        places_.clear();
        for (std::uint32_t place = 0; place < candidates_.size(); ++place) {
            const Candidate& c = candidates_[place];
            if (c.removal || client.subscriptions[c.index].sent_version != 0 ||
                client.subscriptions[c.index].lod != lod) {
                continue;
            }
            const Stream& stream = streams[client.subscriptions[c.index].stream];
            const float distance_m = (stream.truth.position - own.state.state.position).norm();
            unseen_.emplace_back(distance_m / stream.priority, c);
            places_.push_back(place);
        }
        std::sort(unseen_.begin(), unseen_.end(), [](const auto& a, const auto& b) {
            return a.first != b.first ? a.first < b.first : a.second.index < b.second.index;
        });
        for (std::size_t i = 0; i < places_.size(); ++i) {
            candidates_[places_[i]] = unseen_[i].second;
        }
    }
}

/// What could not be sent decides how wide the bounds are now: never silently late.
void Packer::widen(Tick now, ClientState& client, const StreamTable& streams) {
    if (client.away()) {
        client.widened.step = wire::kNoBound;
        client.widened.incomplete = true;
        client.widened_tick = now;
        postpone_all(now, client);
        return;
    }
    wire::Widened needed;
    if (tight_) {
        for (const Candidate& c : candidates_) {
            if (c.reason == Reason::kRepeat) {
                continue;
            }
            if (c.removal) {
                client.removals[c.index].postponed_tick = now;
                needed.incomplete = true;
                continue;
            }
            Subscription& s = client.subscriptions[c.index];
            if (s.sent_version == 0 && !s.known) {
                needed.incomplete = true;
                s.postponed_tick = now;
                continue;
            }
            // After a change of level or zone the client predicts from a stream of the past; for so
            // long that is part of how old news may be.
            if (s.sent_version == 0 && now - s.delivery.owed_tick <= kSwitchTicks) {
                continue;
            }
            const float excess = streams.excess(s.stream, held_version(s), now);
            needed.step =
                std::max(needed.step,
                         wire::widening_for(
                             static_cast<double>(kMargin * excess), s.lod, settings_.lods.size()));
        }
    }
    wire::Widened& told = client.widened;
    told.incomplete = needed.incomplete;
    if (needed.step >= told.step) {
        client.widened_tick = needed.step > 0 ? now : client.widened_tick;
        told.step = needed.step;
    } else if (now - client.widened_tick >= kNarrowEvery) {
        client.widened_tick = now;
        told.step = static_cast<std::uint8_t>((needed.step + told.step) / 2);
        if (told.step > wire::kMostWidening) {
            told.step = std::max(needed.step, wire::kMostWidening);
        }
    }
}

/// One that is away is told of nothing.
void Packer::postpone_all(Tick now, ClientState& client) {
    for (Removal& r : client.removals) {
        r.postponed_tick = now;
    }
    for (Subscription& s : client.subscriptions) {
        if (s.sent_version == 0 && !s.known) {
            s.postponed_tick = now;
        }
    }
}

void Packer::tell(ClientState& client,
                  std::span<mailbox::StatePacket> packets,
                  Report& report) const {
    if (client.widened == wire::Widened{} || settings_.silent_bound) {
        return;
    }
    ++report.widened;
    for (mailbox::StatePacket& packet : packets) {
        wire::rewrite_widened(client.widened, packet.body);
    }
}

/// Leaves in candidates_ what did not fit into the budget.
void Packer::write_records(Tick now,
                           ZoneId zone,
                           ClientState& client,
                           StreamTable& streams,
                           Report& report,
                           std::vector<mailbox::StatePacket>& out) {
    std::size_t done = 0;
    while (done < candidates_.size()) {
        const double allowed = client.tokens - static_cast<double>(kPacketOverheadBytes);
        if (add(now, candidates_[done], allowed, client, streams, report)) {
            ++done;
        } else if (entries_.empty() || allowed < static_cast<double>(wire::kMaxDownBodyBytes)) {
            break;  // the budget ended
        } else {
            finish(now, client, report, out);
            begin(now, zone, nullptr);
        }
    }
    candidates_.erase(candidates_.begin(), candidates_.begin() + static_cast<std::ptrdiff_t>(done));
}

// ---------------------------------------------------------------- what to send

/// Fills candidates_ with everything that should be sent now, most urgent first; ties go by entity.
void Packer::gather(Tick now, ClientState& client, const StreamTable& streams) {
    candidates_.clear();
    if (!client.is_viewer || client.away()) {
        return;
    }
    copies_wanted_ = client.copies_wanted(settings_.redundancy_target);
    Candidate candidate;
    candidate.removal = true;
    for (std::uint32_t i = 0; i < client.removals.size(); ++i) {
        Removal& r = client.removals[i];
        if (consider(now, r.delivery.copies == 0, r.delivery, kRemovalWeight, candidate)) {
            candidate.index = i;
            candidates_.push_back(candidate);
        }
    }
    candidate.removal = false;
    for (std::uint32_t i = 0; i < client.subscriptions.size(); ++i) {
        Subscription& s = client.subscriptions[i];
        const Stream& stream = streams[s.stream];
        if (stream.version == s.delivered_version) {
            continue;
        }
        const float weight =
            stream.priority * (s.known ? 1.0F : kUnknownWeight) / static_cast<float>(1 + s.lod);
        if (consider(now, s.sent_version != stream.version, s.delivery, weight, candidate)) {
            candidate.index = i;
            candidates_.push_back(candidate);
        }
    }
    sort_candidates();
}

/// Most urgent first; ties go by entity.
void Packer::sort_candidates() {
    std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
        if (a.score != b.score) {
            return a.score > b.score;
        }
        return a.removal != b.removal ? a.removal : a.index < b.index;
    });
}

/// True when something is to be sent now; says why and how urgent it is: weight times the ticks for
/// which it has been owed.
bool Packer::consider(Tick now, bool news, Delivery& delivery, float weight, Candidate& candidate) {
    if (news) {
        candidate.reason = Reason::kNews;
    } else if (settings_.never_again) {
        return false;
    } else if (delivery.in_flight == 0) {
        candidate.reason = Reason::kLost;
    } else if (delivery.in_flight < copies_wanted_ && delivery.sent_tick < now) {
        // A copy that was lost is made up for at once: while the fate of the others is not known,
        // the chance that all are lost stays below the target.
        candidate.reason = Reason::kRepeat;
        weight *= kRepeatWeight;
    } else {
        return false;
    }
    if (delivery.owed_tick == 0) {
        delivery.owed_tick = now;
    }
    candidate.score = weight * static_cast<float>(1 + now - delivery.owed_tick);
    return true;
}

bool Packer::own_due(Tick now, const OwnNow& own, const OwnTrack& track) const {
    if (!own.present) {
        return false;
    }
    if (track.sent_tick < 0 || own.discontinuity_tick > track.sent_tick ||
        (own.state.input_missing && !track.input_missing)) {
        return true;
    }
    const bool settled =
        same_state(track.sent, own.state.state) && track.acked_stamp == track.stamp;
    return (!settled || own.state.input_missing) &&
           now - track.sent_tick >= static_cast<Tick>(settings_.own_state_every_ticks);
}

// ---------------------------------------------------------------- writing

void Packer::begin(Tick now, ZoneId zone, const wire::OwnState* own) {
    const bool has_widened = head_.has_widened;
    head_ = wire::DownHead{};
    head_.has_widened = has_widened;
    head_.tick = now;
    head_.zone = zone;
    if (own != nullptr) {
        head_.has_own = true;
        head_.own = *own;
    }
    body_.clear();
    entries_.clear();
    coded_.clear();
    wire::write_down_head(head_, body_);
    head_bytes_ = body_.size();
}

bool Packer::fits(std::size_t size, double allowed_bytes) {
    return size <= wire::kMaxDownBodyBytes && static_cast<double>(size) <= allowed_bytes;
}

/// Appends one record; false when it fits neither into the packet nor into the allowed bytes.
bool Packer::add(Tick now,
                 const Candidate& candidate,
                 double allowed_bytes,
                 ClientState& client,
                 StreamTable& streams,
                 Report& report) {
    SentEntry entry;
    Encoded encoded;
    Subscription* s = nullptr;
    if (candidate.removal) {
        const Removal& r = client.removals[candidate.index];
        entry = {r.entity, r.stamp, 0, 0};
    } else {
        s = &client.subscriptions[candidate.index];
        entry = {s->entity, s->stamp, streams[s->stream].version, 0};
    }
    if (codes_) {
        // How many bytes it takes is known when the packet is coded.
        const auto guess =
            static_cast<std::size_t>(client.coded_bytes * static_cast<float>(coded_.size() + 1));
        if (coded_.size() == wire::record::kMostRecords ||
            !fits(body_.size() + kCodedHeadBytes + guess, allowed_bytes)) {
            return false;
        }
        coded_.push_back(s != nullptr ? coded_record(streams[s->stream], now)
                                      : coded_removal(entry.entity));
    } else {
        if (s != nullptr) {
            encoded = streams.encode(s->stream, s->held_keyframe);
            entry.keyframe = encoded.keyframe;
        } else {
            remove_record_.clear();
            wire::encode_remove(entry.entity, remove_record_);
            encoded.bytes = &remove_record_;
        }
        if (!fits(body_.size() + encoded.bytes->size(), allowed_bytes)) {
            return false;
        }
        body_.insert(body_.end(), encoded.bytes->begin(), encoded.bytes->end());
    }
    entries_.push_back(entry);
    if (meter_ && s == nullptr && !codes_) {
        meter_->table().add_removal(8 * encoded.bytes->size());
    } else if (meter_ && s != nullptr) {
        const wire::TrafficReason reason = reason_of(candidate, *s, encoded, streams);
        if (codes_) {
            reasons_.emplace_back(entry.entity, reason);
        } else {
            meter_->add_record(s->stream, streams[s->stream], encoded, reason);
        }
    }
    Delivery& delivery = s != nullptr ? s->delivery : client.removals[candidate.index].delivery;
    if (s != nullptr) {
        if (encoded.keyframe != 0 && streams.sent_absolute(s->stream)) {
            ++report.keyframes;
        }
        if (s->sent_version != entry.version || candidate.reason == Reason::kLost) {
            // What was lost in all its copies (an outage) is repeated as often as the first time.
            s->sent_version = entry.version;
            delivery.copies = 0;
            delivery.in_flight = 0;
        }
        s->known = true;
    }
    delivery.copies = static_cast<std::uint8_t>(std::min(delivery.copies + 1, 255));
    delivery.in_flight = static_cast<std::uint8_t>(std::min(delivery.in_flight + 1, 255));
    delivery.sent_tick = now;
    delivery.owed_tick = 0;
    ++report.records_sent;
    report.records_resent += candidate.reason == Reason::kNews ? 0 : 1;
    return true;
}

/// Each record has one reason: the first of these that holds.
wire::TrafficReason Packer::reason_of(const Candidate& candidate,
                                      const Subscription& s,
                                      const Encoded& encoded,
                                      const StreamTable& streams) {
    using wire::TrafficReason;
    if (candidate.reason == Reason::kLost) {
        return TrafficReason::kResent;
    }
    if (candidate.reason == Reason::kRepeat) {
        return TrafficReason::kRepeat;
    }
    if (s.sent_version == 0) {
        return TrafficReason::kJoin;
    }
    if (streams[s.stream].heartbeat) {
        return TrafficReason::kHeartbeat;
    }
    return encoded.keyframe != 0 ? TrafficReason::kKeyframe : TrafficReason::kNews;
}

/// What was coded is known when all of a packet is.
void Packer::count_coded(const wire::record::RecordFrame& frame) {
    wire::record::add_traffic(
        meter_->table(), frame, body_.size() - head_bytes_, [&](const auto& record) {
            return std::find_if(reasons_.begin(),
                                reasons_.end(),
                                [&](const auto& told) { return told.first == record.entity; })
                ->second;
        });
}

void Packer::finish(Tick now,
                    ClientState& client,
                    Report& report,
                    std::vector<mailbox::StatePacket>& out) {
    if (coded_.empty()) {
        send(now, client, report, out);
    } else {
        finish_coded(now, client, report, out);
    }
}

/// Codes what was gathered; where it takes more bytes than was guessed, in several packets.
void Packer::finish_coded(Tick now,
                          ClientState& client,
                          Report& report,
                          std::vector<mailbox::StatePacket>& out) {
    // What is written by the way empties coded_ and entries_.
    coding_.swap(coded_);
    coding_entries_.swap(entries_);
    const std::span<const wire::record::CodedRecord> records = coding_;
    std::size_t done = 0;
    while (done < records.size()) {
        head_.coded = true;
        std::size_t count = records.size() - done;
        std::shared_ptr<const wire::record::RecordFrame> frame;
        for (;; count = (3 * count + 3) / 4) {
            body_.clear();
            wire::write_down_head(head_, body_);
            head_bytes_ = body_.size();
            frame = client.coder->encode(
                static_cast<wire::entropy::PacketNumber>(client.next_sequence()),
                now,
                head_.zone,
                records.subspan(done, count),
                body_,
                meter_ != nullptr);
            const auto size = static_cast<float>(body_.size() - head_bytes_);
            client.coded_bytes += (size / static_cast<float>(count) - client.coded_bytes) / 8.0F;
            if (body_.size() <= wire::kMaxDownBodyBytes) {
                break;
            }
        }
        if (meter_) {
            count_coded(*frame);
        }
        client.coder->sent(std::move(frame));
        const auto first = coding_entries_.begin() + static_cast<std::ptrdiff_t>(done);
        entries_.assign(first, first + static_cast<std::ptrdiff_t>(count));
        send(now, client, report, out);
        done += count;
        begin(now, head_.zone, nullptr);
    }
    reasons_.clear();
}

void Packer::send(Tick now,
                  ClientState& client,
                  Report& report,
                  std::vector<mailbox::StatePacket>& out) {
    SentPacket& packet = client.begin_packet(now);
    if (head_.has_own) {
        OwnTrack& track = client.own;
        if (track.sent_tick < 0 || !same_state(track.sent, head_.own.state)) {
            track.sent = head_.own.state;
            ++track.stamp;
        }
        track.sent_tick = now;
        packet.own_stamp = track.stamp;
    }
    packet.coded = head_.coded;
    if (head_.coded) {
        ++report.coded_packets;
        report.coded_records += static_cast<std::uint32_t>(entries_.size());
        coding_ns_ -= static_cast<double>(price_.packet_ns) +
                      static_cast<double>(price_.record_ns) * static_cast<double>(entries_.size());
    }
    packet.entries.assign(entries_.begin(), entries_.end());
    entries_.clear();
    mailbox::StatePacket& datagram = out.emplace_back();
    datagram.client = client.client;
    datagram.sequence = packet.sequence;
    datagram.body.assign(body_.begin(), body_.end());
    client.tokens -= static_cast<double>(body_.size() + kPacketOverheadBytes);
    if (meter_) {
        meter_->table().add_packet(head_bytes_, head_bytes_ - wire::down_head_bytes(head_));
    }
    ++report.packets;
    report.bytes += body_.size();
}

}  // namespace zoned::replication

#include "server/replication/packer.h"

#include <algorithm>

namespace zoned::replication {

namespace {

// A removal is small and ends a wrong picture. An entity that the client has never seen comes
// before one that it merely predicts a little wrong. Further copies come last.
constexpr float kRemovalWeight = 4.0F;
constexpr float kUnknownWeight = 2.0F;
constexpr float kRepeatWeight = 0.25F;

// Where the budget is short, packets wait until headers are no more than a fifth of them.
constexpr double kWorthwhileBytes = 5.0 * kPacketOverheadBytes;
// The approximate size of a head and a record; only for the decision to wait.
constexpr double kTypicalHeadBytes = 10.0;
constexpr double kTypicalRecordBytes = 24.0;
/// Beside it, the largest that many records are on average.
constexpr double kLargestShare = 4.0;

bool same_state(const motion::CharacterState& a, const motion::CharacterState& b) {
    return a.position == b.position && a.velocity == b.velocity && a.yaw == b.yaw &&
           a.grounded == b.grounded && a.carried == b.carried;
}

}  // namespace

void Packer::pack(Tick now,
                  ZoneId zone,
                  const OwnNow& own,
                  ClientState& client,
                  StreamTable& streams,
                  ReplicationReport& report,
                  std::vector<mailbox::StatePacket>& out) {
    client.refill(settings_);
    codes_ = client.coder != nullptr &&
             (settings_.codec != Codec::kAuto || coding_ns_ >= client.demand.cost_ns(price_));
    gather(now, client, streams);
    OwnTrack& track = client.own;
    const bool silence =
        client.packet_tick < 0 || now - client.packet_tick >= client.silence_ticks(settings_);
    // Own state and signs of life may go into debt; the records then wait until it is paid.
    const bool due = client.away() ? silence || client.sign_due(now)
                                   : silence || (own_due(now, own, track) && client.tokens >= 0.0);
    track.input_missing = own.present && own.state.input_missing;
    if (candidates_.empty() && !due) {
        return;
    }
    if (client.away()) {
        widen(now, client, streams);  // the client is notified that it gets no updates
    }
    double fields = 0.0;
    for (const PacketCandidate& c : candidates_) {
        fields += static_cast<double>(c.declared_bytes);
    }
    const double records = kTypicalRecordBytes * static_cast<double>(candidates_.size());
    const double need =
        static_cast<double>(kPacketOverheadBytes) + kTypicalHeadBytes + records + fields;
    tight_ = need > client.tokens;
    if (tight_) {
        order_by_error(now, client, streams);
        order_unseen_by_distance(own, client, streams);
    }
    const bool wait = client.tokens < std::min(need, kWorthwhileBytes);
    bool tells_bounds = false;
    if (wait && !due) {
        const wire::Widened announced = client.widened;
        widen(now, client, streams);
        // Bounds hold until the next packet: wider ones are worth one at once.
        tells_bounds = client.widened.step > announced.step ||
                       client.widened.incomplete > announced.incomplete;
        if (!tells_bounds) {
            ++report.over_budget;
            return;
        }
    }
    const bool own_is_known = track.sent_tick >= 0 && same_state(track.sent, own.state.state) &&
                              track.acked_stamp == track.stamp && !own.state.input_missing;
    // A packet that goes out anyway takes the own state along, but not more often than needed.
    const bool own_is_recent =
        track.sent_tick >= 0 &&
        2 * (now - track.sent_tick) < static_cast<Tick>(settings_.own_state_every_ticks);
    // Records may be larger than usual, and then the last ones do not fit.
    head_.has_widened =
        need + (kLargestShare - 1.0) * records > client.tokens || client.widened != wire::Widened{};
    begin(
        now, zone, own.present && (due || !(own_is_known || own_is_recent)) ? &own.state : nullptr);
    const std::size_t packets_before = out.size();
    write_records(now, zone, client, streams, report, out);
    if (!entries_.empty() || ((due || tells_bounds) && out.size() == packets_before)) {
        finish(now, client, streams, report, out);
    }
    report.over_budget += candidates_.empty() ? 0 : 1;
    widen(now, client, streams);
    notify(client, std::span(out).subspan(packets_before), report);
}

/// Leaves in candidates_ the updates that did not fit into the budget.
void Packer::write_records(Tick now,
                           ZoneId zone,
                           ClientState& client,
                           StreamTable& streams,
                           ReplicationReport& report,
                           std::vector<mailbox::StatePacket>& out) {
    std::size_t done = 0;
    while (done < candidates_.size()) {
        const double allowed = client.tokens - static_cast<double>(kPacketOverheadBytes);
        if (add(now, candidates_[done], allowed, client, streams, report)) {
            ++done;
        } else if (entries_.empty() || allowed < static_cast<double>(wire::kMaxDownBodyBytes)) {
            break;  // the budget ended
        } else {
            finish(now, client, streams, report, out);
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
    PacketCandidate candidate;
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
        if (streams.version(s.stream) == s.delivered_version) {
            continue;
        }
        const Stream& stream = streams[s.stream];
        const float weight =
            stream.priority * (s.known ? 1.0F : kUnknownWeight) / static_cast<float>(1 + s.lod);
        if (consider(now, s.sent_version != stream.version, s.delivery, weight, candidate)) {
            candidate.index = i;
            candidate.declared_bytes = streams.declared_bytes(s.stream, held_version(s));
            candidates_.push_back(candidate);
        }
    }
    sort_candidates();
}

/// Most urgent first; ties go by entity.
void Packer::sort_candidates() {
    std::sort(candidates_.begin(),
              candidates_.end(),
              [](const PacketCandidate& a, const PacketCandidate& b) {
                  if (a.score != b.score) {
                      return a.score > b.score;
                  }
                  return a.removal != b.removal ? a.removal : a.index < b.index;
              });
}

/// True when something is to be sent now. Gives the reason and the urgency: weight times the ticks
/// for which it has been pending.
bool Packer::consider(Tick now,
                      bool update,
                      Delivery& delivery,
                      float weight,
                      PacketCandidate& candidate) {
    if (update) {
        candidate.reason = Reason::kUpdate;
    } else if (!settings_.resend) {
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
    if (delivery.pending_tick == 0) {
        delivery.pending_tick = now;
    }
    candidate.score = weight * static_cast<float>(1 + now - delivery.pending_tick);
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
    declared_bytes_.clear();
    wire::write_down_head(head_, body_);
    head_bytes_ = body_.size();
}

bool Packer::fits(std::size_t size, double allowed_bytes) {
    return size <= wire::kMaxDownBodyBytes && static_cast<double>(size) <= allowed_bytes;
}

/// Appends one record; false when it fits neither into the packet nor into the allowed bytes.
bool Packer::add(Tick now,
                 const PacketCandidate& candidate,
                 double allowed_bytes,
                 ClientState& client,
                 StreamTable& streams,
                 ReplicationReport& report) {
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
        const Stream* stream = s != nullptr ? &streams[s->stream] : nullptr;
        if (!add_coded(
                now, entry.entity, stream, candidate.declared_bytes, allowed_bytes, client)) {
            return false;
        }
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
    if (s != nullptr) {
        streams.count_sent(
            s->stream,
            codes_ ? static_cast<std::size_t>(client.coded_bytes) : encoded.bytes->size());
    }
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
            // An update that was lost in all its copies (an outage) is repeated as often as the
            // first time.
            s->sent_version = entry.version;
            delivery.copies = 0;
            delivery.in_flight = 0;
        }
        s->known = true;
    }
    delivery.copies = static_cast<std::uint8_t>(std::min(delivery.copies + 1, 255));
    delivery.in_flight = static_cast<std::uint8_t>(std::min(delivery.in_flight + 1, 255));
    delivery.sent_tick = now;
    delivery.pending_tick = 0;
    ++report.records_sent;
    report.records_resent += candidate.reason == Reason::kUpdate ? 0 : 1;
    report.records_repeated += candidate.reason == Reason::kRepeat ? 1 : 0;
    return true;
}

/// Each record has one reason: the first of these that holds.
wire::TrafficReason Packer::reason_of(const PacketCandidate& candidate,
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
    return encoded.keyframe != 0 ? TrafficReason::kKeyframe : TrafficReason::kUpdate;
}

void Packer::finish(Tick now,
                    ClientState& client,
                    const StreamTable& streams,
                    ReplicationReport& report,
                    std::vector<mailbox::StatePacket>& out) {
    if (coded_.empty()) {
        send(now, client, report, out);
    } else {
        finish_coded(now, client, streams, report, out);
    }
}

void Packer::send(Tick now,
                  ClientState& client,
                  ReplicationReport& report,
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

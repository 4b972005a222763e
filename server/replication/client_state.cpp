#include "server/replication/client_state.h"

#include "shared/core/assert.h"
#include "shared/wire/resend_timeout.h"

#include <algorithm>
#include <bit>

namespace zoned::replication {

namespace {

constexpr double kDefaultRtt_us = 100e3;         // before the session has measured one
constexpr double kInitialWindowBytes = 14600.0;  // RFC 6928, section 2: ten segments
constexpr double kSmallestBurstBytes = 256.0;
constexpr double kAway_s = 1.0;              // and two round trips: without any new acknowledgement
constexpr std::uint64_t kAckReach = 32;      // packets before the newest that it names
constexpr Tick kSignTicks = 2;               // between signs of life for one that was just heard
constexpr double kNarrowBurstBytes = 512.0;  // headers are a fifth of a packet at least as large

}  // namespace

double burst_bytes(const ReplicationSettings& settings) {
    return std::max(kSmallestBurstBytes, 0.25 * settings.budget_bytes_per_s);
}

double opening_bytes(const ReplicationSettings& settings) {
    const auto second = static_cast<double>(settings.budget_bytes_per_s);
    return std::max(burst_bytes(settings), std::min(kInitialWindowBytes, second));
}

ClientState::ClientState(const ClientTransfer& transfer, const ReplicationSettings& settings)
    : client(transfer.client),
      tokens(transfer.next_sequence == 1 ? opening_bytes(settings) : transfer.budget_bytes),
      widened(transfer.widened),
      demand(transfer.demand),
      next_sequence_(transfer.next_sequence),
      first_sequence_(transfer.next_sequence),
      oldest_open_(transfer.next_sequence),
      newest_acked_(transfer.next_sequence - 1),
      loss_(transfer.next_sequence == 1 ? PathLoss() : PathLoss(transfer.loss_estimate)),
      rtt_us_(transfer.rtt_us),
      rtt_variation_us_(transfer.rtt_variation_us),
      rate_bytes_per_s_(transfer.rate_bytes_per_s),
      next_epoch_(transfer.codec_epoch),
      reached_(transfer.reached) {
    code(settings.codec == Codec::kPerClient || (settings.codec == Codec::kAuto && transfer.coded),
         settings);
    // Whatever turns out to be in view takes its removal back in the first sync().
    for (const EntityId entity : transfer.known) {
        add_removal(entity, 0);
    }
}

ClientTransfer ClientState::transfer() const {
    ClientTransfer t;
    t.client = client;
    t.next_sequence = next_sequence_;
    t.loss_estimate = loss_.share();
    t.budget_bytes = tokens;
    t.rtt_us = rtt_us_;
    t.rtt_variation_us = rtt_variation_us_;
    t.reached = reached_;
    t.rate_bytes_per_s = rate_bytes_per_s_;
    t.widened = widened;
    // The next zone's coder shares no history with this one.
    t.codec_epoch = coder != nullptr ? static_cast<std::uint8_t>(coder->epoch() + 1) : next_epoch_;
    t.coded = coder != nullptr;
    t.demand = demand;
    for (const Subscription& s : subscriptions) {
        if (s.known) {
            t.known.push_back(s.entity);
        }
    }
    for (const Removal& r : removals) {
        t.known.push_back(r.entity);
    }
    std::sort(t.known.begin(), t.known.end());
    return t;
}

void ClientState::code(bool alone, const ReplicationSettings& settings) {
    if (alone == (coder != nullptr)) {
        return;
    }
    if (alone) {
        const wire::record::RecordFormat format(
            settings.quantization, settings.tick_s, settings.fields);
        coder = std::make_unique<wire::record::RecordEncoder>(format, next_epoch_);
    } else {
        next_epoch_ = static_cast<std::uint8_t>(coder->epoch() + 1);
        coder.reset();
    }
}

// ---------------------------------------------------------------- what the client hears of

void ClientState::update_subscriptions(const std::vector<world::Visible>& visible,
                                       Tick now,
                                       StreamTable& streams,
                                       std::vector<Subscription>& scratch) {
    const bool unchanged = std::equal(subscriptions.begin(),
                                      subscriptions.end(),
                                      visible.begin(),
                                      visible.end(),
                                      [](const Subscription& s, const world::Visible& v) {
                                          return s.entity == v.entity && s.lod == v.lod;
                                      });
    if (unchanged) {
        return;
    }
    scratch.clear();
    auto old = subscriptions.begin();
    const auto drop_before = [&](EntityId end, bool all) {
        for (; old != subscriptions.end() && (all || old->entity < end); ++old) {
            streams.unsubscribe(old->stream);
            if (old->known) {
                add_removal(old->entity, now);
            }
        }
    };
    for (const world::Visible& v : visible) {
        drop_before(v.entity, false);
        if (old == subscriptions.end() || old->entity != v.entity) {
            scratch.push_back(subscribe(v, now, cancel_removal(v.entity), streams));
        } else if (old->lod == v.lod) {
            scratch.push_back(*old++);
        } else {
            follow_on(*old, streams);
            streams.unsubscribe(old->stream);
            scratch.push_back(subscribe(v, now, (old++)->known, streams));
        }
    }
    drop_before(EntityId(), true);
    subscriptions.assign(scratch.begin(), scratch.end());
    forget_followed();
}

Subscription ClientState::subscribe(const world::Visible& visible,
                                    Tick now,
                                    bool known,
                                    StreamTable& streams) {
    Subscription s;
    s.entity = visible.entity;
    s.lod = visible.lod;
    s.stream = streams.subscribe(visible.entity, visible.lod);
    s.stamp = next_stamp_++;
    s.known = known;
    s.switched_tick = known ? now : 0;
    s.delivery.pending_tick = now;
    return s;
}

/// True when the client may still hold the entity.
bool ClientState::cancel_removal(EntityId entity) {
    const auto it = lower_bound_entity(removals, entity);
    if (it == removals.end() || it->entity != entity) {
        return false;
    }
    removals.erase(it);
    return true;
}

const Subscription* ClientState::subscription(EntityId entity) const {
    const auto it = lower_bound_entity(subscriptions, entity);
    return it != subscriptions.end() && it->entity == entity ? &*it : nullptr;
}

void ClientState::add_removal(EntityId entity, Tick now) {
    const auto it = lower_bound_entity(removals, entity);
    if (it == removals.end() || it->entity != entity) {
        Removal r;
        r.entity = entity;
        r.stamp = next_stamp_++;
        r.delivery.pending_tick = now;
        removals.insert(it, r);
    }
}

void ClientState::reset_view() {
    if (coder != nullptr) {
        coder->start_over();
    }
    followed_.clear();
    for (Subscription& s : subscriptions) {
        s.stamp = next_stamp_++;
        s.sent_version = 0;
        s.delivered_version = 0;
        s.held_keyframe = 0;
        s.delivery = Delivery{};
    }
    for (Removal& r : removals) {
        r.stamp = next_stamp_++;
        r.delivery = Delivery{};
    }
    own.sent_tick = -1;
}

// ---------------------------------------------------------------- status of packets

SentPacket& ClientState::begin_packet(Tick now) {
    // A packet that is still open after kCapacity newer ones can't be acknowledged any more.
    SentPacket* displaced = next_sequence_ > SentLog::kCapacity
                                ? log_.find(next_sequence_ - SentLog::kCapacity)
                                : nullptr;
    if (displaced != nullptr) {
        if (displaced->status == DeliveryStatus::kOpen) {
            for (const SentEntry& entry : displaced->entries) {
                lose(entry);
            }
        }
        // Where nothing sent after it was acknowledged, its acknowledgement may still be on its
        // way.
        if (newest_acked_ > displaced->sequence) {
            sample_loss(*displaced, displaced->status != DeliveryStatus::kAcked);
        }
    }
    packet_tick = now;
    heard_while_away_ = false;
    SentPacket& packet = log_.add(next_sequence_++, now);
    packet.counted = away_;
    return packet;
}

bool ClientState::on_acks(const mailbox::Acks& acks) {
    if (acks.rtt_us != 0) {
        rtt_us_ = acks.rtt_us;
        rtt_variation_us_ = acks.rtt_variation_us;
    }
    if (acks.rate_bytes_per_s != 0) {
        rate_bytes_per_s_ = acks.rate_bytes_per_s;
    }
    if (acks.newest >= next_sequence_) {
        return false;  // nothing like that was ever sent
    }
    note_unreported(acks.newest);
    for (std::uint64_t fresh = take_fresh(acks); fresh != 0; fresh &= fresh - 1) {
        const auto back = static_cast<std::uint64_t>(std::countr_zero(fresh));
        if (back >= acks.newest) {
            break;
        }
        // This log does not hold the packets that another zone sent before the handoff.
        SentPacket* packet = log_.find(acks.newest - back);
        if (packet == nullptr || packet->status == DeliveryStatus::kAcked) {
            continue;
        }
        note_acked(*packet);
        packet->status = DeliveryStatus::kAcked;
        if (packet->coded && coder != nullptr) {
            coder->acknowledge(static_cast<wire::entropy::PacketNumber>(packet->sequence));
        }
        if (packet->counted_lost) {
            packet->counted_lost = false;
            loss_.on_found();
        }
        sample_loss(*packet, false);
        own.acked_stamp = std::max(own.acked_stamp, packet->own_stamp);
        for (const SentEntry& entry : packet->entries) {
            deliver(entry);
        }
    }
    if (acks.newest <= newest_acked_) {
        return false;
    }
    set_reach(true);
    newest_acked_ = acks.newest;
    return true;
}

/// The packets that an acknowledgement is the first to name; bit i: its newest - i. Each one
/// repeats those before it, whose packets need no look.
std::uint64_t ClientState::take_fresh(const mailbox::Acks& acks) {
    const std::uint64_t reported = (std::uint64_t{acks.bits} << 1U) | 1U;
    if (acks.newest < newest_acked_) {
        const std::uint64_t behind = newest_acked_ - acks.newest;
        const std::uint64_t known = behind < 64 ? acked_bits_ >> behind : 0;
        acked_bits_ |= behind < 64 ? reported << behind : 0;
        return reported & ~known;
    }
    const std::uint64_t ahead = acks.newest - newest_acked_;
    const std::uint64_t known = ahead < 64 ? acked_bits_ << ahead : 0;
    acked_bits_ = known | reported;
    return reported & ~known;
}

/// After a stall an acknowledgement may not reach back to all packets since the one before it.
/// Nothing will ever tell whether the others came, so they say nothing of the path.
void ClientState::note_unreported(std::uint64_t newest) {
    const std::uint64_t kept = newest > SentLog::kCapacity ? newest - SentLog::kCapacity : 0;
    for (std::uint64_t sequence = std::max(newest_acked_, kept) + 1; sequence + kAckReach < newest;
         ++sequence) {
        SentPacket* packet = log_.find(sequence);
        if (packet != nullptr) {
            packet->counted = true;
        }
    }
}

void ClientState::note_acked(const SentPacket& packet) {
    fates_.found += packet.status == DeliveryStatus::kLost ? 1 : 0;
    ack_delay_.on_acked({packet.sequence,
                         packet.tick,
                         packet.sequence < newest_acked_ ? newest_acked_ - packet.sequence : 0,
                         packet.status == DeliveryStatus::kLost,
                         away_});
}

void ClientState::give_up(SentPacket& packet) {
    packet.status = DeliveryStatus::kLost;
    ++fates_.given_up;
    for (const SentEntry& entry : packet.entries) {
        lose(entry);
    }
}

/// Loss is inferred from the acknowledgement of later packets, as in RFC 9002, section 6.1: one
/// sent as many packets later as reordering explains, or any later one once the packet is older
/// than acknowledgements are. Without a later one only a probe goes out (section 6.2): the newest
/// state of what is overdue, at intervals that double. Ticks in which the whole zone was silent
/// do not count for it. A packet counts as lost only after three times as long: a merely late
/// packet must not raise the estimate.
void ClientState::expire(Tick now, float tick_s, const ZoneSilence& silence) {
    look_for_outage(now, tick_s);
    const double rtt_us = rtt_us_ == 0 ? kDefaultRtt_us : static_cast<double>(rtt_us_);
    const clock::RoundTrip path(1e-6 * rtt_us, 1e-6 * rtt_variation_us_);
    const double tick = static_cast<double>(tick_s);
    const Tick round_trip = wire::round_trip_ticks(path.smoothed_s, tick);
    ack_delay_.begin_tick(now, tick_s, wire::resend_timeout_ticks(path, tick), round_trip);
    bool resolved_so_far = true;
    for (std::uint64_t sequence = oldest_open_; sequence < next_sequence_; ++sequence) {
        SentPacket* packet = log_.find(sequence);
        if (packet != nullptr) {
            const Tick age = now - packet->tick;
            if (packet->status == DeliveryStatus::kOpen &&
                (newest_acked_ > sequence ? ack_delay_.passed_over(newest_acked_ - sequence, age)
                                          : ack_delay_.probe(now, age - silence.among(age)))) {
                give_up(*packet);
            }
            if (packet->status == DeliveryStatus::kLost && newest_acked_ > sequence &&
                age > 3 * round_trip) {
                sample_loss(*packet, true);
            }
            resolved_so_far = resolved_so_far && packet->counted;
        }
        if (resolved_so_far) {
            oldest_open_ = sequence + 1;
        }
    }
}

void ClientState::look_for_outage(Tick now, float tick_s) {
    if (newest_acked_ != heard_newest_ || heard_tick_ < 0) {
        if (away_) {
            widened = {};  // the bytes still pending decide anew, in this tick
        }
        away_ = false;
        heard_while_away_ = false;
        heard_newest_ = newest_acked_;
        heard_tick_ = now;
        heard_loss_ = loss_;
        return;
    }
    const double rtt_us = rtt_us_ == 0 ? kDefaultRtt_us : static_cast<double>(rtt_us_);
    const double silent_s = static_cast<double>(now - heard_tick_) * static_cast<double>(tick_s);
    // A client that has never acknowledged anything may have no working uplink yet, and must still
    // be shown the world.
    if (!away_ && newest_acked_ != 0 && silent_s > kAway_s + 2e-6 * rtt_us) {
        begin_away();
    }
}

void ClientState::begin_away() {
    away_ = true;
    for (std::uint64_t sequence = oldest_open_; sequence < next_sequence_; ++sequence) {
        SentPacket* packet = log_.find(sequence);
        if (packet == nullptr || sequence <= heard_newest_) {
            continue;
        }
        if (packet->status == DeliveryStatus::kOpen) {
            give_up(*packet);
        }
        packet->counted = true;
    }
    loss_ = heard_loss_;
}

void ClientState::on_heard() {
    set_reach(true);
    heard_while_away_ = away_;
}

void ClientState::set_reach(bool on) {
    if (reached_ && !on && !away_) {
        begin_away();
    } else if (!reached_ && on && newest_acked_ == 0) {
        away_ = false;  // as one that is new
    }
    reached_ = on;
}

bool ClientState::sign_due(Tick now) const {
    return heard_while_away_ && now - packet_tick >= kSignTicks;
}

void ClientState::sample_loss(SentPacket& packet, bool lost) {
    if (!packet.counted) {
        packet.counted = true;
        packet.counted_lost = lost;
        lost ? loss_.on_lost() : loss_.on_arrived();
    }
}

Subscription* ClientState::find(const SentEntry& entry) {
    const auto it = lower_bound_entity(subscriptions, entry.entity);
    const bool same =
        it != subscriptions.end() && it->entity == entry.entity && it->stamp == entry.stamp;
    return same ? &*it : nullptr;
}

void ClientState::deliver(const SentEntry& entry) {
    if (entry.version == 0) {
        const auto it = lower_bound_entity(removals, entry.entity);
        if (it != removals.end() && it->entity == entry.entity && it->stamp == entry.stamp) {
            removals.erase(it);
        }
    } else if (Subscription* s = find(entry)) {
        s->delivered_version = std::max(s->delivered_version, entry.version);
        s->held_keyframe = std::max(s->held_keyframe, entry.keyframe);
    }
}

void ClientState::lose(const SentEntry& entry) {
    Delivery* delivery = nullptr;
    if (entry.version == 0) {
        const auto it = lower_bound_entity(removals, entry.entity);
        if (it != removals.end() && it->entity == entry.entity && it->stamp == entry.stamp) {
            delivery = &it->delivery;
        }
    } else if (Subscription* s = find(entry); s != nullptr && s->sent_version == entry.version) {
        delivery = &s->delivery;  // an older version is not missed: a newer one is in flight
    }
    if (delivery != nullptr && delivery->in_flight > 0) {
        --delivery->in_flight;
    }
}

Tick ClientState::unacknowledged(std::vector<mailbox::AuditUpdate>& out) const {
    struct SentCopy {
        EntityId entity;
        std::uint64_t sequence = 0;
        Tick tick = 0;
        bool acked = false;
    };

    std::vector<SentCopy> sent_copies;
    const std::uint64_t oldest =
        next_sequence_ > SentLog::kCapacity ? next_sequence_ - SentLog::kCapacity : 1;
    for (std::uint64_t sequence = oldest; sequence < next_sequence_; ++sequence) {
        const SentPacket* packet = log_.find(sequence);
        for (std::size_t i = 0; packet != nullptr && i < packet->entries.size(); ++i) {
            const SentEntry& entry = packet->entries[i];
            const auto removal = lower_bound_entity(removals, entry.entity);
            const bool leaving = removal != removals.end() && removal->entity == entry.entity;
            if (!leaving || entry.stamp == removal->stamp) {
                sent_copies.push_back({entry.entity,
                                       sequence,
                                       packet->tick,
                                       packet->status == DeliveryStatus::kAcked});
            }
        }
    }
    std::sort(sent_copies.begin(), sent_copies.end(), [](const SentCopy& a, const SentCopy& b) {
        return a.entity != b.entity ? a.entity < b.entity : a.sequence < b.sequence;
    });
    const auto update_of = [&](EntityId entity) -> mailbox::AuditUpdate& {
        const auto at = lower_bound_entity(out, entity);
        return at != out.end() && at->entity == entity ? *at
                                                       : *out.insert(at, {entity, 0, false, {}});
    };
    for (std::size_t i = 0; i < sent_copies.size(); ++i) {
        if (sent_copies[i].acked) {
            if (!out.empty() && out.back().entity == sent_copies[i].entity) {
                out.pop_back();
            }
        } else {
            update_of(sent_copies[i].entity)
                .carried.push_back({sent_copies[i].tick, sent_copies[i].sequence});
        }
    }
    for (const Subscription& s : subscriptions) {
        if (s.postponed_tick > 0 && s.delivered_version == 0) {
            update_of(s.entity).postponed_tick = s.postponed_tick;
        }
    }
    for (const Removal& r : removals) {
        if (r.postponed_tick > 0 || r.delivery.copies > 0) {
            mailbox::AuditUpdate& update = update_of(r.entity);
            update.postponed_tick = r.postponed_tick;
            update.leaving = true;
        }
    }
    if (first_sequence_ == 1 && oldest == 1) {
        return 1;  // it came from no other zone, and nothing is forgotten
    }
    const SentPacket* first = log_.find(std::max(oldest, first_sequence_));
    return first != nullptr ? first->tick : 0;
}

// ---------------------------------------------------------------- rates

double ClientState::allowed_bytes(const ReplicationSettings& settings) const {
    const bool narrow = rate_bytes_per_s_ != 0 && rate_bytes_per_s_ < settings.budget_bytes_per_s;
    return static_cast<double>(narrow ? rate_bytes_per_s_ : settings.budget_bytes_per_s) *
           static_cast<double>(settings.tick_s);
}

void ClientState::refill(const ReplicationSettings& settings) {
    const bool narrow = rate_bytes_per_s_ != 0 && rate_bytes_per_s_ < settings.budget_bytes_per_s;
    const double per_tick = allowed_bytes(settings);
    const double burst =
        narrow ? std::max(kNarrowBurstBytes, 1.5 * per_tick) : burst_bytes(settings);
    // A new client's first allowance is larger than the allowance that may gather later.
    tokens = narrow || tokens < burst ? std::min(burst, tokens + per_tick) : tokens;
}

void ClientState::hash(core::StateHash& hash) const {
    hash.add(client.value);
    hash.add(next_sequence_);
    hash.add(newest_acked_);
    hash.add(loss_.share());
    ack_delay_.hash(hash);
    hash.add(tokens);
    hash.add(rate_bytes_per_s_);
    hash.add(away_);
    hash.add(reached_);
    hash.add(coder != nullptr);
    for (const Subscription& s : subscriptions) {
        hash.add(s.entity.value);
        hash.add(s.lod);
        hash.add(s.sent_version);
        hash.add(s.delivered_version);
        hash.add(s.held_keyframe);
    }
    for (const Removal& r : removals) {
        hash.add(r.entity.value);
    }
}

bool ClientState::is_sound(const StreamTable& streams) const {
    const auto ascend = [](const auto& list) {
        return std::is_sorted(list.begin(), list.end(), [](const auto& a, const auto& b) {
            return a.entity < b.entity;
        });
    };
    return ascend(subscriptions) && ascend(removals) && ascend(followed_) &&
           std::all_of(subscriptions.begin(), subscriptions.end(), [&](const Subscription& s) {
               return s.stream < streams.rows() && streams[s.stream].entity == s.entity &&
                      s.lod < wire::kLods;
           });
}

}  // namespace zoned::replication

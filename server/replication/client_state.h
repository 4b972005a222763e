// ClientState: the subscriptions, acknowledgements and pending updates of one client.
#pragma once

#include "server/mailbox/messages.h"
#include "server/replication/delivery/ack_delay.h"
#include "server/replication/delivery/path_loss.h"
#include "server/replication/delivery/sent_log.h"
#include "server/replication/delivery/zone_silence.h"
#include "server/replication/stream_table.h"
#include "server/world/visibility.h"
#include "shared/core/state_hash.h"
#include "shared/motion/apply_input.h"
#include "shared/wire/record/record_codec.h"
#include "shared/wire/widening.h"

#include <algorithm>
#include <utility>

namespace zoned::replication {

/// The first of a list that ascends by entity which is not before one.
template <class List>
auto lower_bound_entity(List& list, EntityId entity) {
    return std::lower_bound(list.begin(), list.end(), entity, [](const auto& item, EntityId e) {
        return item.entity < e;
    });
}

/// How often the newest copy of something was sent, and its fate.
struct Delivery {
    Tick sent_tick = 0;          ///< of the newest copy
    Tick pending_tick = 0;       ///< since when something is unsent; 0 = nothing noticed yet
    std::uint8_t copies = 0;     ///< sent
    std::uint8_t in_flight = 0;  ///< of these, neither acknowledged nor given up
};

/// A subscription of one client.
struct Subscription {
    EntityId entity;
    StreamIndex stream = kNoStream;
    std::uint32_t stamp = 0;  ///< names this subscription: packets of an earlier one are void
    std::uint32_t sent_version = 0;       ///< newest version sent, 0 = none
    std::uint32_t delivered_version = 0;  ///< newest version acknowledged
    std::uint32_t held_keyframe = 0;      ///< newest keyframe acknowledged, by serial
    Delivery delivery;
    std::uint8_t lod = 0;
    bool known = false;  ///< the client may hold the entity, so it must be notified of its removal
    Tick switched_tick =
        0;  ///< when it took over from another stream that the client still follows
    Tick postponed_tick = 0;  ///< when the budget last delayed the first update of it
};

/// The version of its stream from which the client is assumed to predict: the last one sent unless
/// that was lost; 0: none.
inline std::uint32_t held_version(const Subscription& s) {
    return s.delivery.in_flight > 0 ? s.sent_version : s.delivered_version;
}

/// The base from which a client predicts an entity that has passed to another stream, while the
/// client holds nothing of that stream yet.
struct Followed {
    EntityId entity;
    Past publication;      ///< of the stream that it leaves
    float off_m = 0.0F;    ///< the client may hold a state that differs by so much ...
    float off_rad = 0.0F;  ///< ... and so much
};

/// An entity that the client may hold and must forget; pending until acknowledged.
struct Removal {
    EntityId entity;
    std::uint32_t stamp = 0;
    Tick postponed_tick = 0;  ///< when the budget last made it wait
    Delivery delivery;
};

/// The client's own avatar as last sent.
struct OwnTrack {
    motion::CharacterState sent;
    Tick sent_tick = -1;            ///< -1: never
    std::uint32_t stamp = 0;        ///< counts different states sent
    std::uint32_t acked_stamp = 0;  ///< newest of them that arrived
    bool input_missing = false;     ///< as of the last tick
};

/// Everything kept per client. Entities are identified by id; rows change between ticks.
class ClientState {
  public:
    ClientState(const ClientTransfer& transfer, const ReplicationSettings& settings);

    [[nodiscard]] ClientTransfer transfer() const;

    /// Brings subscriptions in line with the client's visible set; both ascend by entity.
    void update_subscriptions(const std::vector<world::Visible>& visible,
                              Tick now,
                              StreamTable& streams,
                              std::vector<Subscription>& scratch);

    /// Drops all subscriptions; entities that the client may hold become pending removals.
    void detach(Tick now, StreamTable& streams, std::vector<Subscription>& scratch) {
        update_subscriptions({}, now, streams, scratch);
    }

    /// As the session measures it; 0: not yet.
    [[nodiscard]] std::uint32_t rtt_us() const { return rtt_us_; }

    /// nullptr: it is not subscribed to the entity.
    [[nodiscard]] const Subscription* subscription(EntityId entity) const;

    /// True when a newer packet than ever before was acknowledged.
    bool on_acks(const mailbox::Acks& acks);
    /// Gives up packets that the client has passed over, probes where acknowledgements stay out,
    /// and gives up all when the client has gone silent.
    void expire(Tick now, float tick_s, const ZoneSilence& silence);

    /// True in an outage: the client acknowledged packets before, but none for a second and two
    /// round trips. It then gets nothing but signs of life. Its acknowledged state stays as it is,
    /// so that afterwards only changes are pending. Losses in an outage say nothing of the network
    /// before and after it.
    [[nodiscard]] bool away() const { return away_; }

    /// Something came from the client: when it is away, the next sign of life is due soon.
    void on_heard();

    /// mailbox::Reach. A client that cannot be reached is away, and is not even sent signs of life.
    void set_reach(bool on);

    [[nodiscard]] bool reached() const { return reached_; }

    /// Everything is pending anew, absolute.
    void reset_view();

    /// Of the next packet.
    [[nodiscard]] std::uint64_t next_sequence() const { return next_sequence_; }

    /// Begins the log entry of a packet and counts the sequence up.
    SentPacket& begin_packet(Tick now);

    /// Copies of an update to send so that the chance to lose them all is below `target`, 1..8. One
    /// where acknowledgements are late: copies are the first thing that an overload gives up.
    [[nodiscard]] int copies_wanted(float target) const {
        return ack_delay_.late() ? 1 : loss_.copies_wanted(target);
    }

    /// A packet goes out at least this often. Clocks and inputs are timed by packets, and through
    /// round trips that vary this takes more of them, unless a narrow path or an overload is why.
    [[nodiscard]] Tick silence_ticks(const ReplicationSettings& settings) const {
        const auto most = static_cast<Tick>(settings.silence_ticks);
        const double variation_s = 1e-6 * static_cast<double>(rtt_variation_us_);
        const bool varies = variation_s > kVaries * static_cast<double>(settings.tick_s);
        const bool has_room = rate_bytes_per_s_ == 0 && !acks_are_late();
        return varies && has_room ? std::min(most, kTimingTicks) : most;
    }

    [[nodiscard]] bool acks_are_late() const { return ack_delay_.late(); }

    /// The fates of its packets since this was asked last.
    struct Fates {
        std::uint32_t given_up = 0;  ///< their updates are sent again
        std::uint32_t found = 0;     ///< given up and acknowledged after all
    };

    Fates take_fates() { return std::exchange(fates_, {}); }

    /// When away: a sign of life is due, because something came from the client.
    [[nodiscard]] bool sign_due(Tick now) const;

    /// From now on this client's records are coded for it alone, or not any more.
    void code(bool alone, const ReplicationSettings& settings);

    /// Bytes that it may be sent per tick: its budget, or the capacity of the path if that is less.
    [[nodiscard]] double allowed_bytes(const ReplicationSettings& settings) const;

    /// Tokens for one more tick, of the budget or of the path's capacity, if that is less. They
    /// never exceed a quarter of a second's worth of the budget. On a path with less capacity,
    /// where bursts wait in a queue, the limit is a tick and a half's (or the size of one small
    /// packet).
    void refill(const ReplicationSettings& settings);

    /// When the client passed to the present stream of an entity from another level of detail or
    /// zone; 0 = never.
    [[nodiscard]] Tick switch_tick(EntityId entity) const;

    /// The base from which the client predicts a subscribed entity until it has something of the
    /// present stream; nullptr: not known.
    [[nodiscard]] const Followed* followed(EntityId entity) const;

    /// The client follows this from now on, until something of the present stream comes to it.
    void follow(const Followed& what);

    /// As Replicator::unacknowledged().
    Tick unacknowledged(std::vector<mailbox::AuditUpdate>& out) const;

    void hash(core::StateHash& hash) const;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(client, subscriptions, removals, own, tokens, packet_tick, widened, widened_tick);
        archive(is_viewer, coded_bytes, demand, followed_, log_, next_sequence_, first_sequence_);
        archive(oldest_open_, newest_acked_, ack_delay_, loss_, rtt_us_);
        archive(rtt_variation_us_, reached_);
        archive(rate_bytes_per_s_, next_stamp_, next_epoch_, away_, heard_while_away_);
        archive(heard_newest_, heard_tick_, heard_loss_);
    }

    /// The coder, which follows the rest: it is made with the settings.
    template <class Archive>
    void serialize_coder(Archive& archive, const ReplicationSettings& settings) {
        bool coded = coder != nullptr;
        archive(coded);
        if constexpr (Archive::kReads) {
            const std::uint8_t next_epoch = next_epoch_;
            code(coded, settings);
            next_epoch_ = next_epoch;
        }
        if (coded) {
            archive(*coder);
        }
    }

    /// Whether its lists are in order and name streams that there are.
    [[nodiscard]] bool is_sound(const StreamTable& streams) const;

    ClientId client;
    std::vector<Subscription> subscriptions;  ///< ascending by entity
    std::vector<Removal> removals;            ///< ascending by entity
    OwnTrack own;
    double tokens = 0.0;     ///< bytes that may be sent now; heartbeats may drive them below 0
    Tick packet_tick = -1;   ///< of the newest packet; -1: none yet
    wire::Widened widened;   ///< the bounds that it was last notified of
    Tick widened_tick = 0;   ///< when they were last needed or narrowed
    bool is_viewer = false;  ///< in this tick; only viewers get updates of entities
    /// Codes this client's records for it alone; null: it gets those that all share.
    std::unique_ptr<wire::record::RecordEncoder> coder;
    float coded_bytes = 16.0F;  ///< of a record, as they were of late
    CodecDemand demand;

  private:
    static constexpr double kVaries = 0.125;  ///< of a tick
    static constexpr Tick kTimingTicks = 2;

    Subscription subscribe(const world::Visible& visible,
                           Tick now,
                           bool known,
                           StreamTable& streams);
    void follow_on(const Subscription& left, const StreamTable& streams);
    /// Streams that are not followed any more: the entity is out of interest, or its present stream
    /// has reached the client.
    void forget_followed();
    bool cancel_removal(EntityId entity);
    void add_removal(EntityId entity, Tick now);
    void deliver(const SentEntry& entry);
    void lose(const SentEntry& entry);
    void note_acked(const SentPacket& packet);
    std::uint64_t take_fresh(const mailbox::Acks& acks);
    void note_unreported(std::uint64_t newest);
    void give_up(SentPacket& packet);
    void look_for_outage(Tick now, float tick_s);
    void begin_away();
    void sample_loss(SentPacket& packet, bool lost);
    Subscription* find(const SentEntry& entry);

    std::vector<Followed> followed_;  // ascending by entity
    SentLog log_;
    std::uint64_t next_sequence_ = 1;
    std::uint64_t first_sequence_ = 1;  // sent from here
    std::uint64_t oldest_open_ = 1;     // all packets before it are resolved
    std::uint64_t newest_acked_ = 0;
    std::uint64_t acked_bits_ = 0;  // bit i: of newest_acked_ - i; not saved: none is known then
    AckDelay ack_delay_;
    PathLoss loss_;
    Fates fates_;
    std::uint32_t rtt_us_ = 0;
    std::uint32_t rtt_variation_us_ = 0;
    std::uint32_t rate_bytes_per_s_ = 0;
    std::uint32_t next_stamp_ = 1;
    std::uint8_t next_epoch_ = 0;  // of the coder to come
    bool away_ = false;
    bool reached_ = true;
    bool heard_while_away_ = false;
    std::uint64_t heard_newest_ = 0;  // newest_acked_ when it last rose ...
    Tick heard_tick_ = -1;            // ... when that was; -1: at no time here ...
    PathLoss heard_loss_;             // ... and the loss known then
};

/// Bytes that a client may be sent at once when it has just joined: a second's worth of its budget,
/// but no more than TCP's initial window.
double opening_bytes(const ReplicationSettings& settings);

/// Bytes of budget that may gather while nothing is sent.
double burst_bytes(const ReplicationSettings& settings);

}  // namespace zoned::replication

// Packer: chooses the updates of one client in a tick, by priority within its byte budget, and
// writes the packets.
#pragma once

#include "server/mailbox/messages.h"
#include "server/replication/client_state.h"
#include "server/replication/traffic_meter.h"
#include "shared/wire/packet.h"
#include "shared/wire/traffic.h"

#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace zoned::replication {

/// Bytes that travel with every body: IPv4 and UDP headers, datagram header, seal, transport.
inline constexpr std::size_t kPacketOverheadBytes =
    28 + wire::kDatagramHeaderBytes + wire::kSealTagBytes + wire::kDownTransportBytes;

/// The viewer's own avatar at this tick; `present` is false when the zone has no row for it.
struct OwnNow {
    bool present = false;
    Tick discontinuity_tick = 0;
    wire::OwnState state;
};

class Packer {
  public:
    explicit Packer(const ReplicationSettings& settings)
        : settings_(settings),
          meter_(settings.meter
                     ? std::make_unique<TrafficMeter>(settings.quantization, settings.fields)
                     : nullptr) {}

    /// Of all packets so far; nullptr where nobody asks (ReplicationSettings::meter).
    [[nodiscard]] const wire::TrafficTable* traffic() const {
        return meter_ ? &meter_->table() : nullptr;
    }

    /// Codec::kAuto: time of one more tick for coding, which may gather up to four ticks' worth;
    /// when it is spent, packets carry shared records.
    void allow_coding(const mailbox::CodecPrice& price);

    /// Appends the packets of this tick for one client to `out`: none when nothing is pending.
    void pack(Tick now,
              ZoneId zone,
              const OwnNow& own,
              ClientState& client,
              StreamTable& streams,
              ReplicationReport& report,
              std::vector<mailbox::StatePacket>& out);

    /// The price of coding and the time left for it go on from tick to tick.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(price_, coding_ns_);
    }

  private:
    enum class Reason : std::uint8_t {
        kUpdate,
        kLost,    // all copies were given up
        kRepeat,  // one more copy, because the network loses packets
    };

    struct PacketCandidate {
        float score = 0.0F;
        std::uint32_t index = 0;           // in removals or subscriptions
        std::uint32_t declared_bytes = 0;  // of the fields that go along
        bool removal = false;
        Reason reason = Reason::kUpdate;
    };

    void gather(Tick now, ClientState& client, const StreamTable& streams);
    void sort_candidates();
    void order_by_error(Tick now, const ClientState& client, const StreamTable& streams);
    void order_unseen_by_distance(const OwnNow& own,
                                  const ClientState& client,
                                  const StreamTable& streams);
    void follow_from_elsewhere(Tick now,
                               const Subscription& s,
                               ClientState& client,
                               const StreamTable& streams) const;
    void widen(Tick now, ClientState& client, const StreamTable& streams);
    static void postpone_all(Tick now, ClientState& client);
    void notify(ClientState& client,
                std::span<mailbox::StatePacket> packets,
                ReplicationReport& report) const;
    bool consider(Tick now,
                  bool update,
                  Delivery& delivery,
                  float weight,
                  PacketCandidate& candidate);
    [[nodiscard]] bool own_due(Tick now, const OwnNow& own, const OwnTrack& track) const;
    void begin(Tick now, ZoneId zone, const wire::OwnState* own);
    void finish(Tick now,
                ClientState& client,
                const StreamTable& streams,
                ReplicationReport& report,
                std::vector<mailbox::StatePacket>& out);
    bool add_coded(Tick now,
                   EntityId entity,
                   const Stream* stream,
                   std::uint32_t declared_bytes,
                   double allowed_bytes,
                   const ClientState& client);
    void finish_coded(Tick now,
                      ClientState& client,
                      const StreamTable& streams,
                      ReplicationReport& report,
                      std::vector<mailbox::StatePacket>& out);
    void send(Tick now,
              ClientState& client,
              ReplicationReport& report,
              std::vector<mailbox::StatePacket>& out);
    [[nodiscard]] static bool fits(std::size_t size, double allowed_bytes);
    bool add(Tick now,
             const PacketCandidate& candidate,
             double allowed_bytes,
             ClientState& client,
             StreamTable& streams,
             ReplicationReport& report);
    void write_records(Tick now,
                       ZoneId zone,
                       ClientState& client,
                       StreamTable& streams,
                       ReplicationReport& report,
                       std::vector<mailbox::StatePacket>& out);

    [[nodiscard]] static wire::TrafficReason reason_of(const PacketCandidate& candidate,
                                                       const Subscription& s,
                                                       const Encoded& encoded,
                                                       const StreamTable& streams);
    void count_coded(const wire::record::RecordFrame& frame);

    ReplicationSettings settings_;
    std::unique_ptr<TrafficMeter> meter_;
    std::vector<PacketCandidate> candidates_;
    std::vector<std::pair<float, PacketCandidate>>
        unseen_;                         // with distance, of one level of detail
    std::vector<std::uint32_t> places_;  // in candidates_, of these
    wire::DownHead head_;                // of the packet being written, as are body_ and entries_
    std::size_t head_bytes_ = 0;
    std::vector<std::uint8_t> body_;
    std::vector<std::uint8_t> remove_record_;
    std::vector<SentEntry> entries_;
    std::vector<wire::record::CodedRecord> coded_;   // as entries_, for a client with a coder
    std::vector<std::uint32_t> declared_bytes_;      // of the fields of each of these
    std::vector<wire::record::CodedRecord> coding_;  // the records being coded and sent,
    std::vector<SentEntry> coding_entries_;          // its entries,
    std::vector<std::uint32_t> coding_declared_;     // and bytes of fields
    std::vector<std::pair<EntityId, wire::TrafficReason>> reasons_;  // of coded_, for the meter
    mailbox::CodecPrice price_;
    double coding_ns_ = 0.0;  // left for coding
    bool codes_ = false;      // the client being packed for gets coded records
    int copies_wanted_ = 1;
    bool tight_ = false;  // more is to be sent than the budget allows
};

}  // namespace zoned::replication

// ModelClient: the simplest correct client of state packets, the reference for the replicator.
#pragma once

#include "server/world/entity_type.h"
#include "shared/wire/packet.h"
#include "shared/wire/publication.h"
#include "shared/wire/record/record_codec.h"

#include <map>
#include <optional>
#include <tuple>

namespace zoned::replication {

/// Everything is ordered by packet sequence: a record in a newer packet is never older than one in
/// an older packet, whatever the stream, the zone or the network.
class ModelClient {
  public:
    struct Known {
        ZoneId zone;
        std::uint8_t lod = 0;
        TypeIndex type = 0;
        bool upright = false;
        Tick tick = 0;  ///< of the publication
        wire::QuantizedState state;
        motion::KinematicState from;
    };

    ModelClient(const world::TypeTable& types, const wire::Quantization& quantization, float tick_s)
        : types_(&types),
          quantization_(quantization),
          tick_s_(tick_s),
          coded_(wire::record::RecordFormat(quantization, tick_s)) {}

    /// One datagram as it arrives. Duplicates, packets older than the window and packets that can't
    /// be decoded are dropped and not acknowledged.
    void receive(std::uint64_t sequence, std::span<const std::uint8_t> body);

    [[nodiscard]] motion::KinematicState predict(const Known& known, Tick now) const;

    /// Forgets everything but the acks, as a client does that asks for a reset of its view.
    void forget();

    std::map<EntityId, Known> known;
    std::optional<wire::OwnState> own;
    wire::AckTracker acks;
    int undecodable = 0;  ///< deltas that mattered and had no keyframe
    int malformed = 0;
    int undecoded = 0;  ///< packets of coded records, doubled ones among them
    int packets = 0;
    int coded_packets = 0;  ///< of these
    Tick newest_tick = -1;

  private:
    using KeyframeKey = std::tuple<EntityId, ZoneId, std::uint8_t, std::uint8_t>;

    struct Keyframe {
        std::uint64_t sequence = 0;
        wire::QuantizedState state;
        TypeIndex type = 0;
    };

    void read_state(const wire::RecordHead& head,
                    std::uint64_t sequence,
                    const wire::DownHead& down,
                    wire::RecordReader& reader);

    void read_records(std::uint64_t sequence,
                      const wire::DownHead& down,
                      std::span<const std::uint8_t> records);
    void read_coded(std::uint64_t sequence, const wire::record::RecordFrame& frame);
    void remove(EntityId entity, std::uint64_t sequence);

    const world::TypeTable* types_;
    wire::Quantization quantization_;
    float tick_s_;
    wire::record::RecordDecoder coded_;
    std::map<KeyframeKey, Keyframe> keyframes_;
    std::map<EntityId, std::uint64_t> mentioned_;  // sequence of the newest packet that named it
    std::map<EntityId, std::uint64_t> removed_;    // sequence of the newest removal
    std::uint64_t own_sequence_ = 0;
};

}  // namespace zoned::replication

// Capture: the datagrams and events that clients really receive, decoded beside them.
#pragma once

#include "client-sim/link/datagram_channel.h"
#include "client-sim/link/link.h"
#include "shared/core/ids.h"
#include "shared/wire/record/record_codec.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::harness {

/// A record of a state packet.
struct CapturedRecord {
    Tick tick = 0;  ///< of the packet
    EntityId entity;
    bool remove = false;
};

struct CapturedEvent {
    Tick tick = 0;
    std::uint64_t event_id = 0;
    std::uint32_t kind = 0;
    std::string topic;  ///< empty: not by a topic
    std::string payload;
};

/// Everything that one client received so far, from all its streams.
struct Capture {
    ClientId client;
    std::vector<CapturedRecord> records;
    std::vector<CapturedEvent> events;
    std::uint64_t packets = 0;
    std::uint64_t coded_packets = 0;  ///< whose records were coded for this client alone
    std::uint64_t overtaken = 0;      ///< of those, too late for their base: no client reads them
    std::uint64_t undecoded = 0;      ///< datagrams and frames that could not be read: must be none

    // The decoder of later packets.
    link::DatagramChannel channel;
    wire::Quantization quantization;
    float tick_s = 0.0F;
    std::optional<wire::record::RecordDecoder> coded;  // from the first such packet on
    std::uint64_t newest_decoded = 0;
    std::vector<bool> upright;              ///< by type
    std::map<EntityId, TypeIndex> type_of;  ///< from absolute records
    double now_s = 0.0;
};

/// A transport that lets everything through and writes the downlink into `capture`. The caller sets
/// `upright`, `quantization` and `tick_s` of the capture.
std::unique_ptr<link::Transport> capture_transport(std::unique_ptr<link::Transport> inner,
                                                   std::shared_ptr<Capture> capture);

}  // namespace zoned::harness

// Packet layouts: datagram header, transport header and the two bodies (states down, inputs up).
#pragma once

#include "shared/core/ids.h"
#include "shared/core/result.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/input_command.h"
#include "shared/wire/quantize.h"
#include "shared/wire/widening.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::wire {

inline constexpr std::size_t kMaxDatagramBytes = 1200;  ///< the whole UDP payload
inline constexpr std::size_t kDatagramHeaderBytes =
    6;  ///< connection id (4), low 16 bits of the sequence
inline constexpr std::size_t kSealTagBytes = 16;
inline constexpr std::size_t kDownTransportBytes = 12;
inline constexpr std::size_t kUpTransportBytes = 10;
/// Bytes left for the body of a state packet.
inline constexpr std::size_t kMaxDownBodyBytes =
    kMaxDatagramBytes - kDatagramHeaderBytes - kSealTagBytes - kDownTransportBytes;

/// In the clear, little-endian, authenticated as associated data.
struct DatagramHeader {
    std::uint32_t connection =
        0;  ///< identifies the session of a datagram; many sessions may share an address
    std::uint16_t sequence_low = 0;
};

void write_datagram_header(const DatagramHeader& header, std::uint8_t* out6);
core::Result<DatagramHeader> read_datagram_header(std::span<const std::uint8_t> datagram);

/// The sequence nearest to `expected` with these low 16 bits (as RFC 9000, appendix A.3, does for
/// packet numbers).
std::uint64_t expand_sequence(std::uint16_t low, std::uint64_t expected);

/// First bytes inside the seal, server to client. Times are the server clock modulo 2^32
/// microseconds.
struct DownTransport {
    std::uint32_t send_time_us = 0;
    std::uint16_t ack_low =
        0;  ///< newest client datagram received (low bits); equal to own init 0 before any
    std::uint32_t ack_bits = 0;  ///< bit i: ack - 1 - i was received as well
    std::uint16_t ack_delay_10us =
        0;  ///< time from receiving `ack` to sending this, in 10 us, saturating
};

/// First bytes inside the seal, client to server.
struct UpTransport {
    std::uint16_t ack_low = 0;
    std::uint32_t ack_bits = 0;
    std::uint16_t ack_delay_10us = 0;
    /// The client's clock at the arrival of `ack` less the send time in it, in 128 us modulo 2^16:
    /// only differences mean anything. A growing value means a growing queue.
    std::uint16_t one_way_128us = 0;
};

/// UpTransport::one_way_128us of a datagram stamped `send_time_us` that came at `arrival_us`, both
/// modulo 2^32.
constexpr std::uint16_t one_way_128us(std::uint32_t arrival_us, std::uint32_t send_time_us) {
    return static_cast<std::uint16_t>((arrival_us - send_time_us) >> 7U);
}

void write_transport(const DownTransport& t, std::uint8_t* out12);
void write_transport(const UpTransport& t, std::uint8_t* out10);
core::Result<DownTransport> read_down_transport(std::span<const std::uint8_t> plain);
core::Result<UpTransport> read_up_transport(std::span<const std::uint8_t> plain);

/// The set of packets that one side has received: the newest sequence and the 32 before it.
/// Sequences start at 1.
class AckTracker {
  public:
    /// Returns false for a duplicate or one older than the window.
    bool on_received(std::uint64_t sequence);

    [[nodiscard]] std::uint64_t newest() const { return newest_; }

    [[nodiscard]] std::uint32_t bits() const { return bits_; }

  private:
    std::uint64_t newest_ = 0;
    std::uint32_t bits_ = 0;
};

/// The state of the client's own avatar: unquantised enough to reconcile prediction to less than a
/// millimetre.
struct OwnState {
    EntityId avatar;
    Tick input_tick =
        0;  ///< the state holds after this tick's command was consumed (= packet tick)
    bool input_missing =
        false;  ///< the server had no command for that tick and repeated the last one
    std::int8_t input_lead =
        0;  ///< ticks by which the newest command received is ahead of the consumed tick; clamped
    motion::CharacterState state;
};

/// Body of a state packet, server to client: head, optional own state, then records to the end (see
/// publication.h).
struct DownHead {
    Tick tick = 0;  ///< server tick whose state the records extend to; 32 bits on the wire
    ZoneId zone;    ///< the zone whose streams and local coordinates are used
    bool has_own = false;
    bool coded = false;  ///< the records are coded for this client alone, see wire/record
    OwnState own;
    bool has_widened = false;  ///< `widened` is on the wire; without it the bounds are as promised
    Widened widened;
};

/// Appends the head. Position of the own state: float bits; velocity: float bits (it is the
/// prediction's seed).
void write_down_head(const DownHead& head, std::vector<std::uint8_t>& out);
/// Bytes of the head without the own state.
std::size_t down_head_bytes(const DownHead& head);
/// Changes the bounds in a packet with DownHead::has_widened.
void rewrite_widened(const Widened& widened, std::vector<std::uint8_t>& body);

/// Parses the head and returns it with the offset at which records begin.
struct ParsedDownHead {
    DownHead head;
    std::size_t records_offset = 0;
};

core::Result<ParsedDownHead> read_down_head(std::span<const std::uint8_t> body);

/// Body of an input packet, client to server: the newest commands, oldest first, consecutive
/// ticks, 1..8 of them.
inline constexpr std::size_t kMaxCommandsPerPacket = 8;
void write_commands(std::span<const motion::InputCommand> commands, std::vector<std::uint8_t>& out);
/// `commands` is cleared first. Fails on anything that is not exactly a list of 1..8 commands (or
/// an empty body: none).
core::Result<std::size_t> read_commands(std::span<const std::uint8_t> body,
                                        std::vector<motion::InputCommand>& commands);

}  // namespace zoned::wire

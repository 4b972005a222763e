// DatagramChannel: the client's end of the sealed datagrams: sequences, acks, replay window, clock
// samples.
#pragma once

#include "client-sim/link/link.h"
#include "shared/clock/clock_sync.h"
#include "shared/core/ids.h"
#include "shared/wire/packet.h"
#include "shared/wire/seal.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::link {

/// Counts of datagrams so far; nothing is dropped without a count.
struct DatagramStats {
    std::uint64_t in = 0;
    std::uint64_t out = 0;
    std::uint64_t bytes_in = 0;  ///< UDP payload
    std::uint64_t bytes_out = 0;
    std::uint64_t malformed = 0;
    std::uint64_t replayed = 0;         ///< duplicates, or older than the replay window
    std::uint64_t unauthenticated = 0;  ///< forged, damaged, or under the keys of an old stream
    std::uint64_t server_silences = 0;  ///< consecutive packets more than kSilenceS apart at send
};

/// The server's last report on our own datagrams.
struct UplinkUpdate {
    std::uint64_t sequence = 0;     ///< newest that it had received; 0: none yet
    double sent_s = 0.0;            ///< when that one left, local
    double server_receive_s = 0.0;  ///< when it came, by the server's clock
    std::size_t missed_before = 0;  ///< datagrams directly before it that had not come by then
    double loss = 0.0;  ///< share of the datagrams to the server that never came, smoothed
};

/// A state packet as opened; `body` is valid until the next call of open().
struct OpenedPacket {
    std::uint64_t sequence = 0;
    wire::DownHead head;
    std::span<const std::uint8_t> records;
    double server_send_s = 0.0;      ///< when it left, by the server's clock
    std::size_t head_bytes = 0;      ///< of the body, before the records
    std::uint32_t send_time_us = 0;  ///< when it left, as it says
};

class DatagramChannel {
  public:
    /// The server promises at least two datagrams a second; a little more than that is silence.
    static constexpr double kSilenceS = 0.75;

    /// New keys (Welcome on a new stream). Sequences go on: under a new key none is used twice.
    /// False: there is no cryptography for them.
    bool rekey(const wire::SealKey& down, const wire::SealKey& up);
    /// A stream was opened that protects datagrams by itself: they travel as they are.
    void unseal();
    /// A new session: sequences in both directions start again at 1. Call with rekey.
    void restart();
    /// The server crashed and has forgotten its last datagrams: acknowledgements, sequences upward
    /// and the clock begin anew. Those downward go on near where they were. Call after rekey.
    void recover();
    /// A session with another server: nothing of the one before counts. Call after rekey.
    void move();

    void set_connection(std::uint32_t id) { connection_ = id; }

    void set_tick_s(double tick_s) { tick_s_ = tick_s; }

    [[nodiscard]] bool has_keys() const { return down_.has_value(); }

    /// Header, acks and `body`, sealed under the next sequence.
    [[nodiscard]] Bytes seal(std::span<const std::uint8_t> body, double now_s);

    /// Opens a datagram; nullopt (and a count) for anything that is not a fresh, authentic, well
    /// formed state packet. The receiver must acknowledge each packet that it can use.
    std::optional<OpenedPacket> open(std::span<const std::uint8_t> datagram, double now_s);

    /// Tells the server, with the next datagram, that this packet has come. A packet without
    /// acknowledgement is lost to the server: it never builds on it and sends its updates again.
    void acknowledge(const OpenedPacket& packet, double now_s);

    /// Packets acknowledged since the last datagram that said so.
    [[nodiscard]] int unreported() const { return unreported_; }

    [[nodiscard]] const clock::ClockSync& clock() const { return clock_; }

    [[nodiscard]] const UplinkUpdate& uplink() const { return uplink_; }

    /// Of the newest datagram that was sealed; 0: none.
    [[nodiscard]] std::uint64_t newest_up() const { return next_up_ - 1; }

    [[nodiscard]] const DatagramStats& stats() const { return stats_; }

  private:
    void sample_clock(const wire::DownTransport& transport, double server_send_s, double now_s);
    void judge_losses(std::uint64_t acked, std::uint32_t bits);
    void note_silence(std::uint64_t sequence, double server_send_s);

    static constexpr std::size_t kSent = 1024;

    struct SendTime {
        std::uint64_t sequence = 0;
        double at_s = 0.0;
    };

    std::optional<wire::Seal> down_;
    std::optional<wire::Seal> up_;
    std::uint32_t connection_ = 0;
    double tick_s_ = 1.0 / 30.0;
    std::uint64_t next_up_ = 1;
    std::array<SendTime, kSent> sent_{};
    wire::ReplayWindow window_;
    wire::AckTracker acks_;
    double newest_received_s_ = 0.0;
    std::uint16_t newest_one_way_128us_ = 0;
    std::uint64_t last_sampled_ = 0;
    std::uint64_t judged_up_ = 0;  // all up to here are known to have come or not
    UplinkUpdate uplink_;
    std::uint64_t newest_down_ = 0;
    double newest_send_s_ = 0.0;
    clock::ClockSync clock_;
    DatagramStats stats_;
    int unreported_ = 0;
    std::vector<std::uint8_t> plain_out_;
    std::vector<std::uint8_t> plain_in_;
};

}  // namespace zoned::link

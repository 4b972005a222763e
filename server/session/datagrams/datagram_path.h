// DatagramPath: the sealed datagrams of one session: sequences, replay window, acks, round trip.
#pragma once

#include "server/session/datagrams/rate_control.h"
#include "server/session/reject.h"
#include "shared/clock/round_trip.h"
#include "shared/core/result.h"
#include "shared/wire/packet.h"
#include "shared/wire/seal.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::session {

/// Both directions of one session. Sequences continue when the keys change, so that neither side
/// has to start its acks anew.
class DatagramPath {
  public:
    DatagramPath(const wire::SealKey& down, const wire::SealKey& up, const RateSettings& rate);

    /// Takes the keys of a new stream. Datagrams sealed with the old keys no longer open.
    void rekey(const wire::SealKey& down, const wire::SealKey& up);

    /// From now on datagrams travel inside a stream that protects them, without a seal. None that
    /// comes by UDP may be opened.
    void unseal();

    struct Opened {
        bool newest = false;  ///< no datagram with a higher sequence was opened before
        wire::UpTransport transport;
        std::span<const std::uint8_t> body;  ///< within `plain` of open()
    };

    /// Opens a datagram whose header was read already. Only one that authenticates changes
    /// anything. `plain` is the caller's buffer.
    core::Result<Opened, Reject> open(const wire::DatagramHeader& header,
                                      std::span<const std::uint8_t> datagram,
                                      double now_s,
                                      std::vector<std::uint8_t>& plain);

    struct AckUpdate {
        std::uint64_t newest = 0;
        std::uint32_t bits = 0;
    };

    /// The acknowledgements in an opened datagram; nothing when they are not new. Fails when the
    /// datagram acknowledges a packet that was never sent.
    core::Result<std::optional<AckUpdate>, Reject> take_acks(const wire::UpTransport& transport,
                                                             double now_s);

    /// True when `sequence` may be sealed: higher than all before it. A nonce is never used twice.
    [[nodiscard]] bool may_send(std::uint64_t sequence) const { return sequence > last_sent_; }

    /// Replaces `out` by the sealed datagram. Requires may_send(sequence) and a body of at most
    /// wire::kMaxDownBodyBytes. `plain` is the caller's buffer.
    void seal(std::uint32_t connection,
              std::uint64_t sequence,
              std::span<const std::uint8_t> body,
              double now_s,
              double server_time_s,
              std::vector<std::uint8_t>& plain,
              std::vector<std::uint8_t>& out);

    /// The capacity of the path, from the client's reports of arrivals.
    [[nodiscard]] const RateControl& rate() const { return rate_; }

    /// The known acks, again, when the rate fell because the client is silent; else nothing.
    std::optional<AckUpdate> take_silence(double now_s);

    /// This process did not run for so long: the client's silence meanwhile says nothing.
    void excuse_stall(double stall_s) { rate_.excuse_stall(stall_s); }

    /// Smoothed round trip without the client's delay, us; 0 before the first measurement.
    [[nodiscard]] std::uint32_t rtt_us() const {
        return static_cast<std::uint32_t>(1e6 * round_trip_.value().smoothed_s);
    }

    /// Its mean deviation, us.
    [[nodiscard]] std::uint32_t rtt_variation_us() const {
        return static_cast<std::uint32_t>(1e6 * round_trip_.value().variation_s);
    }

  private:
    struct SendTimestamp {
        std::uint64_t sequence = 0;
        double time_s = 0.0;
    };

    /// Send times are kept for the last 256 packets: eight seconds at 30 a second.
    static constexpr std::size_t kSentKept = 256;

    void measure(std::uint64_t sequence, const wire::UpTransport& transport, double now_s);

    wire::Seal down_;
    wire::Seal up_;
    wire::ReplayWindow replay_;
    wire::AckTracker received_;
    double newest_received_s_ = 0.0;
    std::uint64_t last_sent_ = 0;
    std::array<SendTimestamp, kSentKept> sent_{};
    AckUpdate acked_;
    RateControl rate_;
    clock::RoundTripEstimator round_trip_;
    double least_rtt_s_ = 60.0;
};

}  // namespace zoned::session

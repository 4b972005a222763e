#include "server/session/datagrams/datagram_path.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>

namespace zoned::session {

namespace {

constexpr std::size_t kIpUdpBytes = 28;  // as budgets count them

}  // namespace

DatagramPath::DatagramPath(const wire::SealKey& down,
                           const wire::SealKey& up,
                           const RateSettings& rate)
    : down_(down),
      up_(up),
      rate_(rate) {
}

void DatagramPath::rekey(const wire::SealKey& down, const wire::SealKey& up) {
    down_ = wire::Seal(down);
    up_ = wire::Seal(up);
}

void DatagramPath::unseal() {
    down_ = wire::Seal::none();
    up_ = wire::Seal::none();
}

core::Result<DatagramPath::Opened, Reject> DatagramPath::open(
    const wire::DatagramHeader& header,
    std::span<const std::uint8_t> datagram,
    double now_s,
    std::vector<std::uint8_t>& plain) {
    using Out = core::Result<Opened, Reject>;
    const std::uint64_t sequence = wire::expand_sequence(header.sequence_low, replay_.newest() + 1);
    // Sequences start at 1.
    if (sequence == 0 || !replay_.fresh(sequence)) {
        return Out::failure(Reject::kReplayed);
    }
    const auto associated = datagram.first(wire::kDatagramHeaderBytes);
    if (!up_.open(sequence, associated, datagram.subspan(wire::kDatagramHeaderBytes), plain)) {
        return Out::failure(Reject::kNotAuthentic);
    }
    Opened opened;
    opened.newest = sequence > replay_.newest();
    replay_.mark(sequence);
    received_.on_received(sequence);
    if (opened.newest) {
        newest_received_s_ = now_s;
    }
    const auto transport = wire::read_up_transport(plain);
    if (!transport) {
        return Out::failure(Reject::kTransportMalformed);
    }
    opened.transport = *transport;
    opened.body = std::span<const std::uint8_t>(plain).subspan(wire::kUpTransportBytes);
    return opened;
}

core::Result<std::optional<DatagramPath::AckUpdate>, Reject> DatagramPath::take_acks(
    const wire::UpTransport& transport,
    double now_s) {
    using Out = core::Result<std::optional<AckUpdate>, Reject>;
    if (transport.ack_low == 0 && transport.ack_bits == 0) {
        return std::optional<AckUpdate>();  // the client has received nothing yet
    }
    const std::uint64_t newest = wire::expand_sequence(transport.ack_low, last_sent_);
    if (newest == 0 || newest > last_sent_) {
        return Out::failure(Reject::kAckAhead);
    }
    // Bit i speaks of newest - 1 - i, and there is nothing before sequence 1.
    const std::uint32_t bits = newest > 32
                                   ? transport.ack_bits
                                   : transport.ack_bits & ((std::uint32_t{1} << (newest - 1)) - 1);
    if (newest < acked_.newest || (newest == acked_.newest && bits == acked_.bits)) {
        return std::optional<AckUpdate>();  // overtaken by a later datagram, or a repetition
    }
    if (newest > acked_.newest) {
        measure(newest, transport, now_s);
    }
    rate_.on_feedback(newest, bits, transport.one_way_128us, round_trip_.value().smoothed_s, now_s);
    acked_ = {newest, bits};
    return std::optional<AckUpdate>(acked_);
}

std::optional<DatagramPath::AckUpdate> DatagramPath::take_silence(double now_s) {
    return rate_.on_silence(now_s) ? std::optional<AckUpdate>(acked_) : std::nullopt;
}

void DatagramPath::measure(std::uint64_t sequence,
                           const wire::UpTransport& transport,
                           double now_s) {
    const SendTimestamp& sent = sent_[sequence % kSentKept];
    if (sent.sequence != sequence) {
        return;  // too long ago to know
    }
    // RFC 9002, section 5.3: the client's delay is not the path's, but no client can make the round
    // trip shorter than the shortest seen.
    const double whole_s = std::clamp(now_s - sent.time_s, 1e-6, 60.0);
    const double delay_s = 1e-5 * transport.ack_delay_10us;
    least_rtt_s_ = std::min(least_rtt_s_, whole_s);
    round_trip_.add(whole_s >= least_rtt_s_ + delay_s ? whole_s - delay_s : whole_s, now_s);
}

void DatagramPath::seal(std::uint32_t connection,
                        std::uint64_t sequence,
                        std::span<const std::uint8_t> body,
                        double now_s,
                        double server_time_s,
                        std::vector<std::uint8_t>& plain,
                        std::vector<std::uint8_t>& out) {
    ZONED_ASSERT(may_send(sequence), "a sequence would be sealed twice");
    ZONED_ASSERT(body.size() <= wire::kMaxDownBodyBytes, "a state packet's body is too long");
    wire::DownTransport transport;
    transport.send_time_us = static_cast<std::uint32_t>(
        static_cast<std::uint64_t>(std::llround(server_time_s * 1e6)));  // modulo 2^32 on purpose
    if (received_.newest() != 0) {
        transport.ack_low = static_cast<std::uint16_t>(received_.newest());
        transport.ack_bits = received_.bits();
        const double delay_10us = std::max(0.0, (now_s - newest_received_s_) * 1e5);
        transport.ack_delay_10us = static_cast<std::uint16_t>(std::min(65535.0, delay_10us));
    }
    plain.resize(wire::kDownTransportBytes);
    wire::write_transport(transport, plain.data());
    plain.insert(plain.end(), body.begin(), body.end());

    out.resize(wire::kDatagramHeaderBytes);
    wire::write_datagram_header({connection, static_cast<std::uint16_t>(sequence)}, out.data());
    std::array<std::uint8_t, wire::kDatagramHeaderBytes> associated{};
    std::copy_n(out.begin(), associated.size(), associated.begin());
    down_.seal(sequence, associated, plain, out);
    last_sent_ = sequence;
    sent_[sequence % kSentKept] = {sequence, now_s};
    rate_.on_sent(sequence, out.size() + kIpUdpBytes, now_s, transport.send_time_us);
}

}  // namespace zoned::session

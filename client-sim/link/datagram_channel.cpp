#include "client-sim/link/datagram_channel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace zoned::link {

namespace {

constexpr double kAckDelayUnitS = 10e-6;
constexpr std::uint16_t kAckDelaySaturated = 0xFFFF;
// A datagram overtaken by this many counts as lost.
constexpr std::uint64_t kOvertaken = 8;
constexpr double kLossWeight = 1.0 / 128.0;

/// The server sends its clock modulo 2^32 microseconds; the packet's tick gives the number of
/// turns.
double unwrap_send_time_s(std::uint32_t send_time_us, Tick tick, double tick_s) {
    const double nominal_us = std::floor(static_cast<double>(tick) * tick_s * 1e6);
    const auto low = static_cast<std::uint32_t>(static_cast<std::uint64_t>(nominal_us));
    const auto difference = static_cast<std::int32_t>(send_time_us - low);
    return (nominal_us + static_cast<double>(difference)) * 1e-6;
}

}  // namespace

bool DatagramChannel::rekey(const wire::SealKey& down, const wire::SealKey& up) {
    down_.emplace(down);
    up_.emplace(up);
    return down_->usable() && up_->usable();
}

void DatagramChannel::unseal() {
    down_.emplace(wire::Seal::none());
    up_.emplace(wire::Seal::none());
}

void DatagramChannel::restart() {
    next_up_ = 1;
    sent_.fill({});
    window_ = {};
    acks_ = {};
    last_sampled_ = 0;
    judged_up_ = 0;
    uplink_ = {};
    newest_down_ = 0;
    unreported_ = 0;
}

void DatagramChannel::recover() {
    const std::uint64_t near = newest_down_;
    restart();
    newest_down_ = near;
    newest_send_s_ = std::numeric_limits<double>::infinity();  // its time before is no silence
    clock_ = {};
}

void DatagramChannel::move() {
    restart();
    newest_send_s_ = std::numeric_limits<double>::infinity();
    clock_ = {};
}

Bytes DatagramChannel::seal(std::span<const std::uint8_t> body, double now_s) {
    const std::uint64_t sequence = next_up_++;
    sent_[sequence % kSent] = {sequence, now_s};
    unreported_ = 0;
    wire::UpTransport transport;
    transport.ack_low = static_cast<std::uint16_t>(acks_.newest());
    transport.ack_bits = acks_.bits();
    const double delay = (now_s - newest_received_s_) / kAckDelayUnitS;
    transport.ack_delay_10us =
        static_cast<std::uint16_t>(std::clamp(delay, 0.0, static_cast<double>(kAckDelaySaturated)));
    transport.one_way_128us = newest_one_way_128us_;
    plain_out_.resize(wire::kUpTransportBytes);
    wire::write_transport(transport, plain_out_.data());
    plain_out_.insert(plain_out_.end(), body.begin(), body.end());

    Bytes datagram;
    datagram.reserve(wire::kDatagramHeaderBytes + plain_out_.size() + wire::kSealTagBytes);
    datagram.resize(wire::kDatagramHeaderBytes);
    wire::write_datagram_header({connection_, static_cast<std::uint16_t>(sequence)},
                                datagram.data());
    std::array<std::uint8_t, wire::kDatagramHeaderBytes> header{};
    std::copy_n(datagram.begin(), header.size(), header.begin());
    up_->seal(sequence, header, plain_out_, datagram);
    ++stats_.out;
    stats_.bytes_out += datagram.size();
    return datagram;
}

std::optional<OpenedPacket> DatagramChannel::open(std::span<const std::uint8_t> datagram,
                                                  double now_s) {
    ++stats_.in;
    stats_.bytes_in += datagram.size();
    const auto header = wire::read_datagram_header(datagram);
    if (!header || header->connection != connection_ || !down_ ||
        datagram.size() > wire::kMaxDatagramBytes) {
        ++stats_.malformed;
        return std::nullopt;
    }
    const std::uint64_t newest = window_.newest() != 0 ? window_.newest() : newest_down_;
    const std::uint64_t sequence = wire::expand_sequence(header->sequence_low, newest + 1);
    if (!window_.fresh(sequence)) {
        ++stats_.replayed;
        return std::nullopt;
    }
    if (!down_->open(sequence,
                     datagram.first(wire::kDatagramHeaderBytes),
                     datagram.subspan(wire::kDatagramHeaderBytes),
                     plain_in_)) {
        ++stats_.unauthenticated;
        return std::nullopt;
    }
    window_.mark(sequence);
    const std::span<const std::uint8_t> plain(plain_in_);
    const auto transport = wire::read_down_transport(plain);
    if (!transport) {
        ++stats_.malformed;
        return std::nullopt;
    }
    const auto body = plain.subspan(wire::kDownTransportBytes);
    const auto head = wire::read_down_head(body);
    // A tick beyond 2^40 (a thousand years) is nonsense that would only upset the arithmetic.
    if (!head || head->head.tick < 0 || head->head.tick > (Tick{1} << 40)) {
        ++stats_.malformed;
        return std::nullopt;
    }
    const double server_send_s =
        unwrap_send_time_s(transport->send_time_us, head->head.tick, tick_s_);
    sample_clock(*transport, server_send_s, now_s);
    note_silence(sequence, server_send_s);
    return OpenedPacket{sequence,
                        head->head,
                        body.subspan(head->records_offset),
                        server_send_s,
                        head->records_offset,
                        transport->send_time_us};
}

void DatagramChannel::acknowledge(const OpenedPacket& packet, double now_s) {
    acks_.on_received(packet.sequence);
    ++unreported_;
    if (acks_.newest() == packet.sequence) {
        newest_received_s_ = now_s;
        // Any clock will do, as long as it goes on: the server looks at differences only.
        const auto now_us = static_cast<std::uint32_t>(
            static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(now_s * 1e6))));
        newest_one_way_128us_ = wire::one_way_128us(now_us, packet.send_time_us);
    }
}

void DatagramChannel::sample_clock(const wire::DownTransport& transport,
                                   double server_send_s,
                                   double now_s) {
    const std::uint64_t acked = wire::expand_sequence(transport.ack_low, next_up_ - 1);
    if (acked != 0 && acked < next_up_) {
        judge_losses(acked, transport.ack_bits);
    }
    // Each of our datagrams serves as a sample once; a saturated delay says nothing.
    if (acked == 0 || acked <= last_sampled_ || acked >= next_up_ ||
        transport.ack_delay_10us == kAckDelaySaturated) {
        return;
    }
    const SendTime& sent = sent_[acked % kSent];
    if (sent.sequence != acked) {
        return;
    }
    last_sampled_ = acked;
    const double server_receive_s =
        server_send_s - static_cast<double>(transport.ack_delay_10us) * kAckDelayUnitS;
    clock_.add_sample(sent.at_s, server_receive_s, server_send_s, now_s);
    uplink_.sequence = acked;
    uplink_.sent_s = sent.at_s;
    uplink_.server_receive_s = server_receive_s;
    uplink_.missed_before = std::min(static_cast<std::size_t>(std::countr_zero(transport.ack_bits)),
                                     static_cast<std::size_t>(acked - 1));
}

void DatagramChannel::judge_losses(std::uint64_t acked, std::uint32_t bits) {
    // After a silence the bits do not reach back to all: what they do not cover says nothing.
    judged_up_ = std::max(judged_up_, acked > 32 ? acked - 33 : 0);
    for (; judged_up_ + 1 + kOvertaken <= acked; ++judged_up_) {
        const std::uint64_t back = acked - (judged_up_ + 1);
        const bool came = ((bits >> (back - 1)) & 1U) != 0;
        uplink_.loss += kLossWeight * ((came ? 0.0 : 1.0) - uplink_.loss);
    }
}

void DatagramChannel::note_silence(std::uint64_t sequence, double server_send_s) {
    // Judged by the server's own stamps of packets with consecutive sequences: neither loss nor a
    // stall of this process looks like a silent server.
    if (sequence == newest_down_ + 1 && newest_down_ != 0 &&
        server_send_s - newest_send_s_ > kSilenceS) {
        ++stats_.server_silences;
    }
    if (sequence > newest_down_) {
        newest_down_ = sequence;
        newest_send_s_ = server_send_s;
    }
}

}  // namespace zoned::link

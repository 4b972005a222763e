#include "server/session/host/host_impl.h"

#include <algorithm>
#include <iterator>

namespace zoned::session {

namespace {

/// Of one session among datagrams that waited together; jitter brings two.
constexpr int kReadPerTurn = 3;

/// Harnesses without sockets name no peer.
bool is_known(const mailbox::Address& peer) {
    return peer.port != 0;
}

bool same_host(const mailbox::Address& a, const mailbox::Address& b) {
    return std::equal(std::begin(a.ip), std::end(a.ip), std::begin(b.ip));
}

}  // namespace

// Before a datagram authenticates, nothing is answered and nothing but a counter changes: else the
// server could be used against others, or a session taken over by guessing.
void SessionHost::Impl::on_datagram(const mailbox::Address* from,
                                    const Session* carrier,
                                    std::span<const std::uint8_t> datagram,
                                    double now_s,
                                    double arrived_s) {
    if (datagram.size() > wire::kMaxDatagramBytes) {
        reject(Reject::kDatagramLong);
        return;
    }
    const auto header = wire::read_datagram_header(datagram);
    if (!header) {
        reject(Reject::kDatagramShort);
        return;
    }
    Session* session = table.by_connection(header->connection);
    if (session == nullptr) {
        reject(Reject::kConnectionUnknown);
        return;
    }
    if (from == nullptr && session != carrier) {
        reject(Reject::kConnectionForeign);
        return;
    }
    if (from != nullptr && session->inside_stream) {
        reject(Reject::kNotAuthentic);  // nothing would prove its sender
        return;
    }
    const bool waited = from != nullptr && datagram_turn != 0;
    if (waited && session->datagram_turn == datagram_turn &&
        session->datagrams_in_turn >= kReadPerTurn + gathered_s * settings.max_datagrams_per_s) {
        reject(Reject::kDatagramOvertaken);
        return;
    }
    const auto opened = session->path.open(*header, datagram, arrived_s, plain);
    if (!opened) {
        reject(opened.error());
        return;
    }
    if (waited) {
        session->datagrams_in_turn =
            session->datagram_turn == datagram_turn ? session->datagrams_in_turn + 1 : 1;
        session->datagram_turn = datagram_turn;
    }
    session->last_heard_s = now_s;
    session->last_datagram_s = now_s;
    session->bytes_in += datagram.size();
    if (opened->newest) {
        follow_address(*session, from, datagram.size());
    }
    look_at_reach(*session, now_s);
    if (!session->datagrams.take(now_s)) {
        reject(Reject::kDatagramFlood);
        return;
    }
    if (opened->newest) {
        // An older datagram says less of our packets than the newest has said already.
        const auto acks = session->path.take_acks(opened->transport, arrived_s);
        if (!acks) {
            reject(acks.error());
        } else if (*acks) {
            session->address_proof.acknowledge((*acks)->newest);
            send_acks(*session, **acks);
        }
    }
    on_body(*session, opened->body);
}

void SessionHost::Impl::send_acks(const Session& session, const DatagramPath::AckUpdate& acks) {
    const double rate = std::min(session.path.rate().bytes_per_s(), overload.ceiling());
    output.to_zones(mailbox::Acks{session.client,
                                  acks.newest,
                                  acks.bits,
                                  session.path.rtt_us(),
                                  static_cast<std::uint32_t>(rate),
                                  session.path.rtt_variation_us()});
}

void SessionHost::Impl::follow_address(Session& session,
                                       const mailbox::Address* from,
                                       std::size_t bytes) {
    const Route before = session.route;
    session.route = from == nullptr ? Route::kStream : Route::kAddress;
    if (session.route != before && !session.unanswered) {
        session.unanswered = session.route;
    }
    if (from == nullptr) {
        return;
    }
    if (!session.has_address || session.address != *from) {
        stats.address_changes += session.has_address ? 1 : 0;
        session.address_proof.begin(!is_known(session.peer) || same_host(*from, session.peer));
        session.address = *from;
        session.has_address = true;
    }
    session.address_proof.take(bytes);
}

void SessionHost::Impl::on_body(Session& session, std::span<const std::uint8_t> body) {
    const auto parsed = wire::read_commands(body, commands);
    if (!parsed) {
        reject(Reject::kBodyMalformed);
        return;
    }
    mailbox::Input input;
    session.gate.filter(
        commands, current_tick, settings.input_window_ticks, rejects, input.commands);
    if (!input.commands.empty()) {
        input.client = session.client;
        output.to_zones(std::move(input));
    }
}

}  // namespace zoned::session

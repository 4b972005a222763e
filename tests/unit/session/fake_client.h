// FakeClient: a small client, with a host on virtual time whose whole output is collected.
#pragma once

#include "server/session/host/session_host.h"
#include "server/session/login/ticket.h"
#include "proto/session.pb.h"
#include "shared/wire/packet.h"
#include "shared/wire/seal.h"

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace zoned::session {

struct SentDatagram {
    mailbox::Address to;
    Bytes bytes;
};

inline mailbox::Address test_address(std::uint16_t port) {
    mailbox::Address address;
    address.ip[15] = 1;
    address.port = port;
    return address;
}

/// Settings that let loopback in, with the rights of a player.
inline HostSettings dev_settings() {
    HostSettings settings;
    settings.dev_mode_loopback = true;
    settings.config_digest = "c0ffee";
    settings.world.set_tick_rate_hz(30.0);
    return settings;
}

class TestHost {
  public:
    explicit TestHost(HostSettings settings,
                      std::function<void(const SessionNote&)> note = {},
                      std::function<void(const LoginToStore&)> store_login = {})
        : host(std::move(settings),
               SessionOutput{[this](StreamId s, Bytes f) {
                                 proto::ServerMessage m;
                                 ok = ok &&
                                      m.ParseFromArray(f.data(), static_cast<int>(f.size())) &&
                                      closed.count(s) == 0;
                                 frames[s].push_back(std::move(m));
                             },
                             [this](StreamId s) { ok = ok && closed.insert(s).second; },
                             [this](const mailbox::Address& to, Bytes d) {
                                 datagrams.push_back({to, d});
                                 host.recycle(std::move(d));
                             },
                             [this](mailbox::InboxItem item) { inbox.push_back(std::move(item)); },
                             [this](StreamId) { return backlog; },
                             {},
                             std::move(note),
                             std::move(store_login)}) {}

    /// `spent_s`: how long ago the client connected.
    StreamId open(bool loopback = true, double spent_s = 0.0) {
        const StreamId stream{++last_stream};
        host.on_stream_open(stream, loopback, now_s - spent_s);
        return stream;
    }

    void send(StreamId stream, const proto::ClientMessage& message) {
        const std::string bytes = message.SerializeAsString();
        host.on_frame(
            stream, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, now_s);
    }

    /// Moves time on, with the host's tick at 30 Hz.
    void advance(double seconds) {
        const double end = now_s + seconds;
        while (now_s < end) {
            now_s += 1.0 / 30.0;
            host.tick(now_s, ++tick);
        }
    }

    std::uint64_t rejected(const std::string& reason) {
        const auto& map = host.stats().rejected;
        const auto it = map.find(reason);
        return it == map.end() ? 0 : it->second;
    }

    template <class T>
    std::vector<T> take() {
        std::vector<T> out;
        std::vector<mailbox::InboxItem> rest;
        for (auto& item : inbox) {
            if (auto* t = std::get_if<T>(&item)) {
                out.push_back(std::move(*t));
            } else {
                rest.push_back(std::move(item));
            }
        }
        inbox = std::move(rest);
        return out;
    }

    void emit(const std::vector<ClientId>& to, const std::string& payload, bool confirm = false) {
        mailbox::EventOut event;
        event.event = EventId{++last_event};
        event.tick = tick;
        event.kind = 16;
        event.confirm = confirm;
        event.payload.assign(payload.begin(), payload.end());
        event.recipients = to;
        host.on_outbox(event, now_s, now_s);
    }

    double now_s = 1000.0;
    Tick tick = 100;
    std::size_t backlog = 0;
    std::uint64_t last_stream = 0;
    std::uint64_t last_event = 0;
    bool ok = true;  ///< every frame could be parsed, none came after the end of its stream
    std::map<StreamId, std::deque<proto::ServerMessage>> frames;
    std::set<StreamId> closed;
    std::vector<SentDatagram> datagrams;
    std::vector<mailbox::InboxItem> inbox;
    SessionHost host;
};

inline proto::ClientMessage hello_message(const std::string& name = "ann") {
    proto::ClientMessage message;
    message.mutable_hello()->set_protocol_version(HostSettings{}.protocol_version);
    message.mutable_hello()->set_name(name);
    return message;
}

inline proto::ClientMessage command_message(std::uint64_t number,
                                            const std::string& payload,
                                            std::uint32_t kind = 5) {
    proto::ClientMessage message;
    message.mutable_command()->set_number(number);
    message.mutable_command()->set_kind(kind);
    message.mutable_command()->set_payload(payload);
    return message;
}

inline std::vector<motion::InputCommand> commands_at(Tick first, int count) {
    std::vector<motion::InputCommand> out;
    for (int i = 0; i < count; ++i) {
        motion::InputCommand command;
        command.tick = first + i;
        command.move_x = 100;
        out.push_back(command);
    }
    return out;
}

/// One client. It acts only when a test asks; it keeps the sequence and keys of its datagrams.
class FakeClient {
  public:
    explicit FakeClient(TestHost& host) : host_(&host) {}

    std::optional<mailbox::Address> peer;  ///< of its streams; none: the host knows none

    /// Opens a stream, says hello and takes the answer. False when refused.
    bool log_in(proto::ClientMessage hello = hello_message(), bool loopback = true) {
        stream = host_->open(loopback);
        if (peer) {
            host_->host.set_peer(stream, *peer);
        }
        host_->send(stream, hello);
        auto& queue = host_->frames[stream];
        if (queue.empty()) {
            return false;
        }
        answer = queue.front();
        queue.pop_front();
        if (!answer.has_welcome()) {
            return false;
        }
        client = ClientId{answer.welcome().client_id()};
        connection = answer.welcome().connection_id();
        token = answer.welcome().resume_token();
        up_key = wire::SealKey::from(answer.welcome().datagram_key_up()).value();
        up.emplace(up_key);
        down.emplace(wire::SealKey::from(answer.welcome().datagram_key_down()).value());
        return true;
    }

    bool resume(std::uint64_t last_event) {
        proto::ClientMessage hello = hello_message();
        hello.mutable_hello()->set_resume_token(token);
        hello.mutable_hello()->set_last_event(last_event);
        return log_in(hello);
    }

    void drop() { host_->host.on_stream_closed(stream, host_->now_s); }

    Bytes make_datagram(std::uint64_t at_sequence,
                        const std::vector<motion::InputCommand>& commands,
                        wire::UpTransport transport = {}) {
        Bytes plain(wire::kUpTransportBytes);
        wire::write_transport(transport, plain.data());
        if (!commands.empty()) {
            wire::write_commands(commands, plain);
        }
        return seal(at_sequence, plain);
    }

    Bytes seal(std::uint64_t at_sequence, const Bytes& plain) {
        Bytes out(wire::kDatagramHeaderBytes);
        wire::write_datagram_header({connection, static_cast<std::uint16_t>(at_sequence)},
                                    out.data());
        const Bytes associated = out;
        up->seal(at_sequence, associated, plain, out);
        return out;
    }

    void send_datagram(const std::vector<motion::InputCommand>& commands,
                       std::uint16_t port = 1,
                       wire::UpTransport transport = {}) {
        host_->host.on_datagram(
            test_address(port), make_datagram(++sequence, commands, transport), host_->now_s);
    }

    void state(std::uint64_t at_sequence, std::size_t body_bytes = 20) {
        host_->host.on_outbox(mailbox::StatePacket{client, at_sequence, Bytes(body_bytes, 7)},
                              host_->now_s,
                              host_->now_s);
    }

    /// Opens a state packet; nothing when it does not authenticate.
    std::optional<wire::DownTransport> open(const Bytes& datagram, std::uint64_t at_sequence) {
        Bytes plain;
        const std::span<const std::uint8_t> all = datagram;
        if (!down->open(at_sequence,
                        all.first(wire::kDatagramHeaderBytes),
                        all.subspan(wire::kDatagramHeaderBytes),
                        plain)) {
            return std::nullopt;
        }
        return *wire::read_down_transport(plain);
    }

    StreamId stream;
    ClientId client;
    std::uint32_t connection = 0;
    std::string token;
    std::uint64_t sequence = 0;
    proto::ServerMessage answer;
    std::optional<wire::Seal> down;
    std::optional<wire::Seal> up;
    wire::SealKey up_key;  ///< of the newest stream with keys

  private:
    TestHost* host_;
};

}  // namespace zoned::session

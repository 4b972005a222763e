// FakeServer: a small truthful server for one client on virtual time, with faults on request.
#pragma once

#include "client-sim/link/conditioner.h"
#include "client-sim/link/link.h"
#include "client-sim/view/world_info.h"
#include "tests/harness/received.h"
#include "proto/session.pb.h"
#include "shared/motion/apply_input.h"
#include "shared/wire/packet.h"
#include "shared/wire/publication.h"
#include "shared/wire/seal.h"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace zoned::test {

/// An entity that moves with constant velocity until a test changes it.
struct FakeEntity {
    motion::KinematicState truth;
    Tick published_tick = -1;
    motion::KinematicState published;
    Tick breach_tick = 0;
    Tick discontinuity_tick = 1;
    Tick radii_tick = 0;              ///< its stance changed its radii last
    bool hidden_from_client = false;  ///< not sent, though audits list it
    bool leaked = false;              ///< sent, though audits do not list it
    Vec3 lie = Vec3::Zero();          ///< added to the published position
    std::uint64_t removed_sequence = 0;
    bool postponed = false;  ///< audits say that the budget made it wait
    bool sent = false;
};

/// Both the transport and the server behind it. Call advance(now) before the client's advance.
class FakeServer final : public link::Transport {
  public:
    explicit FakeServer(const link::ConditionerSettings& path = {});

    void set_events(link::TransportEvents events) override { events_ = std::move(events); }

    void open() override;
    void send_frame(link::Bytes frame) override;

    void set_udp(std::uint16_t, std::uint32_t) override {}

    void send_datagram(link::Bytes datagram) override;
    void close() override;

    void prepare(const std::string& host,
                 std::uint16_t port,
                 const std::string& certificate_sha256) override {
        preparations.push_back(host + ":" + std::to_string(port) + "/" + certificate_sha256);
    }

    /// Another server, which knows no session yet: this one plays it.
    bool redirect(const std::string& host,
                  std::uint16_t port,
                  const std::string& certificate_sha256) override {
        redirects.push_back(host + ":" + std::to_string(port) + "/" + certificate_sha256);
        session_ = false;
        return takes_redirects;
    }

    /// Runs ticks and delivers due messages.
    void advance(double now_s);
    /// Cuts the stream; the client learns of it at once.
    void cut();

    void send_event(std::uint64_t event_id, bool confirm = false, const std::string& topic = {});
    void send_raw_event(std::uint64_t number, std::uint64_t event_id);
    void send(const proto::ServerMessage& message);
    void send_audit();
    void send_raw_datagram(link::Bytes datagram);

    void send_raw_frame(link::Bytes frame) { down_frames_.push(now_s_, std::move(frame)); }

    /// Seals a body as the next state packet.
    link::Bytes seal_packet(const std::vector<std::uint8_t>& body);

    [[nodiscard]] proto::WorldDescription world() const;

    static constexpr double kTickS = 1.0 / 30.0;
    /// The server's clock is this much ahead of the test's.
    static constexpr double kClockOffsetS = 100.0;
    static constexpr std::uint32_t kConnection = 77;
    static constexpr std::uint32_t kAvatar = 9000;

    std::map<std::uint32_t, FakeEntity> entities;
    Tick tick = 0;
    bool accept_resume = true;
    bool refuse = false;
    bool udp_blocked = false;
    bool websocket = false;  ///< streams carry datagrams as they are, and there is no UDP
    bool keyless = false;    ///< Welcome has a key for one direction alone
    bool stalled = false;
    /// Stands still: nothing is read, sent or ticked, and its clock loses the time, as that of a
    /// server does that drops the ticks of a stall.
    bool stopped = false;
    bool frozen = false;
    bool states = true;
    wire::Widened widened;  ///< sent in every packet
    bool sparks = false;    ///< the world has cosmetic particles that events let out
    std::uint32_t rights = 7;
    bool audit_on_request = true;
    std::vector<proto::ClientMessage> received;
    std::map<std::uint64_t, std::string> commands;  ///< by number, as carried out
    std::uint64_t acked_events = 0;
    std::set<std::uint64_t> confirmed;
    int opens = 0;
    int input_packets = 0;
    int tunnelled_packets = 0;
    std::optional<motion::CharacterState> avatar;
    bool ack_commands = true;
    std::vector<std::string> redirects;
    std::vector<std::string> preparations;
    bool takes_redirects = true;
    bool refuse_elsewhere = false;  ///< each login is sent to another server

  private:
    void step(double now_s);

    [[nodiscard]] double clock_s() const { return now_s_ + kClockOffsetS - stopped_s_; }

    void publish(std::vector<std::uint8_t>& body);
    void on_frame(const link::Bytes& frame);
    void on_datagram(const link::Bytes& datagram, bool tunnel);
    void hello(const proto::Hello& hello);

    link::TransportEvents events_;
    link::Conditioner up_datagrams_;
    link::Conditioner down_datagrams_;
    link::Conditioner up_frames_;
    link::Conditioner down_frames_;
    bool stream_ = false;
    bool opening_ = false;
    bool session_ = false;
    double now_s_ = 0.0;
    double stopped_s_ = 0.0;  // in all
    std::uint64_t key_turn_ = 0;
    std::optional<wire::Seal> down_;
    std::optional<wire::Seal> up_;
    std::uint64_t next_sequence_ = 1;
    wire::ReplayWindow replay_;
    wire::AckTracker acks_;
    double newest_received_s_ = 0.0;
    std::vector<proto::Event> sent_events_;
    std::map<Tick, motion::InputCommand> inputs_;
    motion::InputCommand last_input_;
    Tick first_tick_ = 0;
    std::uint64_t last_command_ = 0;
    std::uint8_t keyframe_ = 0;
    bool tunnel_ = false;
};

/// A client's reading of a description that a server sent.
inline core::Result<view::WorldInfo> read_world(const proto::WorldDescription& sent) {
    return view::read_world(received<wire::WorldDescriptionMessage>(sent));
}

}  // namespace zoned::test

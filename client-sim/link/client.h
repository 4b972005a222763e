// Client: the session logic of one client over a Transport: login, resume, events, commands and
// datagrams; the time is passed in.
#pragma once

#include "client-sim/link/datagram_channel.h"
#include "client-sim/link/event_inbox.h"
#include "client-sim/link/link.h"

#include <cstdint>
#include <list>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::link {

inline constexpr std::uint32_t kProtocolVersion = 8;

/// The login of a client. `ticket` is a serialised Ticket (proto/session.proto) or empty (a server
/// in development mode).
struct Login {
    std::string name = "bot";
    std::string team;
    std::string ticket;
    std::string config_digest;  ///< hex; empty: any config of the server
    std::string world = {};     ///< of a cluster; empty: the server's
};

/// Receives the messages of the session, in order, from within Client::advance only.
class SessionHandler {
  public:
    virtual ~SessionHandler() = default;
    /// A session began, or came back (`welcome.resumed`, without a world then). A server that
    /// crashed in between (`welcome.recovered`) has forgotten its last packets: the view begins
    /// anew.
    virtual void on_welcome(const wire::WelcomeMessage& welcome) = 0;
    virtual void on_joined(const wire::JoinedMessage& joined) = 0;
    /// Exactly once and in order. Confirmation, where asked for, has been sent.
    virtual void on_event(const wire::EventMessage& event) = 0;
    virtual void on_audit(const wire::AuditRecordMessage& record) = 0;
    /// False: the packet could not be read, and must count as lost (WIRE.md, section 4a).
    virtual bool on_packet(const OpenedPacket& packet) = 0;
};

enum class SessionState : std::uint8_t {
    kIdle,        ///< start() was not called
    kConnecting,  ///< waiting for the stream or for Welcome
    kOnline,
    kWaiting,  ///< the stream was lost; the next attempt is scheduled
    kClosed,   ///< for good: quit, refused, closed by the server or unreachable
};

struct SessionStats {
    std::uint64_t frames_in = 0;
    std::uint64_t frames_out = 0;
    std::uint64_t frame_bytes_in = 0;  ///< with the 4-byte length, without TLS records
    std::uint64_t frame_bytes_out = 0;
    std::uint64_t audit_bytes_in = 0;  ///< of frame_bytes_in
    std::uint64_t malformed_frames = 0;
    std::uint64_t streams_lost = 0;
    std::uint64_t resumed = 0;
    std::uint64_t recovered = 0;      ///< of these: by a server that had crashed in between
    std::uint64_t sessions_lost = 0;  ///< resumes refused by the server, followed by a new login
    std::uint64_t commands_sent = 0;
    std::uint64_t commands_resent = 0;
    std::uint64_t travels = 0;           ///< to another world of a cluster
    std::uint64_t travels_prepared = 0;  ///< of these: the stream to its server was open already
    std::vector<double>
        travel_gaps_s;            ///< from the last word of one world to the avatar in the next
    std::uint64_t redirects = 0;  ///< to the server that has the world, or the character
    bool tunnelled = false;  ///< datagrams had to travel inside the stream, at least for a time
    bool websocket = false;  ///< the stream is a WebSocket
};

/// Not thread-safe. The transport queues its messages here; advance() does all work.
class Client {
  public:
    Client(Transport& transport, SessionHandler& handler, Login login);
    ~Client();
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    void start(double now_s);
    /// Says goodbye and closes.
    void quit(double now_s);

    /// Handles messages since the last call, then all work due. Cheap when there is none.
    void advance(double now_s);

    [[nodiscard]] bool has_incoming() const { return !incoming_.empty(); }

    /// Numbered and sent again after a resume until the server has acknowledged it. False before
    /// the first login, after the end, and with kMaxUnackedCommands waiting.
    bool send_command(std::uint32_t kind, std::string payload);
    /// Body of an input packet; sealed and sent now. Ignored unless online. Returns its sequence, 0
    /// when it was ignored.
    std::uint64_t send_input(std::span<const std::uint8_t> body, double now_s);
    void request_audit();
    void request_freeze(bool on);
    void reset_view(const std::string& reason);

    [[nodiscard]] SessionState state() const { return state_; }

    /// Reason why the session is closed or was last interrupted; empty when all is well.
    [[nodiscard]] const std::string& trouble() const { return trouble_; }

    [[nodiscard]] bool ever_online() const { return ever_online_; }

    [[nodiscard]] std::uint32_t rights() const { return rights_; }

    /// Of the newest session, in the server's cluster; empty: the server is in none.
    [[nodiscard]] const std::string& world_name() const { return world_name_; }

    [[nodiscard]] const clock::ClockSync& clock() const { return channel_.clock(); }

    [[nodiscard]] const UplinkUpdate& uplink() const { return channel_.uplink(); }

    [[nodiscard]] const DatagramStats& datagrams() const { return channel_.stats(); }

    [[nodiscard]] const EventInbox& events() const { return events_; }

    [[nodiscard]] const SessionStats& stats() const { return stats_; }

    /// Sent to another server by the cluster, and not there yet.
    [[nodiscard]] bool on_its_way() const {
        return redirected_s_ >= 0.0 && state_ != SessionState::kClosed;
    }

    /// Local time of the newest datagram that authenticated.
    [[nodiscard]] double last_packet_s() const { return last_packet_s_; }

    /// After so much silence over UDP the stream is asked as well: a server that answers there, and
    /// for kTunnelSureS not over UDP, is alive behind a path that lets no datagram through. One
    /// that is silent on both has stopped.
    static constexpr double kTunnelAfterS = 2.0;
    static constexpr double kTunnelSureS = 0.5;
    static constexpr double kStreamTimeoutS = 10.0;
    static constexpr int kFirstAttempts = 3;
    /// From server to server without a session in between: more would be a circle.
    static constexpr int kMostHops = 4;
    /// A client that the cluster sends to a server tries for this long to reach it.
    static constexpr double kRedirectPatienceS = 30.0;
    /// A hostile server does not make its clients knock on many doors.
    static constexpr double kPrepareEveryS = 0.5;
    static constexpr std::size_t kMaxUnackedCommands = 1024;

  private:
    struct Incoming {
        enum class IncomingKind : std::uint8_t {
            kOpened,
            kFrame,
            kDatagram,
            kClosed
        } kind = IncomingKind::kFrame;
        Bytes bytes;
        std::string reason;
        bool inside = false;  ///< kOpened: a WebSocket
    };

    enum class UplinkPath : std::uint8_t {
        kUdp,
        kAsking,  ///< over UDP, now and then inside the stream
        kStream,  ///< inside the stream, now and then over UDP
        kInside,  ///< a WebSocket: inside it, whatever comes
    };

    struct PendingCommand {
        std::uint64_t number = 0;
        std::uint32_t kind = 0;
        std::string payload;
    };

    void listen();
    void handle(Incoming& incoming, double now_s);
    void on_opened(const Incoming& incoming);
    void on_frame(const Bytes& frame, double now_s);
    void receive(const wire::WelcomeMessage& welcome, double now_s);
    /// False: no datagram can be sealed.
    [[nodiscard]] bool take_keys(const wire::WelcomeMessage& welcome);
    void give_up(std::string trouble);
    void receive(const wire::RefusedMessage& refused, double now_s);
    void receive(const wire::EventMessage& event, double now_s);
    void receive(const wire::JoinedMessage& joined, double now_s);
    void receive(const wire::AuditRecordMessage& record, double now_s);
    void receive(const wire::ClosingMessage& closing, double now_s);
    void receive(const wire::RedirectMessage& ahead, double now_s);
    void receive(const wire::DatagramMessage& datagram, double now_s);
    void receive(const wire::CommandAckMessage& ack, double now_s);
    void receive(std::monostate nothing, double now_s);
    /// False: it leads nowhere, and trouble_ says why.
    bool follow(const wire::RedirectMessage& redirect, double now_s);
    void drop_acknowledged(std::uint64_t through);
    void on_malformed();
    void on_datagram(std::span<const std::uint8_t> datagram, bool tunnel, double now_s);
    void on_closed(const std::string& reason, double now_s);
    void connect(double now_s);
    void timers(double now_s);
    void choose_path(double now_s);
    bool next_goes_inside_stream();
    void forget_session();
    void send(const wire::ClientMessage& message);
    void send_pending(const PendingCommand& command);

    Transport& transport_;
    SessionHandler& handler_;
    Login login_;
    std::vector<Incoming> incoming_;
    std::vector<Incoming> handling_;
    SessionState state_ = SessionState::kIdle;
    std::string trouble_;
    std::string closing_text_;
    bool ever_online_ = false;
    std::uint32_t rights_ = 0;
    std::string world_name_;
    std::string resume_token_;
    double grace_s_ = 0.0;
    double attempt_s_ = 0.0;  // when the current attempt began or the next one is due
    double lost_s_ = 0.0;     // when the stream was lost
    int attempts_ = 0;
    int hops_ = 0;  // since the last session
    double redirected_s_ = -1.0;
    double prepared_s_ = -kPrepareEveryS;  // when a server was last told of that may follow
    double travelling_since_s_ = -1.0;
    std::optional<wire::RedirectMessage> travel_;  // of the closing message, until the stream ends
    DatagramChannel channel_;
    EventInbox events_;
    std::uint64_t acked_events_ = 0;
    double event_ack_due_s_ = 0.0;
    std::uint64_t next_command_ = 1;
    std::list<PendingCommand> unacked_;
    double last_packet_s_ = 0.0;
    double last_udp_s_ = 0.0;
    UplinkPath path_ = UplinkPath::kUdp;
    double answered_s_ = -1.0;  // when the stream answered since the path is asked; -1: not yet
    std::uint64_t path_counter_ = 0;
    SessionStats stats_;
};

}  // namespace zoned::link

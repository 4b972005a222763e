// proto/WIRE.md agrees with the server about limits, refusals, and the ticks of commands.
#include "server/app/runtime/host_settings.h"
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/net/tls_listener.h"
#include "server/session/host/session_table.h"
#include "server/session/input_gate.h"
#include "server/session/login/display_names.h"
#include "server/session/reject.h"
#include "tests/unit/wire/wire_document.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace zoned::app {
namespace {

using session::Reject;
using wire::testing::Bytes;
using wire::testing::Example;
using Row = std::vector<std::string>;

config::Settings loaded(const std::vector<std::string>& sets = {}) {
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    EXPECT_TRUE(
        config::load_settings(ZONED_SOURCE_DIR "/config/minimal.txtpb", sets, settings, errors));
    return settings;
}

Row cells_of(const std::string& line) {
    Row out;
    std::istringstream in(line.substr(1));
    for (std::string cell; std::getline(in, cell, '|');) {
        const std::size_t begin = cell.find_first_not_of(' ');
        out.push_back(begin == std::string::npos
                          ? std::string()
                          : cell.substr(begin, cell.find_last_not_of(' ') + 1 - begin));
    }
    return out;
}

/// Rows of all tables under a comment `<!-- name: ... -->`, without their heads.
std::vector<Row> table_rows(const std::string& name) {
    std::vector<Row> out;
    int inside = 0;
    for (const std::string& line : wire::testing::document_lines()) {
        if (line.starts_with("<!-- " + name + ":")) {
            inside = 1;
        } else if (inside > 0 && line.starts_with("|")) {
            if (inside++ > 2) {
                out.push_back(cells_of(line));
            }
        } else {
            inside = 0;
        }
    }
    return out;
}

/// The text between `` in a cell, such as `network.max_load` in "`network.max_load` * 2".
std::string quoted(const std::string& cell) {
    const std::size_t begin = cell.find('`');
    return begin == std::string::npos
               ? std::string()
               : cell.substr(begin + 1, cell.find('`', begin + 1) - begin - 1);
}

/// The default that proto/config/ declares for `part.name`.
std::optional<double> declared_default(const std::string& setting) {
    const std::size_t dot = setting.find('.');
    const std::string part = setting.substr(0, dot);
    const bool replication = part == "replication";
    std::ifstream in(std::string(ZONED_SOURCE_DIR "/proto/config/") +
                     (replication ? "replication.proto" : "server.proto"));
    const std::string message =
        std::string("message ") + static_cast<char>(std::toupper(part[0])) + part.substr(1) + " {";
    const std::regex field(" " + setting.substr(dot + 1) + R"( = \d+ \[default = ([0-9.]+),)");
    bool inside = false;
    std::smatch found;
    for (std::string line; std::getline(in, line);) {
        inside = line == message || (inside && line != "}");
        if (inside && std::regex_search(line, found, field)) {
            return std::stod(found[1]);
        }
    }
    return std::nullopt;
}

bool is_reason(const std::string& name) {
    for (int i = 0; i < static_cast<int>(Reject::kCount); ++i) {
        if (name == session::reject_name(static_cast<Reject>(i))) {
            return true;
        }
    }
    const std::vector<std::string> of_streams = net::refusal_reasons();
    return std::find(of_streams.begin(), of_streams.end(), name) != of_streams.end();
}

/// The longest ticket of which more is looked at than its length.
std::size_t longest_ticket() {
    for (std::size_t claims = 2048; claims > 0; --claims) {
        proto::Ticket ticket;
        ticket.set_claims(std::string(claims, 'x'));
        ticket.set_signature(std::string(64, 'x'));
        const std::string bytes = ticket.SerializeAsString();
        const auto read = session::verify_ticket(
            {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, {}, 0);
        if (read.error() != "the ticket cannot be read") {
            return bytes.size();
        }
    }
    return 0;
}

/// The longest text that a check takes.
std::size_t longest(const std::function<bool(const std::string&)>& takes) {
    std::size_t size = 0;
    while (size < 4096 && takes(std::string(size + 1, 'x'))) {
        ++size;
    }
    return size;
}

bool takes_account(const std::string& account) {
    session::TicketClaims claims;
    claims.account = account;
    claims.expires_s = 1;
    return session::create_ticket(claims, session::generate_key_pair().private_key).ok();
}

/// How far an input gate looks, in ticks: ahead of the newest tick, or behind it.
Tick reach_of_the_gate(Tick window, Tick direction) {
    Tick reach = 0;
    for (Tick distance = 1; distance < 100; ++distance) {
        session::InputGate gate;
        session::RejectCounters rejects;
        session::InputGate::PassedCommands passed;
        motion::InputCommand command;
        command.tick = 1000 + direction * distance;
        gate.filter({&command, 1}, 1000, window, rejects, passed);
        reach = passed.empty() ? reach : distance;
    }
    return reach;
}

/// The numbers of a server that sets nothing, by the names of the page's rows.
std::map<std::string, double> limits_of_the_code() {
    const config::Settings settings = loaded();
    const session::HostSettings host = host_settings(settings);
    const net::TlsSettings tls = tls_settings(settings);
    const auto number = [](auto value) {
        return static_cast<double>(value);
    };
    const auto clients = settings.server.network.max_clients;
    EXPECT_EQ(tls.limits.max_frame_bytes, host.max_frame_bytes);
    EXPECT_EQ(tls.max_connections, clients * 5 / 4 + 16);
    return {
        {"bytes of a datagram", number(wire::kMaxDatagramBytes)},
        {"bytes of a state packet's body", number(wire::kMaxDownBodyBytes)},
        {"commands of an input packet", number(wire::kMaxCommandsPerPacket)},
        {"bytes of a client's frame", number(host.max_frame_bytes)},
        {"bytes of a command's payload", number(host.max_command_bytes)},
        {"kind of a command", number(std::numeric_limits<decltype(mailbox::Command::kind)>::max())},
        {"bytes of a name, at least 1", number(longest(session::is_valid_name))},
        {"bytes of a team", number(longest(session::is_valid_team))},
        {"bytes of a ticket", number(longest_ticket())},
        {"bytes of a ticket's account, at least 1", number(longest(takes_account))},
        {"s from the connection to `Hello`, without waiting for a turn", host.login_timeout_s},
        {"s without a datagram or frame", host.silence_timeout_s},
        {"s of grace without a stream", host.grace_s},
        {"ticks of a command ahead", number(reach_of_the_gate(host.input_window_ticks, 1))},
        {"ticks of a command behind", number(reach_of_the_gate(host.input_window_ticks, -1))},
        {"events without `EventAck`, and without `Confirm`", number(host.max_unacked_events)},
        {"bytes that wait in a stream for the client", number(tls.limits.max_queue_bytes)},
        {"of these, bytes that let a state packet in over TLS",
         number(host.max_tunnel_backlog_bytes)},
        {"of these, bytes that let a state packet into a WebSocket",
         number(host.max_websocket_backlog_bytes)},
        {"bytes a second to a client, headers counted", host.rate.ceiling},
        {"connections of an address, or of an IPv6 network of 64 bits",
         number(tls.max_connections_per_address)},
        {"connections in all", number(tls.max_connections)},
        {"handshakes a second, of all", tls.max_handshakes_per_s},
        {"sessions in all", number(host.max_sessions)},
        {"share of the server's time in use", host.max_load},
        {"sessions of an address, 0: any number", number(host.max_per_address)},
        {"sessions of an account, 0: any number", number(host.max_per_account)},
    };
}

/// A setting is there with the default that the row says, and a reason is one that is counted.
void check_setting(const Row& row, double value, const std::string& setting) {
    if (quoted(setting).empty()) {
        EXPECT_EQ(setting, "-") << row[0];
    } else if (setting.ends_with("`")) {
        const auto declared = declared_default(quoted(setting));
        ASSERT_TRUE(declared) << setting;
        EXPECT_EQ(*declared, value) << row[0];
    } else {
        EXPECT_TRUE(declared_default(quoted(setting))) << setting;
    }
    EXPECT_TRUE(row.back() == "-" || is_reason(quoted(row.back()))) << row[0];
}

TEST(WireDocumentLimits, AreThoseOfAServerThatSetsNothing) {
    std::map<std::string, double> code = limits_of_the_code();
    for (const Row& row : table_rows("limits")) {
        ASSERT_EQ(row.size(), 5U) << row[0];
        const auto it = code.find(row[0]);
        ASSERT_NE(it, code.end()) << row[0];
        EXPECT_EQ(std::stod(row[1]), it->second) << row[0];
        check_setting(row, it->second, row[2]);
        code.erase(it);
    }
    for (const auto& [name, value] : code) {
        ADD_FAILURE() << "the page does not say: " << name << ", " << value;
    }
}

/// A bucket's tokens at once, and those that it has again after a second.
std::pair<int, int> measured(core::TokenBucket bucket) {
    std::pair<int, int> out;
    for (; bucket.take(0.0); ++out.first) {
    }
    for (; bucket.take(1.0); ++out.second) {
    }
    return out;
}

TEST(WireDocumentLimits, OfRatesAreThoseOfAServerThatSetsNothing) {
    const session::Session fresh(host_settings(loaded()));
    std::map<std::string, const core::TokenBucket*> code{{"datagrams", &fresh.datagrams},
                                                         {"frames of any kind", &fresh.frames},
                                                         {"`Command`", &fresh.commands},
                                                         {"`ViewReset`", &fresh.view_resets},
                                                         {"`AuditRequest`", &fresh.audits}};
    for (const Row& row : table_rows("rates")) {
        ASSERT_EQ(row.size(), 6U) << row[0];
        ASSERT_TRUE(code.contains(row[0])) << row[0];
        const auto [at_once, a_second] = measured(*code[row[0]]);
        EXPECT_EQ(std::stoi(row[1]), a_second) << row[0];
        EXPECT_EQ(std::stoi(row[2]), at_once) << row[0];
        check_setting(row, a_second, row[3]);
        code.erase(row[0]);
    }
    EXPECT_TRUE(code.empty());
}

Example only(const std::string& name) {
    const auto all = wire::testing::examples_named(name);
    EXPECT_EQ(all.size(), 1U) << name;
    return all.empty() ? Example{} : all[0];
}

TEST(WireDocumentServer, RefusesAnotherVersionWithTheBytesOfThePage) {
    const Example e = only("refused-frame");
    session::HostSettings settings = host_settings(loaded());
    settings.config_digest = e.text("config_digest");
    Bytes answer;
    session::SessionOutput output;
    output.send_frame = [&](session::StreamId, const session::Bytes& frame) {
        answer = frame;
    };
    output.close_stream = [](session::StreamId) {
    };
    session::SessionHost host(settings, output);
    host.on_stream_open(session::StreamId(1), true, 0.0);
    proto::ClientMessage message;
    message.mutable_hello()->set_protocol_version(
        static_cast<std::uint32_t>(e.number("client_version")));
    const std::string hello = message.SerializeAsString();
    host.on_frame(session::StreamId(1),
                  {reinterpret_cast<const std::uint8_t*>(hello.data()), hello.size()},
                  0.0);
    Bytes said = e.bytes("hex");
    ASSERT_GT(said.size(), 4U);
    EXPECT_EQ(said[0] + 256U * said[1], answer.size());
    said.erase(said.begin(), said.begin() + 4);
    EXPECT_EQ(said, answer);
    EXPECT_EQ(host.stats().rejected.at("login_version"), 1U);
}

std::vector<motion::InputCommand> commands_at(const Example& e, const std::string& key) {
    std::vector<motion::InputCommand> out;
    for (const double tick : e.numbers(key)) {
        out.emplace_back().tick = static_cast<Tick>(tick);
    }
    return out;
}

TEST(WireDocumentServer, TakesCommandsInTheWindowOfThePage) {
    const Example e = only("input-window");
    const auto offered = commands_at(e, "offered");
    session::InputGate gate;
    session::RejectCounters rejects;
    session::InputGate::PassedCommands passed;
    const Tick window = host_settings(loaded()).input_window_ticks;
    gate.filter(offered, e.number("newest_tick"), window, rejects, passed);
    const auto taken = commands_at(e, "taken");
    EXPECT_TRUE(std::equal(passed.begin(), passed.end(), taken.begin(), taken.end()));
    EXPECT_EQ(rejects.of(Reject::kInputLate), e.numbers("late").size());
    EXPECT_EQ(rejects.of(Reject::kInputMissed), e.numbers("missed").size());
    EXPECT_EQ(rejects.of(Reject::kInputAhead), e.numbers("ahead").size());
    EXPECT_EQ(passed.size() + rejects.of(Reject::kInputLate) + rejects.of(Reject::kInputAhead),
              offered.size());
}

/// `move_x move_z yaw pitch buttons`.
motion::InputCommand command_in(Tick tick, std::istream& in) {
    std::array<int, 5> v{};
    for (int& x : v) {
        in >> x;
    }
    return {tick,
            static_cast<std::int8_t>(v[0]),
            static_cast<std::int8_t>(v[1]),
            static_cast<std::uint16_t>(v[2]),
            static_cast<std::int16_t>(v[3]),
            static_cast<std::uint16_t>(v[4])};
}

/// A world with one player.
class PlayedWorld {
  public:
    PlayedWorld() : world_(settings_, 1) {
        mailbox::Join join;
        join.client = ClientId(1);
        join.name = "player";
        tick({join});
        tick({});
    }

    void tick(const std::vector<mailbox::InboxItem>& items) {
        out_.clear();
        world_.tick(items, out_);
    }

    [[nodiscard]] zone::ZoneState& state() const { return world_.zones()[0]->state(); }

    /// The avatar's move in the newest tick.
    [[nodiscard]] motion::InputCommand command() const {
        const world::Entities& e = state().entities;
        const world::Row row = e.find(state().clients.at(0).avatar);
        return row == world::kNoRow ? motion::InputCommand{} : e.command[row];
    }

    [[nodiscard]] double tick_rate_hz() const { return settings_.tick_rate_hz; }

  private:
    config::Settings settings_ = loaded();
    World world_;
    std::vector<mailbox::OutboxItem> out_;
};

TEST(WireDocumentServer, RepeatsTheLastCommandAsThePageSays) {
    const Example e = only("missing-inputs");
    PlayedWorld world;
    ASSERT_EQ(e.numbers("tick_rate_hz").at(0), world.tick_rate_hz());
    const Tick begin = world.state().now + 1;
    std::istringstream first(e.text("command"));
    world.tick({mailbox::Input{ClientId(1), {command_in(begin, first)}}});
    EXPECT_FALSE(world.state().clients.at(0).own.input_missing);
    std::map<Tick, motion::InputCommand> done;  // by ticks since the command
    for (Tick since = 1; since <= 100; ++since) {
        world.tick({});
        EXPECT_TRUE(world.state().clients.at(0).own.input_missing);
        done[since] = world.command();
    }
    const auto [from, to] = e.values.equal_range("repeated");
    EXPECT_NE(from, to);
    for (auto line = from; line != to; ++line) {
        std::istringstream in(line->second);
        Tick tick = 0;
        in >> tick;
        const Tick since = tick - e.number("tick");
        EXPECT_EQ(done.at(since), command_in(begin + since, in)) << line->second;
    }
}

}  // namespace
}  // namespace zoned::app

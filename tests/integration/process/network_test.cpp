// How client-sim finds and trusts a server, and its behaviour when the path is cut.
#include "tests/integration/process/fixture.h"

#include <csignal>
#include <cstdio>

namespace zoned::testing_process {
namespace {

class Trust : public Process {
  protected:
    /// SHA-256 of the server's certificate, as its log says.
    static std::string fingerprint(const Child& server) {
        const std::string key = "certificate sha256 ";
        const std::string log = server.errors();
        const std::size_t at = log.find(key);
        return at == std::string::npos ? "" : log.substr(at + key.size(), 64);
    }

    /// client-sim with more arguments, run to its end.
    static Child run(std::vector<std::string> arguments, std::vector<std::string> more) {
        arguments.insert(arguments.end(), more.begin(), more.end());
        return Child("client-sim", arguments);
    }
};

TEST_F(Trust, GoesToTheCertificateThatIsPinned) {
    const auto server = start_server();
    const std::string pin = fingerprint(*server);
    ASSERT_EQ(pin.size(), 64u) << server->errors();
    Child good = run(play(2, 1), {"--pin", pin});
    EXPECT_EQ(good.wait(kPatience), 0) << good.output() << good.errors();
    std::string other = pin;
    other[7] = other[7] == 'a' ? 'b' : 'a';
    Child bad = run(play(2, 1), {"--pin", other});
    EXPECT_EQ(bad.wait(kPatience), 3) << bad.output();
    EXPECT_NE(bad.errors().find("is not the pinned one"), std::string::npos) << bad.errors();
}

TEST_F(Trust, GoesToTheCertificateThatAnAuthorityVouchesFor) {
    const auto server = start_server();
    const std::string certificate = scratch_folder() + "/certificate.pem";
    for (const char* host : {"127.0.0.1", "localhost"}) {
        Child good = run(play(2, 1, host), {"--ca", certificate});
        EXPECT_EQ(good.wait(kPatience), 0) << host << good.output() << good.errors();
    }
    // Another server's certificate proves nothing here.
    const std::string elsewhere = scratch_folder() + "/elsewhere";
    const int port = tcp_port;
    start_server({"--set", "session.state_folder=\"" + elsewhere + "\""});
    tcp_port = port;
    Child bad = run(play(2, 1), {"--ca", elsewhere + "/certificate.pem"});
    EXPECT_EQ(bad.wait(kPatience), 3) << bad.output();
    EXPECT_NE(bad.errors().find("TLS handshake failed"), std::string::npos) << bad.errors();
    // The right certificate, but it does not contain the requested name.
    Child alias = run(play(2, 1, "127.0.0.2"), {"--ca", certificate});
    EXPECT_EQ(alias.wait(kPatience), 3) << alias.output();
}

TEST_F(Process, BotsPlayOverWebSocketAndAreConsistent) {
    const std::string report = scratch_folder() + "/server.json";
    const std::string folder = scratch_folder();
    auto server = start_server({"--set", "network.websocket_port=0", "--report", report});
    const int port = number_after(server->output(), "websocket=");
    ASSERT_GT(port, 0) << server->output();
    tcp_port = port;
    std::vector<std::string> arguments = play(10, 4);
    arguments.insert(arguments.end(),
                     {"--transport", "websocket", "--report", folder + "/client.json"});
    Child bots("client-sim", arguments);
    EXPECT_EQ(bots.wait(kPatience), 0) << bots.output() << bots.errors();
    EXPECT_NE(bots.output().find("verdict: consistent"), std::string::npos);
    const std::string said = read(folder + "/client.json");
    EXPECT_NE(said.find("\"tunnelled_bots\": 10"), std::string::npos) << said;
    server->signal(SIGTERM);
    EXPECT_EQ(server->wait(kPatience), 0);
    EXPECT_NE(read(report).find("\"websockets_opened\": 10"), std::string::npos) << read(report);
}

TEST_F(Process, WebSocketsComeFromThisMachineAlone) {
    const auto server = start_server({"--set", "network.websocket_port=0"});
    char port[8];
    std::snprintf(port, sizeof(port), ":%04X", number_after(server->output(), "websocket="));
    // Of all sockets with that port, the kernel's list says where they listen: 127.0.0.1.
    const std::string v4 = read("/proc/net/tcp");
    const std::size_t at = v4.find(port + std::string(" 00000000:0000 0A"));
    ASSERT_NE(at, std::string::npos) << v4;
    EXPECT_EQ(v4.substr(at - 8, 8), "0100007F");
    EXPECT_EQ(read("/proc/net/tcp6").find(port + std::string(" 0000")), std::string::npos);
}

TEST_F(Process, AWebSocketsPortSaysWhatItIs) {
    const auto server = start_server({"--set", "network.websocket_port=0"});
    const int tcp = tcp_port;
    // The game's port is no WebSocket, and the WebSocket's port is no game.
    std::vector<std::string> wrong = play(1, 1);
    wrong.insert(wrong.end(), {"--transport", "websocket"});
    Child first("client-sim", wrong);
    EXPECT_EQ(first.wait(kPatience), 3) << first.output();
    tcp_port = number_after(server->output(), "websocket=");
    ASSERT_NE(tcp_port, tcp);
    Child second("client-sim", play(1, 1));
    EXPECT_EQ(second.wait(kPatience), 3) << second.output();
    EXPECT_NE(second.errors().find("is the port its tcp= port"), std::string::npos)
        << second.errors();
}

TEST_F(Process, PlaysOverIpv6) {
    if (read("/proc/net/if_inet6").find("00000000000000000000000000000001") == std::string::npos) {
        GTEST_SKIP() << "this machine has no ::1";
    }
    const auto server = start_server({"--set", "network.bind_address=\"::1\""});
    const std::string report = scratch_folder() + "/client.json";
    std::vector<std::string> arguments = play(4, 2, "[::1]");
    arguments.insert(arguments.end(), {"--report", report});
    Child client("client-sim", arguments);
    EXPECT_EQ(client.wait(kPatience), 0) << client.output() << client.errors();
    EXPECT_NE(read(report).find("\"tunnelled_bots\": 0"), std::string::npos) << read(report);
}

TEST_F(Process, ComesThroughOutagesOfThePathAndSaysSo) {
    const auto server = start_server();
    const std::string report = scratch_folder() + "/client.json";
    std::vector<std::string> arguments = play(4, 9);
    arguments.insert(arguments.end(), {"--outage", "3:0.8", "--report", report});
    Child client("client-sim", arguments);
    EXPECT_EQ(client.wait(kPatience), 0) << client.output() << client.errors();
    // The last updates are as old as the outage: comparisons during it say less.
    EXPECT_NE(client.output().find("WARNING: stale"), std::string::npos) << client.output();
    EXPECT_EQ(read(report).find("\"packets_lost\": 0,"), std::string::npos) << read(report);
    EXPECT_NE(read(report).find("\"events_lost\": 0,"), std::string::npos) << read(report);
}

/// A server that stands still for longer than its sessions live in silence: its clients wait, over
/// the same path, and all that they show 2 s after it goes on is within its bound.
TEST_F(Process, KeepsItsClientsWhenTheServerStandsStill) {
    const auto server = start_server();
    const std::string report = scratch_folder() + "/client.json";
    std::vector<std::string> arguments = play(6, 12);
    arguments.insert(arguments.end(), {"--report", report});
    Child client("client-sim", arguments);
    EXPECT_EQ(client.wait(3.0), -1) << client.output() << client.errors();
    server->signal(SIGSTOP);
    EXPECT_EQ(client.wait(4.0), -1) << client.output() << client.errors();
    server->signal(SIGCONT);
    EXPECT_EQ(client.wait(kPatience), 0) << client.output() << client.errors();
    EXPECT_NE(client.output().find("WARNING: stall: the server dropped ticks"), std::string::npos)
        << client.output();
    const std::string text = read(report);
    for (const char* key : {"\"tunnelled_bots\": 0", "\"resumed\": 0", "\"bots_lost\": 0"}) {
        EXPECT_NE(text.find(key), std::string::npos) << key << text;
    }
}

}  // namespace
}  // namespace zoned::testing_process

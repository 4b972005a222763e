// What an operator asks of the sessions.
#include "tests/unit/session/fake_client.h"

#include <gtest/gtest.h>

namespace zoned::session {
namespace {

SessionChoice by_client(std::uint32_t number) {
    SessionChoice who;
    who.client = ClientId(number);
    return who;
}

TEST(Control, TellsWhoIsThere) {
    TestHost host(dev_settings());
    FakeClient first(host);
    FakeClient second(host);
    ASSERT_TRUE(first.log_in());
    ASSERT_TRUE(second.log_in());
    host.host.on_outbox(
        mailbox::Joined{ClientId(2), EntityId(9), ZoneId(1), host.tick}, host.now_s, 0.0);
    const auto all = host.host.figures(ClientId{}, 10, host.now_s + 0.5);
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[0].client, ClientId(1));
    EXPECT_EQ(all[0].account, "development");
    EXPECT_EQ(all[0].zone, ZoneId{});
    EXPECT_DOUBLE_EQ(all[0].silent_s, 0.5);
    EXPECT_TRUE(all[0].connected);
    EXPECT_EQ(all[1].avatar, EntityId(9));
    EXPECT_EQ(all[1].zone, ZoneId(1));
    EXPECT_EQ(host.host.figures(ClientId{}, 1, host.now_s).size(), 1U);
    EXPECT_EQ(host.host.figures(ClientId(1), 10, host.now_s).at(0).client, ClientId(2));
    EXPECT_TRUE(host.host.figures(ClientId(2), 10, host.now_s).empty());
    host.host.on_stream_closed(first.stream, host.now_s);
    EXPECT_FALSE(host.host.figures(ClientId{}, 1, host.now_s).at(0).connected);
}

TEST(Control, KicksTheChosenAlone) {
    TestHost host(dev_settings());
    FakeClient first(host);
    FakeClient second(host);
    ASSERT_TRUE(first.log_in());
    ASSERT_TRUE(second.log_in());
    EXPECT_EQ(host.host.kick(SessionChoice{}, "nobody"), 0U);
    EXPECT_EQ(host.host.kick(by_client(7), "nobody"), 0U);
    EXPECT_EQ(host.host.kick(by_client(1), "be kind"), 1U);
    EXPECT_EQ(host.frames[first.stream].back().closing().reason(), proto::CLOSING_KICKED);
    EXPECT_EQ(host.frames[first.stream].back().closing().text(), "be kind");
    EXPECT_EQ(host.take<mailbox::Leave>().at(0).reason, mailbox::LeaveReason::kKicked);
    EXPECT_EQ(host.host.sessions(), std::vector{ClientId(2)});
    SessionChoice account;
    account.account = "development";
    EXPECT_EQ(host.host.kick(account, "all"), 1U);
    EXPECT_EQ(host.host.stats().sessions, 0U);
}

TEST(Control, RefusesABannedAccountUntilItsTimeIsOver) {
    TestHost host(dev_settings());
    host.host.set_unix_time(5000.0, host.now_s);
    FakeClient first(host);
    ASSERT_TRUE(first.log_in());
    EXPECT_EQ(host.host.ban({"development", 5010, "cheats"}), 1U);
    EXPECT_EQ(host.frames[first.stream].back().closing().text(), "banned: cheats");
    EXPECT_FALSE(FakeClient(host).log_in());
    EXPECT_EQ(host.rejected("login_banned"), 1U);
    EXPECT_EQ(host.host.bans().size(), 1U);
    host.advance(11.0);
    EXPECT_TRUE(FakeClient(host).log_in());
    EXPECT_TRUE(host.host.bans().empty());
    EXPECT_EQ(host.host.ban({"development", 0, ""}), 1U);
    host.advance(1000.0);
    EXPECT_FALSE(FakeClient(host).log_in());
    EXPECT_TRUE(host.host.unban("development"));
    EXPECT_FALSE(host.host.unban("development"));
    EXPECT_TRUE(FakeClient(host).log_in());
}

TEST(Control, NotifiesThroughTheWorld) {
    TestHost host(dev_settings());
    FakeClient first(host);
    FakeClient second(host);
    EXPECT_EQ(host.host.notify(ClientId{}, "nobody is here"), 0U);
    ASSERT_TRUE(first.log_in());
    ASSERT_TRUE(second.log_in());
    host.inbox.clear();
    EXPECT_EQ(host.host.notify(ClientId{}, "noon"), 2U);
    EXPECT_EQ(host.host.notify(ClientId(2), "you"), 1U);
    EXPECT_EQ(host.host.notify(ClientId(3), "nobody"), 0U);
    ASSERT_EQ(host.inbox.size(), 2U);
    const auto& all = std::get<mailbox::Notice>(host.inbox[0]);
    const auto& one = std::get<mailbox::Notice>(host.inbox[1]);
    EXPECT_FALSE(all.client);
    EXPECT_EQ(all.text, "noon");
    EXPECT_EQ(one.client, ClientId(2));
    EXPECT_EQ(one.text, "you");
}

TEST(Control, DrainsByRefusingLoginsAlone) {
    TestHost host(dev_settings());
    FakeClient first(host);
    ASSERT_TRUE(first.log_in());
    host.host.set_draining("draining");
    EXPECT_FALSE(FakeClient(host).log_in());
    EXPECT_EQ(host.rejected("login_shutdown"), 1U);
    EXPECT_EQ(host.host.stats().sessions, 1U);
    host.host.set_draining("");
    EXPECT_TRUE(FakeClient(host).log_in());
}

TEST(Control, ChangesLimitsLive) {
    TestHost host(dev_settings());
    FakeClient first(host);
    ASSERT_TRUE(first.log_in());
    HostLimits limits = dev_settings();
    limits.max_sessions = 1;
    limits.grace_s = 1.0;
    host.host.set_limits(limits);
    EXPECT_FALSE(FakeClient(host).log_in());
    EXPECT_EQ(host.rejected("login_full"), 1U);
    host.host.on_stream_closed(first.stream, host.now_s);
    host.advance(1.1);
    EXPECT_EQ(host.host.stats().sessions, 0U);
}

TEST(Control, RefusesLoginsWhereTheServerIsBusyAndNotThoseWhoComeBack) {
    TestHost host(dev_settings());
    FakeClient first(host);
    ASSERT_TRUE(first.log_in());
    for (int i = 0; i < 40; ++i) {
        host.advance(0.25);
        host.host.measured(1.2, host.now_s);
    }
    EXPECT_NEAR(host.host.stats().load, 1.2, 1e-3);
    FakeClient second(host);
    EXPECT_FALSE(second.log_in());
    EXPECT_EQ(host.rejected("login_busy"), 1U);
    EXPECT_TRUE(host.host.stats().refusing);
    first.drop();
    EXPECT_TRUE(first.resume(0));
    HostLimits limits = dev_settings();
    limits.max_load = 10.0;
    host.host.set_limits(limits);
    EXPECT_TRUE(FakeClient(host).log_in());
}

TEST(Control, TellsZonesOfFewerBytesWhereTheServerIsBusy) {
    TestHost host(dev_settings());
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    const double floor = dev_settings().rate.floor;
    for (int i = 0; i < 40; ++i) {
        host.advance(0.25);
        host.host.measured(1.2, host.now_s);
    }
    EXPECT_EQ(host.host.stats().ceiling_bytes_per_s, floor);
    client.send_datagram({});
    client.state(1);
    wire::UpTransport transport;
    transport.ack_low = 1;
    client.send_datagram({}, 1, transport);
    const auto acks = host.take<mailbox::Acks>();
    ASSERT_FALSE(acks.empty());
    EXPECT_EQ(acks.back().rate_bytes_per_s, static_cast<std::uint32_t>(floor));
}

TEST(Control, NotesWhoComesAndGoes) {
    HostSettings settings = dev_settings();
    settings.max_sessions = 1;
    std::vector<SessionNote> notes;
    TestHost host(settings, [&](const SessionNote& note) { notes.push_back(note); });
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    FakeClient second(host);
    EXPECT_FALSE(second.log_in());
    client.drop();
    ASSERT_TRUE(client.resume(0));
    SessionChoice who;
    who.client = client.client;
    EXPECT_EQ(host.host.kick(who, "be kind"), 1U);
    using Kind = SessionNote::Kind;
    ASSERT_EQ(notes.size(), 5U);
    EXPECT_EQ(notes[0].kind, Kind::kJoined);
    EXPECT_EQ(notes[0].name, "ann");
    EXPECT_EQ(notes[0].rights, mailbox::kRightPlay);
    EXPECT_EQ(notes[1].kind, Kind::kRefused);
    EXPECT_NE(notes[1].text.find("full"), std::string::npos);
    EXPECT_EQ(notes[2].kind, Kind::kAway);
    EXPECT_EQ(notes[3].kind, Kind::kResumed);
    EXPECT_EQ(notes[4].kind, Kind::kLeft);
    EXPECT_EQ(notes[4].text, "be kind");
}

TEST(Control, WaitsForAClientThatStillTakesItsWorld) {
    HostSettings settings = dev_settings();
    settings.silence_timeout_s = 2.0;
    TestHost host(settings);
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    host.backlog = 4'000'000;
    for (int i = 0; i < 10; ++i) {
        host.advance(1.0);
        host.backlog -= 100'000;
    }
    EXPECT_EQ(host.closed.count(client.stream), 0U) << "it says nothing, but takes its world";
    host.advance(4.0);  // and now it takes nothing any more
    EXPECT_EQ(host.closed.count(client.stream), 1U);
}

}  // namespace
}  // namespace zoned::session

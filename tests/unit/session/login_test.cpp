#include "tests/unit/session/fake_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace zoned::session {
namespace {

HostSettings ticket_settings(const KeyPair& pair) {
    HostSettings settings;
    settings.ticket_keys = {pair.public_key};
    settings.config_digest = "c0ffee";
    settings.audience = "valley";
    return settings;
}

TicketClaims claims() {
    TicketClaims c;
    c.account = "account-1";
    c.name = "Ticket Name";
    c.team = "red";
    c.rights = mailbox::kRightPlay | mailbox::kRightAudit;
    c.not_before_s = 900;
    c.expires_s = 2000;
    c.nonce = random_nonce();
    return c;
}

proto::ClientMessage hello_with(const std::vector<std::uint8_t>& ticket) {
    proto::ClientMessage hello = hello_message();
    hello.mutable_hello()->set_ticket(ticket.data(), ticket.size());
    return hello;
}

void expect_refused(TestHost& host,
                    const proto::ClientMessage& hello,
                    proto::RefusedReason reason,
                    const std::string& counter,
                    const std::string& text,
                    bool loopback = true) {
    FakeClient client(host);
    const std::uint64_t before = host.rejected(counter);
    EXPECT_FALSE(client.log_in(hello, loopback));
    EXPECT_EQ(client.answer.refused().reason(), reason);
    EXPECT_THAT(client.answer.refused().text(), testing::HasSubstr(text));
    EXPECT_EQ(client.answer.refused().protocol_version(), dev_settings().protocol_version);
    EXPECT_EQ(host.closed.count(client.stream), 1U);
    EXPECT_EQ(host.rejected(counter), before + 1);
    EXPECT_TRUE(host.take<mailbox::Join>().empty());
}

TEST(Login, WelcomesALoopbackClientInDevelopmentModeAndJoinsItAtOnce) {
    TestHost host(dev_settings());
    host.host.set_udp_port(4711);
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    const proto::Welcome& welcome = client.answer.welcome();
    EXPECT_EQ(welcome.udp_port(), 4711U);
    EXPECT_EQ(welcome.config_digest(), "c0ffee");
    EXPECT_EQ(welcome.rights(), mailbox::kRightPlay);
    EXPECT_EQ(welcome.resume_token().size(), 16U);
    EXPECT_NE(welcome.connection_id(), 0U);
    EXPECT_FALSE(welcome.resumed());
    EXPECT_EQ(welcome.world().tick_rate_hz(), 30.0);
    const auto joins = host.take<mailbox::Join>();
    ASSERT_EQ(joins.size(), 1U);
    EXPECT_EQ(joins[0].client, client.client);
    EXPECT_EQ(joins[0].name, "ann");
    EXPECT_EQ(host.host.sessions(), std::vector<ClientId>{client.client});
}

TEST(Login, TakesNameTeamAndRightsFromTheTicket) {
    const KeyPair pair = generate_key_pair();
    TestHost host(ticket_settings(pair));
    FakeClient client(host);
    ASSERT_TRUE(client.log_in(hello_with(*create_ticket(claims(), pair.private_key)), false));
    const auto joins = host.take<mailbox::Join>();
    ASSERT_EQ(joins.size(), 1U);
    EXPECT_EQ(joins[0].name, "Ticket Name");
    EXPECT_EQ(joins[0].team, "red");
    EXPECT_EQ(joins[0].rights, mailbox::kRightPlay | mailbox::kRightAudit);
}

TEST(Login, RefusesOtherVersionsAndDigestsAndNamesBothSides) {
    TestHost host(dev_settings());
    proto::ClientMessage hello = hello_message();
    const std::uint32_t own = dev_settings().protocol_version;
    hello.mutable_hello()->set_protocol_version(own + 1);
    expect_refused(host,
                   hello,
                   proto::REFUSED_PROTOCOL_VERSION,
                   "login_version",
                   "version " + std::to_string(own + 1) + ", the server speaks version " +
                       std::to_string(own) + ": update the server");
    hello = hello_message();
    hello.mutable_hello()->set_config_digest("decaf");
    expect_refused(host,
                   hello,
                   proto::REFUSED_CONFIG_DIGEST,
                   "login_digest",
                   "digest decaf, the server's has c0ffee");
    hello.mutable_hello()->set_config_digest("c0ffee");
    FakeClient client(host);
    EXPECT_TRUE(client.log_in(hello));
}

TEST(Login, RefusesWhoHasNoTicketUnlessOnLoopbackInDevelopmentMode) {
    TestHost development(dev_settings());
    expect_refused(development,
                   hello_message(),
                   proto::REFUSED_TICKET,
                   "login_ticket",
                   "only loopback",
                   false);
    TestHost strict(ticket_settings(generate_key_pair()));
    expect_refused(
        strict, hello_message(), proto::REFUSED_TICKET, "login_ticket", "sent no ticket");
}

TEST(Login, RefusesAnyTicketWithOneBitChanged) {
    const KeyPair pair = generate_key_pair();
    const std::vector<std::uint8_t> good = *create_ticket(claims(), pair.private_key);
    const std::vector<PublicKey> keys = {pair.public_key};
    ASSERT_TRUE(verify_ticket(good, keys, 1000));
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
        std::vector<std::uint8_t> bad = good;
        bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1u << (bit % 8)));
        EXPECT_FALSE(verify_ticket(bad, keys, 1000)) << "bit " << bit;
    }
}

TEST(Login, RefusesATicketOfAnotherKeyTooEarlyTooLateOrUsed) {
    const KeyPair pair = generate_key_pair();
    const KeyPair other = generate_key_pair();
    TestHost host(ticket_settings(pair));
    const auto refused = [&](const TicketClaims& c, const PrivateKey& key, const char* text) {
        expect_refused(
            host, hello_with(*create_ticket(c, key)), proto::REFUSED_TICKET, "login_ticket", text);
    };
    refused(claims(), other.private_key, "by none of the keys");
    TicketClaims c = claims();
    c.not_before_s = 1001;  // the test's clock begins at 1000
    refused(c, pair.private_key, "valid from");
    c = claims();
    c.expires_s = 1000;
    refused(c, pair.private_key, "expired");
    c = claims();
    c.rights = mailbox::kRightAudit;
    refused(c, pair.private_key, "right to play");

    c = claims();
    c.world = "shire";
    refused(c, pair.private_key, "for the world shire, this server has valley");
    c = claims();
    c.rights |= 1U << 4U;
    EXPECT_FALSE(create_ticket(c, pair.private_key));

    c = claims();
    c.world = "valley";
    FakeClient client(host);
    ASSERT_TRUE(client.log_in(hello_with(*create_ticket(c, pair.private_key))));
    host.take<mailbox::Join>();
    refused(c, pair.private_key, "used before");
    // The memory of it ends only when the ticket itself has expired.
    host.advance(999.0);
    refused(c, pair.private_key, "used before");
    host.advance(1.5);
    refused(c, pair.private_key, "expired");
}

TEST(Login, ChecksTicketsByTheUnixTimeItWasGiven) {
    const KeyPair pair = generate_key_pair();
    TestHost host(ticket_settings(pair));
    TicketClaims c = claims();
    c.not_before_s = 1'700'000'000;
    c.expires_s = 1'700'000'060;
    host.host.set_unix_time(1'700'000'030.0, host.now_s);
    FakeClient client(host);
    EXPECT_TRUE(client.log_in(hello_with(*create_ticket(c, pair.private_key))));
}

TEST(Login, DoesNotUseUpATicketWhenTheServerIsFull) {
    const KeyPair pair = generate_key_pair();
    HostSettings settings = ticket_settings(pair);
    settings.dev_mode_loopback = true;
    settings.max_sessions = 1;
    TestHost host(settings);
    FakeClient first(host);
    ASSERT_TRUE(first.log_in());
    host.take<mailbox::Join>();
    const auto ticket = *create_ticket(claims(), pair.private_key);
    expect_refused(host, hello_with(ticket), proto::REFUSED_FULL, "login_full", "all of its 1");
    proto::ClientMessage quit;
    quit.mutable_quit();
    host.send(first.stream, quit);
    FakeClient second(host);
    EXPECT_TRUE(second.log_in(hello_with(ticket)));
}

TEST(Login, EndsTheOldestSessionsOfAnAccountThatHasTooMany) {
    const KeyPair pair = generate_key_pair();
    HostSettings settings = ticket_settings(pair);
    settings.max_per_account = 2;
    TestHost host(settings);
    std::vector<ClientId> ids;
    const auto come = [&](const char* account, const char* name) {
        TicketClaims c = claims();
        c.account = account;
        c.name = name;
        FakeClient client(host);
        EXPECT_TRUE(client.log_in(hello_with(*create_ticket(c, pair.private_key))));
        ids.push_back(client.client);
    };
    come("ann", "one");
    come("bob", "one");
    come("ann", "two");
    EXPECT_EQ(host.host.sessions(), ids);
    come("ann", "three");
    EXPECT_EQ(host.host.sessions(), (std::vector{ids[1], ids[2], ids[3]}));
    // Another session of the same character takes its own place.
    come("ann", "two");
    EXPECT_EQ(host.host.sessions(), (std::vector{ids[1], ids[3], ids[4]}));
}

TEST(Login, HasSoManyPlacesForAnAddress) {
    HostSettings settings = dev_settings();
    settings.max_per_address = 2;
    TestHost host(settings);
    const auto comes = [&host](std::array<std::uint8_t, 3> from) {
        FakeClient client(host);
        client.peer = mailbox::Address{};
        client.peer->ip[0] = 0x20;
        client.peer->ip[7] = from[0];   // the network
        client.peer->ip[15] = from[1];  // a machine in it
        client.peer->port = from[2];
        return client.log_in();
    };
    EXPECT_TRUE(comes({1, 1, 1}));
    EXPECT_TRUE(comes({1, 2, 1}));
    EXPECT_FALSE(comes({1, 3, 2}));
    EXPECT_EQ(host.rejected("login_address"), 1U);
    EXPECT_TRUE(comes({2, 1, 1}));
}

TEST(Login, RefusesNamesAndTeamsThatAreNotCleanUtf8) {
    TestHost host(dev_settings());
    for (const std::string& name : {std::string(),
                                    std::string(33, 'x'),
                                    std::string("a\nb"),
                                    std::string("   "),
                                    std::string("\xC0\xAF")}) {
        expect_refused(host,
                       hello_message(name),
                       proto::REFUSED_MALFORMED,
                       "login_malformed",
                       "the name must be");
    }
    proto::ClientMessage hello = hello_message();
    hello.mutable_hello()->set_team(std::string(33, 't'));
    expect_refused(host, hello, proto::REFUSED_MALFORMED, "login_malformed", "the team must be");
}

TEST(Login, InsistsOnHelloFirstAndInTime) {
    TestHost host(dev_settings());
    expect_refused(
        host, command_message(1, "x"), proto::REFUSED_MALFORMED, "hello_missing", "must be Hello");
    const StreamId silent = host.open();
    host.advance(9.5);
    EXPECT_EQ(host.closed.count(silent), 0U);
    host.advance(1.0);
    EXPECT_EQ(host.closed.count(silent), 1U);
    EXPECT_EQ(host.rejected("login_timeout"), 1U);
}

TEST(Login, CountsTheTimeFromTheConnectionOn) {
    TestHost host(dev_settings());
    const StreamId prompt = host.open();
    const StreamId slow = host.open(true, 4.0);
    host.advance(5.5);
    EXPECT_EQ(host.closed.count(slow), 0U);
    host.advance(1.0);
    EXPECT_EQ(host.closed.count(slow), 1U);
    EXPECT_EQ(host.closed.count(prompt), 0U);
    host.advance(4.0);
    EXPECT_EQ(host.closed.count(prompt), 1U);
}

TEST(Login, RefusesUnknownTokensAndEventsThatNeverWere) {
    TestHost host(dev_settings());
    proto::ClientMessage hello = hello_message();
    hello.mutable_hello()->set_resume_token(std::string(16, 'x'));
    expect_refused(host, hello, proto::REFUSED_RESUME, "login_resume", "log in anew");
    hello.mutable_hello()->set_resume_token("short");
    expect_refused(host, hello, proto::REFUSED_RESUME, "login_resume", "log in anew");

    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    host.take<mailbox::Join>();
    EXPECT_FALSE(client.resume(1));
    EXPECT_EQ(client.answer.refused().reason(), proto::REFUSED_RESUME);
}

TEST(Login, RefusesEverybodyWhileShuttingDownAndTellsThoseWhoAreThere) {
    TestHost host(dev_settings());
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    host.take<mailbox::Join>();
    const StreamId silent = host.open();
    host.host.shutdown("maintenance");
    for (const StreamId stream : {client.stream, silent}) {
        ASSERT_FALSE(host.frames[stream].empty());
        EXPECT_EQ(host.frames[stream].back().closing().reason(), proto::CLOSING_SHUTDOWN);
        EXPECT_EQ(host.frames[stream].back().closing().text(), "maintenance");
        EXPECT_EQ(host.closed.count(stream), 1U);
    }
    EXPECT_EQ(host.take<mailbox::Leave>().at(0).reason, mailbox::LeaveReason::kShutdown);
    expect_refused(
        host, hello_message(), proto::REFUSED_SHUTTING_DOWN, "login_shutdown", "shutting down");
}

TEST(Login, RefusesASettingOutOfRangeWithAReason) {
    HostSettings settings = dev_settings();
    settings.input_window_ticks = 100;
    EXPECT_THROW(TestHost host(settings), std::invalid_argument);
}

}  // namespace
}  // namespace zoned::session

// Sessions of a server whose inputs are kept for after a crash.
#include "server/session/login/secrets.h"
#include "tests/unit/session/fake_client.h"

#include <gtest/gtest.h>

namespace zoned::session {
namespace {

HostSettings journaled() {
    HostSettings settings = dev_settings();
    settings.journaled = true;
    settings.grace_s = 5.0;
    return settings;
}

Bytes digest_of(const std::string& token) {
    const auto digest = sha256({reinterpret_cast<const std::uint8_t*>(token.data()), token.size()});
    return {digest.begin(), digest.end()};
}

/// A session of a process before: three events were told, the client may lack two.
KeptSession kept_session(const std::string& token) {
    KeptSession kept;
    kept.begun = {ClientId(7), digest_of(token), "acc", "ann", "red", mailbox::kRightPlay, true};
    kept.commands = 4;
    std::vector<EventBody> bodies;
    for (const char* text : {"two", "three"}) {
        mailbox::EventOut event;
        event.kind = 16;
        event.payload.assign(text, text + std::string(text).size());
        bodies.push_back(encode_event_body(event));
    }
    kept.events = EventQueue(1, bodies);
    kept.joined = mailbox::Joined{ClientId(7), EntityId(12), ZoneId(1), 90};
    return kept;
}

TEST(JournaledSessions, TellTheWorldOfTheirBeginningWithoutTheSecret) {
    TestHost host(journaled());
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    ASSERT_EQ(host.inbox.size(), 2U);
    const auto& begun = std::get<mailbox::SessionBegun>(host.inbox[0]);
    EXPECT_TRUE(std::holds_alternative<mailbox::Join>(host.inbox[1])) << "its Join follows";
    EXPECT_EQ(begun.client, client.client);
    EXPECT_EQ(begun.name, "ann");
    EXPECT_FALSE(begun.ticketed) << "development mode";
    EXPECT_EQ(begun.token_digest, digest_of(client.token));
    TestHost plain(dev_settings());
    ASSERT_TRUE(FakeClient(plain).log_in());
    EXPECT_EQ(plain.inbox.size(), 1U) << "nobody keeps it";
}

TEST(JournaledSessions, AcknowledgeCommandsWhenTheyAreKept) {
    TestHost host(journaled());
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    host.send(client.stream, command_message(1, "a"));
    host.send(client.stream, command_message(2, "b"));
    EXPECT_EQ(host.take<mailbox::Command>().at(1).number, 2U);
    host.advance(0.04);
    EXPECT_EQ(host.frames[client.stream].back().command_ack().through(), 0U);
    host.host.on_outbox(mailbox::CommandsKept{client.client, 1}, host.now_s, host.now_s);
    client.drop();
    ASSERT_TRUE(client.resume(0));
    EXPECT_EQ(client.answer.welcome().last_command(), 1U);
    EXPECT_FALSE(client.answer.welcome().recovered());
    host.host.on_outbox(mailbox::CommandsKept{client.client, 2}, host.now_s, host.now_s);
    host.advance(0.04);
    EXPECT_EQ(host.frames[client.stream].back().command_ack().through(), 2U);
}

TEST(JournaledSessions, SayHowFarTheyHaveComeOnceATickAtMost) {
    TestHost host(journaled());
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    host.emit({client.client}, "one");
    host.emit({client.client}, "two");
    for (std::uint64_t through : {1, 2}) {
        proto::ClientMessage message;
        message.mutable_event_ack()->set_through(through);
        host.send(client.stream, message);
    }
    host.send(client.stream, command_message(1, std::string(5000, 'x')));  // refused, and used up
    host.advance(0.2);
    const auto progress = host.take<mailbox::SessionProgress>();
    ASSERT_EQ(progress.size(), 1U);
    EXPECT_EQ(progress[0].events, 2U);
    EXPECT_EQ(progress[0].commands, 1U);
}

TEST(RecoveredSessions, GoOnWhereTheClientStopped) {
    TestHost host(journaled());
    const std::string token(16, 't');
    host.host.restore(kept_session(token), host.now_s);
    host.host.number_sessions_after(ClientId(9));
    FakeClient client(host);
    client.token = std::string(16, 'u');
    EXPECT_FALSE(client.resume(1)) << "a token that nobody has";
    client.token = token;
    EXPECT_FALSE(client.resume(0)) << "the first event is forgotten";
    EXPECT_FALSE(client.resume(4)) << "there is no fourth";
    ASSERT_TRUE(client.resume(2));
    const proto::Welcome& welcome = client.answer.welcome();
    EXPECT_TRUE(welcome.resumed());
    EXPECT_TRUE(welcome.recovered());
    EXPECT_EQ(welcome.resume_token(), token) << "it stays the same";
    EXPECT_EQ(welcome.client_id(), 7U);
    EXPECT_EQ(welcome.last_command(), 4U);
    EXPECT_EQ(welcome.rights(), mailbox::kRightPlay);
    ASSERT_EQ(host.frames[client.stream].size(), 2U);
    EXPECT_EQ(host.frames[client.stream][0].joined().avatar(), 12U);
    EXPECT_EQ(host.frames[client.stream][1].event().number(), 3U);
    EXPECT_EQ(host.frames[client.stream][1].event().payload(), "three");
    // Commands go on behind the fourth, datagrams begin anew under the new keys.
    host.send(client.stream, command_message(5, "e"));
    EXPECT_EQ(host.take<mailbox::Command>().size(), 1U);
    host.advance(0.04);
    client.send_datagram(commands_at(host.tick + 1, 1));
    EXPECT_EQ(host.take<mailbox::Input>().size(), 1U);
    client.state(100001);
    ASSERT_EQ(host.datagrams.size(), 1U);
    EXPECT_TRUE(client.open(host.datagrams[0].bytes, 100001));
    for (int again = 0; again < 2; ++again) {
        client.drop();
        ASSERT_TRUE(client.resume(3));
        EXPECT_FALSE(client.answer.welcome().recovered()) << "it came back since";
        EXPECT_EQ(client.answer.welcome().resume_token(), token);
    }
    FakeClient other(host);
    ASSERT_TRUE(other.log_in());
    EXPECT_EQ(other.client, ClientId(10));
}

TEST(RecoveredSessions, LeaveWhenNobodyComesBack) {
    TestHost host(journaled());
    host.host.restore(kept_session(std::string(16, 't')), host.now_s);
    host.advance(4.9);
    EXPECT_TRUE(host.take<mailbox::Leave>().empty());
    host.advance(0.3);
    const auto left = host.take<mailbox::Leave>();
    ASSERT_EQ(left.size(), 1U);
    EXPECT_EQ(left[0].client, ClientId(7));
    EXPECT_EQ(left[0].reason, mailbox::LeaveReason::kTimeout);
}

}  // namespace
}  // namespace zoned::session

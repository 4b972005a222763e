#include "tests/unit/session/fake_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace zoned::session {
namespace {

std::vector<std::uint64_t> event_numbers(TestHost& host, StreamId stream) {
    std::vector<std::uint64_t> out;
    for (const auto& message : host.frames[stream]) {
        if (message.has_event()) {
            out.push_back(message.event().number());
        }
    }
    return out;
}

class Sessions : public testing::Test {
  protected:
    Sessions() {
        HostSettings settings = dev_settings();
        settings.dev_rights = mailbox::kRightPlay;
        host = std::make_unique<TestHost>(settings);
        client = std::make_unique<FakeClient>(*host);
        EXPECT_TRUE(client->log_in());
        host->take<mailbox::Join>();
    }

    void restart(const HostSettings& settings) {
        host = std::make_unique<TestHost>(settings);
        client = std::make_unique<FakeClient>(*host);
        ASSERT_TRUE(client->log_in());
        host->take<mailbox::Join>();
    }

    void ack(std::uint64_t through) {
        proto::ClientMessage message;
        message.mutable_event_ack()->set_through(through);
        host->send(client->stream, message);
    }

    [[nodiscard]] const proto::ServerMessage& last() const {
        return host->frames.at(client->stream).back();
    }

    std::unique_ptr<TestHost> host;
    std::unique_ptr<FakeClient> client;
};

TEST_F(Sessions, SendEventsAtOnceAndAgainAfterAReconnectFromWhereTheClientStopped) {
    for (const char* text : {"one", "two", "three"}) {
        host->emit({client->client}, text);
    }
    EXPECT_EQ(event_numbers(*host, client->stream), (std::vector<std::uint64_t>{1, 2, 3}));
    const proto::Event event = last().event();
    EXPECT_EQ(event.payload(), "three");
    EXPECT_EQ(event.event_id(), 3U);
    EXPECT_EQ(event.kind(), 16U);
    EXPECT_EQ(event.tick(), host->tick);
    ack(1);
    client->drop();
    host->emit({client->client}, "four");
    ASSERT_TRUE(client->resume(2));
    EXPECT_TRUE(client->answer.welcome().resumed());
    EXPECT_FALSE(client->answer.welcome().has_world());
    EXPECT_EQ(event_numbers(*host, client->stream), (std::vector<std::uint64_t>{3, 4}));
    EXPECT_EQ(host->host.stats().resumed, 1U);
    EXPECT_TRUE(host->take<mailbox::Join>().empty());
    // Acknowledged messages are gone: a client that wants them again has to log in anew.
    client->drop();
    EXPECT_FALSE(client->resume(1));
}

TEST_F(Sessions, CountAcknowledgementsOfEventsThatWereNeverSent) {
    host->emit({client->client}, "one");
    ack(2);
    EXPECT_EQ(host->rejected("event_ack_ahead"), 1U);
    client->drop();
    ASSERT_TRUE(client->resume(0));
    EXPECT_EQ(event_numbers(*host, client->stream), (std::vector<std::uint64_t>{1}));
}

TEST_F(Sessions, EndWhenTooManyEventsWait) {
    HostSettings settings = dev_settings();
    settings.max_unacked_events = 10;
    restart(settings);
    for (int i = 0; i < 11; ++i) {
        host->emit({client->client}, "x");
    }
    EXPECT_EQ(host->rejected("events_overflow"), 1U);
    EXPECT_EQ(last().closing().reason(), proto::CLOSING_PROTOCOL);
    EXPECT_EQ(host->take<mailbox::Leave>().size(), 1U);
    EXPECT_TRUE(host->host.sessions().empty());
}

TEST_F(Sessions, PassCommandsOnOnceAndInOrderAndAcknowledgeThem) {
    host->send(client->stream, command_message(1, "a"));
    host->send(client->stream, command_message(2, "b"));
    host->send(client->stream, command_message(1, "a"));
    const auto commands = host->take<mailbox::Command>();
    ASSERT_EQ(commands.size(), 2U);
    EXPECT_EQ(commands[1].payload, Bytes{'b'});
    EXPECT_EQ(commands[1].kind, 5);
    EXPECT_EQ(host->rejected("command_duplicate"), 1U);
    host->advance(0.04);
    EXPECT_EQ(last().command_ack().through(), 2U);
    client->drop();
    ASSERT_TRUE(client->resume(0));
    EXPECT_EQ(client->answer.welcome().last_command(), 2U);
    host->send(client->stream, command_message(4, "d"));
    EXPECT_EQ(host->rejected("command_gap"), 1U);
    EXPECT_EQ(last().closing().reason(), proto::CLOSING_PROTOCOL);
    EXPECT_EQ(host->closed.count(client->stream), 1U);
}

TEST_F(Sessions, RefuseCommandsThatAreTooManyTooLongOrOfNoKind) {
    for (std::uint64_t n = 1; n <= 50; ++n) {
        host->send(client->stream, command_message(n, "x"));
    }
    EXPECT_EQ(host->take<mailbox::Command>().size(), 40U);  // two seconds' worth at 20 a second
    EXPECT_EQ(host->rejected("command_flood"), 10U);
    host->advance(1.0);
    host->send(client->stream, command_message(51, std::string(4097, 'x')));
    EXPECT_EQ(host->rejected("command_size"), 1U);
    host->send(client->stream, command_message(52, "x", 65536));
    EXPECT_EQ(host->rejected("command_kind"), 1U);
    host->send(client->stream, command_message(53, "x", 65535));
    EXPECT_EQ(host->take<mailbox::Command>().size(), 1U);
}

TEST_F(Sessions, PassOnEachConfirmationOnce) {
    host->emit({client->client}, "die", true);
    EXPECT_TRUE(last().event().confirm());
    proto::ClientMessage message;
    message.mutable_confirm()->set_event_id(1);
    host->send(client->stream, message);
    host->send(client->stream, message);
    EXPECT_EQ(host->take<mailbox::Confirm>().size(), 1U);
    EXPECT_EQ(host->rejected("confirm_unknown"), 1U);
}

TEST_F(Sessions, LetOnlyThoseWithTheRightFreezeAndAudit) {
    proto::ClientMessage freeze;
    freeze.mutable_freeze()->set_on(true);
    proto::ClientMessage audit;
    audit.mutable_audit();
    mailbox::AuditRecord record;
    record.client = client->client;
    record.entities.emplace_back();
    host->send(client->stream, freeze);
    host->send(client->stream, audit);
    host->host.on_outbox(record, host->now_s, 0.0);
    EXPECT_TRUE(host->inbox.empty());
    EXPECT_TRUE(host->frames[client->stream].empty());
    EXPECT_EQ(host->rejected("freeze_no_right"), 1U);
    EXPECT_EQ(host->rejected("audit_no_right"), 1U);
    EXPECT_EQ(host->rejected("out_audit_no_right"), 1U);

    HostSettings settings = dev_settings();
    settings.dev_rights = mailbox::kRightPlay | mailbox::kRightAudit | mailbox::kRightFreeze;
    restart(settings);
    host->send(client->stream, freeze);
    host->send(client->stream, audit);
    EXPECT_EQ(host->take<mailbox::Freeze>().size(), 1U);
    EXPECT_EQ(host->take<mailbox::AuditRequest>().size(), 1U);
    record.client = client->client;
    record.entities[0].entity = EntityId{7};
    record.entities[0].quantized = {1, -2, 3};
    record.frozen = true;
    host->host.on_outbox(record, host->now_s, 0.0);
    ASSERT_TRUE(last().has_audit());
    EXPECT_TRUE(last().audit().frozen());
    EXPECT_EQ(last().audit().entities(0).entity(), 7U);
    EXPECT_EQ(last().audit().entities(0).quantized(1), -2);
}

TEST_F(Sessions, LimitHowOftenAViewIsReset) {
    proto::ClientMessage message;
    message.mutable_view_reset()->set_reason("diverged");
    for (int i = 0; i < 10; ++i) {
        host->send(client->stream, message);
    }
    EXPECT_EQ(host->take<mailbox::ViewReset>().size(), 6U);
    EXPECT_EQ(host->rejected("view_reset_flood"), 4U);
}

TEST_F(Sessions, TellWhereTheClientPlaysAndTellItAgainAfterAReconnect) {
    host->host.on_outbox(
        mailbox::Joined{client->client, EntityId{9}, ZoneId{2}, 77}, host->now_s, 0.0);
    EXPECT_EQ(last().joined().avatar(), 9U);
    client->drop();
    host->host.on_outbox(
        mailbox::Joined{client->client, EntityId{11}, ZoneId{1}, 99}, host->now_s, 0.0);
    ASSERT_TRUE(client->resume(0));
    ASSERT_FALSE(host->frames[client->stream].empty());
    EXPECT_EQ(host->frames[client->stream].front().joined().avatar(), 11U);
}

TEST_F(Sessions, WaitForTheirClientAsLongAsTheGraceTimeAndNoLonger) {
    client->drop();
    host->advance(29.5);
    EXPECT_TRUE(host->take<mailbox::Leave>().empty());
    ASSERT_TRUE(client->resume(0));
    client->drop();
    host->advance(30.5);
    const auto leaves = host->take<mailbox::Leave>();
    ASSERT_EQ(leaves.size(), 1U);
    EXPECT_EQ(leaves[0].reason, mailbox::LeaveReason::kTimeout);
    EXPECT_FALSE(client->resume(0));
    EXPECT_EQ(client->answer.refused().reason(), proto::REFUSED_RESUME);
}

TEST_F(Sessions, EndAtOnceWhenTheClientQuits) {
    proto::ClientMessage quit;
    quit.mutable_quit();
    host->send(client->stream, quit);
    EXPECT_EQ(host->take<mailbox::Leave>().at(0).reason, mailbox::LeaveReason::kQuit);
    EXPECT_EQ(host->closed.count(client->stream), 1U);
    EXPECT_TRUE(host->host.sessions().empty());
    host->host.on_stream_closed(client->stream, host->now_s);
    EXPECT_FALSE(client->resume(0));
}

TEST_F(Sessions, LoseTheirStreamWhenNothingIsHeardButNotTheirPlace) {
    host->advance(14.0);
    client->send_datagram({});  // a datagram is a sign of life too
    host->advance(14.0);
    EXPECT_EQ(host->closed.count(client->stream), 0U);
    host->advance(1.5);
    EXPECT_EQ(host->closed.count(client->stream), 1U);
    EXPECT_EQ(last().closing().reason(), proto::CLOSING_TIMEOUT);
    EXPECT_EQ(host->rejected("silence"), 1U);
    EXPECT_TRUE(client->resume(0));
}

TEST_F(Sessions, MoveToANewStreamWhileTheOldOneStillLives) {
    const StreamId old = client->stream;
    ASSERT_TRUE(client->resume(0));
    EXPECT_EQ(host->frames[old].back().closing().reason(), proto::CLOSING_REPLACED);
    EXPECT_EQ(host->closed.count(old), 1U);
    host->send(old, command_message(1, "late"));
    EXPECT_EQ(host->rejected("frame_no_stream"), 1U);
    host->host.on_stream_closed(old, host->now_s);  // must not begin the grace time
    for (int i = 0; i < 4; ++i) {
        host->advance(10.0);
        client->send_datagram({});
    }
    EXPECT_EQ(host->host.sessions().size(), 1U);
    EXPECT_TRUE(host->take<mailbox::Command>().empty());
}

TEST_F(Sessions, EndWhenTheRulesThrowTheClientOut) {
    host->host.on_outbox(mailbox::Kick{client->client,
                                       "ch\xFF"
                                       "eating"},
                         host->now_s,
                         0.0);
    EXPECT_EQ(last().closing().reason(), proto::CLOSING_KICKED);
    EXPECT_EQ(last().closing().text(), "ch?eating");
    EXPECT_EQ(host->take<mailbox::Leave>().at(0).reason, mailbox::LeaveReason::kKicked);
    EXPECT_FALSE(client->resume(0));
}

TEST_F(Sessions, CloseTheStreamOfWhoBreaksTheProtocol) {
    const auto closes = [&](const char* counter, const auto& act) {
        const std::uint64_t before = host->rejected(counter);
        act();
        EXPECT_EQ(host->rejected(counter), before + 1) << counter;
        EXPECT_EQ(last().closing().reason(), proto::CLOSING_PROTOCOL) << counter;
        EXPECT_EQ(host->closed.count(client->stream), 1U) << counter;
        ASSERT_TRUE(client->resume(0)) << counter;
    };
    closes("frame_malformed", [&] {
        const Bytes junk(5, 0xFF);
        host->host.on_frame(client->stream, junk, host->now_s);
    });
    closes("frame_oversize",
           [&] { host->host.on_frame(client->stream, Bytes(65537, 0), host->now_s); });
    closes("hello_again", [&] { host->send(client->stream, hello_message()); });
    closes("frame_flood", [&] {
        proto::ClientMessage message;
        message.mutable_event_ack();
        for (int i = 0; host->closed.count(client->stream) == 0 && i < 900; ++i) {
            host->send(client->stream, message);
        }
    });
    host->advance(0.1);
    host->send(client->stream, proto::ClientMessage());
    EXPECT_EQ(host->rejected("frame_empty"), 1U);
    EXPECT_EQ(host->closed.count(client->stream), 0U);
}

TEST(Faults, DropAnEventByUsingUpItsNumberAndDoubleOneUnderTheNext) {
    HostSettings settings = dev_settings();
    settings.testing.drop_event_probability = 0.2;
    settings.testing.seed = 3;
    for (const bool doubling : {false, true}) {
        if (doubling) {
            settings.testing.drop_event_probability = 0.0;
            settings.testing.double_event_probability = 0.2;
        }
        TestHost host(settings);
        FakeClient client(host);
        ASSERT_TRUE(client.log_in());
        std::size_t gaps = 0;
        std::size_t doubles = 0;
        for (int i = 0; i < 1000; ++i) {
            host.emit({client.client}, std::to_string(i));
        }
        std::uint64_t number = 0;
        std::uint64_t id = 0;
        for (const auto& message : host.frames[client.stream]) {
            gaps += message.event().number() - number - 1;
            doubles += message.event().event_id() == id ? 1 : 0;
            number = message.event().number();
            id = message.event().event_id();
        }
        // Binomial with 1,000 trials of 0.2: standard deviation 12.6; five of them.
        EXPECT_NEAR(static_cast<double>(doubling ? doubles : gaps), 200.0, 63.0);
        EXPECT_EQ(doubling ? gaps : doubles, 0U);
    }
}

}  // namespace
}  // namespace zoned::session

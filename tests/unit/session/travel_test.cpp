// Sessions of a server in a cluster: logins that belong elsewhere, and characters that leave.
#include "tests/unit/session/fake_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace zoned::session {
namespace {

class OfACluster : public ::testing::Test {
  protected:
    static HostSettings settings(const KeyPair& pair) {
        HostSettings out;
        out.ticket_keys = {pair.public_key};
        out.config_digest = "c0ffee";
        out.world_name = out.audience = "castle";
        return out;
    }

    proto::ClientMessage hello(const std::string& world, const KeyPair& key) const {
        TicketClaims claims;
        claims.account = "ann";
        claims.name = "Ann";
        claims.rights = mailbox::kRightPlay;
        claims.not_before_s = 900;
        claims.expires_s = 2000;
        claims.nonce = random_nonce();
        claims.world = world;
        const auto ticket = create_ticket(claims, key.private_key);
        proto::ClientMessage message = hello_message();
        message.mutable_hello()->set_ticket(ticket->data(), ticket->size());
        return message;
    }

    static proto::Redirect to_meadow() {
        proto::Redirect redirect;
        redirect.set_world("meadow");
        redirect.set_host("h");
        redirect.set_tcp_port(5);
        return redirect;
    }

    KeyPair operators = generate_key_pair();
    KeyPair cluster = generate_key_pair();
    std::vector<LoginToStore> logins;
    TestHost host{settings(operators), {}, [this](const LoginToStore& l) {
                      logins.push_back(l);
                  }};
};

TEST_F(OfACluster, AClientOfAnotherWorldIsToldThatNobodyHasIt) {
    FakeClient client(host);
    proto::ClientMessage message = hello("", operators);
    message.mutable_hello()->set_world("meadow");
    EXPECT_FALSE(client.log_in(message, false));
    EXPECT_EQ(client.answer.refused().reason(), proto::REFUSED_ELSEWHERE);
    EXPECT_FALSE(client.answer.refused().has_redirect());
    EXPECT_EQ(host.rejected("login_elsewhere"), 1U);
    EXPECT_TRUE(logins.empty());
    message.mutable_hello()->set_world("castle");
    EXPECT_FALSE(client.log_in(message, false));  // it waits to be stored
    EXPECT_EQ(logins.size(), 1U);
}

TEST_F(OfACluster, TheClustersKeyOpensNothingButTheWorldThatItsTicketNames) {
    FakeClient client(host);
    EXPECT_FALSE(client.log_in(hello("castle", cluster), false));
    EXPECT_EQ(client.answer.refused().reason(), proto::REFUSED_TICKET) << "not trusted yet";
    host.host.trust_cluster(cluster.public_key);
    for (const char* world : {"meadow", ""}) {
        FakeClient other(host);
        EXPECT_FALSE(other.log_in(hello(world, cluster), false));
        EXPECT_EQ(other.answer.refused().reason(), proto::REFUSED_TICKET) << world;
    }
    EXPECT_TRUE(logins.empty());
    FakeClient good(host);
    EXPECT_FALSE(good.log_in(hello("castle", cluster), false));
    ASSERT_EQ(logins.size(), 1U);
    host.host.on_login_stored(good.stream, true, std::nullopt, host.now_s);
    const proto::Welcome& welcome = host.frames[good.stream].front().welcome();
    EXPECT_EQ(welcome.world_name(), "castle");
    // The operator's key may name a world too, and then opens no other.
    FakeClient wrong(host);
    EXPECT_FALSE(wrong.log_in(hello("meadow", operators), false));
    EXPECT_THAT(wrong.answer.refused().text(), testing::HasSubstr("for the world meadow"));
}

TEST_F(OfACluster, ALoginThatIsSentElsewhereMayComeAgainWithItsTicket) {
    const proto::ClientMessage message = hello("", operators);
    FakeClient client(host);
    EXPECT_FALSE(client.log_in(message, false));
    ASSERT_TRUE(host.host.waiting_login(client.stream));
    EXPECT_EQ(host.host.waiting_login(client.stream)->account, "ann");
    const proto::Redirect redirect = to_meadow();
    host.host.refuse_login(client.stream, "over there", &redirect);
    const proto::Refused& refused = host.frames[client.stream].front().refused();
    EXPECT_EQ(refused.reason(), proto::REFUSED_ELSEWHERE);
    EXPECT_EQ(refused.redirect().world(), "meadow");
    EXPECT_EQ(refused.redirect().tcp_port(), 5U);
    EXPECT_FALSE(host.host.waiting_login(client.stream));
    FakeClient again(host);
    EXPECT_FALSE(again.log_in(message, false));
    EXPECT_EQ(logins.size(), 2U) << "the ticket was not used up";
    host.host.refuse_login(again.stream, "not now", nullptr);
    EXPECT_EQ(host.frames[again.stream].front().refused().reason(), proto::REFUSED_SHUTTING_DOWN);
    host.host.refuse_login(again.stream, "twice", nullptr);  // nothing waits any more
}

TEST_F(OfACluster, ACharacterLeavesOnceAndItsClientIsToldWhereItGoesOn) {
    FakeClient client(host);
    EXPECT_FALSE(client.log_in(hello("", operators), false));
    host.host.on_login_stored(client.stream, true, std::nullopt, host.now_s);
    const ClientId id{host.frames[client.stream].front().welcome().client_id()};
    const std::string token = host.frames[client.stream].front().welcome().resume_token();
    host.frames[client.stream].clear();
    ASSERT_TRUE(host.host.traveller(id));
    EXPECT_EQ(host.host.traveller(id)->name, "Ann");
    EXPECT_TRUE(host.host.begin_travel(id));
    EXPECT_FALSE(host.host.begin_travel(id));
    EXPECT_FALSE(host.host.traveller(id));
    EXPECT_EQ(host.take<mailbox::Leave>().size(), 1U);
    // It cannot come back meanwhile: its avatar is away.
    FakeClient other(host);
    proto::ClientMessage back = hello_message();
    back.mutable_hello()->set_resume_token(token);
    EXPECT_FALSE(other.log_in(back, false));
    EXPECT_EQ(other.answer.refused().reason(), proto::REFUSED_RESUME);

    host.host.redirect(id, "gone", to_meadow());
    const proto::Closing& closing = host.frames[client.stream].front().closing();
    EXPECT_EQ(closing.reason(), proto::CLOSING_ELSEWHERE);
    EXPECT_EQ(closing.redirect().world(), "meadow");
    EXPECT_TRUE(host.take<mailbox::Leave>().empty()) << "it left already";
    EXPECT_TRUE(host.host.sessions().empty());
    host.host.redirect(id, "gone", to_meadow());  // nobody is there
    EXPECT_TRUE(host.ok);
}

TEST_F(OfACluster, AnAccountsOtherSessionsEndWhenOneOfItTravels) {
    std::vector<ClientId> ids;
    for (const char* name : {"one", "two", "three"}) {
        TicketClaims claims;
        claims.account = std::string(name) == "three" ? "bob" : "ann";
        claims.name = name;
        claims.rights = mailbox::kRightPlay;
        claims.expires_s = 2000;
        claims.nonce = random_nonce();
        const auto ticket = create_ticket(claims, operators.private_key);
        proto::ClientMessage message = hello_message();
        message.mutable_hello()->set_ticket(ticket->data(), ticket->size());
        FakeClient client(host);
        EXPECT_FALSE(client.log_in(message, false));
        host.host.on_login_stored(client.stream, true, std::nullopt, host.now_s);
        ids.push_back(ClientId{host.frames[client.stream].front().welcome().client_id()});
    }
    EXPECT_EQ(host.host.end_account("ann", ids[0], "away"), 1U);
    EXPECT_EQ(host.host.sessions(), (std::vector<ClientId>{ids[0], ids[2]}));
    const auto left = host.take<mailbox::Leave>();
    ASSERT_EQ(left.size(), 1U);
    EXPECT_EQ(left[0].client, ids[1]);
}

}  // namespace
}  // namespace zoned::session

// Logins that are kept: nobody is let in before the store has the login, and no ticket opens twice.
#include "tests/unit/session/fake_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace zoned::session {
namespace {

class StoredLogin : public ::testing::Test {
  protected:
    StoredLogin()
        : host(settings(), {}, [this](const LoginToStore& login) { asked.push_back(login); }) {}

    HostSettings settings() {
        HostSettings out;
        out.ticket_keys = {pair.public_key};
        out.config_digest = "c0ffee";
        return out;
    }

    proto::ClientMessage hello(const std::string& account) {
        TicketClaims claims;
        claims.account = account;
        claims.name = "hero";
        claims.rights = mailbox::kRightPlay;
        claims.not_before_s = 900;
        claims.expires_s = 2000;
        claims.nonce = random_nonce();
        const auto ticket = *create_ticket(claims, pair.private_key);
        proto::ClientMessage message = hello_message();
        message.mutable_hello()->set_ticket(ticket.data(), ticket.size());
        return message;
    }

    void stored(bool good = true, std::optional<std::array<double, 3>> place = std::nullopt) {
        ASSERT_FALSE(asked.empty());
        host.host.on_login_stored(asked.back().stream, good, place, host.now_s);
    }

    KeyPair pair = generate_key_pair();
    std::vector<LoginToStore> asked;
    TestHost host;
};

TEST_F(StoredLogin, LetsNobodyInBeforeTheLoginIsStored) {
    FakeClient client(host);
    EXPECT_FALSE(client.log_in(hello("ann")));
    ASSERT_EQ(asked.size(), 1U);
    EXPECT_EQ(asked[0].account, "ann");
    EXPECT_EQ(asked[0].character, "hero");
    EXPECT_EQ(asked[0].expires_s, 2000);
    EXPECT_TRUE(host.host.sessions().empty());
    EXPECT_TRUE(host.take<mailbox::Join>().empty());
    stored(true, {{1.0, 2.0, -3.0}});
    ASSERT_FALSE(host.frames[client.stream].empty());
    EXPECT_TRUE(host.frames[client.stream].front().has_welcome());
    const auto joins = host.take<mailbox::Join>();
    ASSERT_EQ(joins.size(), 1U);
    EXPECT_EQ(joins[0].account, "ann");
    EXPECT_TRUE(joins[0].placed);
    EXPECT_EQ(joins[0].spawn[2], -3.0);
    host.host.on_login_stored(client.stream, true, std::nullopt, host.now_s);
    EXPECT_TRUE(host.take<mailbox::Join>().empty()) << "a second answer is nothing";
}

TEST_F(StoredLogin, TheSameTicketIsRefusedWhileTheFirstIsBeingStored) {
    const proto::ClientMessage once = hello("ann");
    FakeClient first(host);
    first.log_in(once);
    FakeClient second(host);
    EXPECT_FALSE(second.log_in(once));
    EXPECT_THAT(second.answer.refused().text(), testing::HasSubstr("used before"));
    EXPECT_EQ(asked.size(), 1U);
}

TEST_F(StoredLogin, ATicketFromBeforeTheStartIsRefused) {
    FakeClient first(host);
    const proto::ClientMessage once = hello("ann");
    first.log_in(once);
    std::vector<LoginToStore> nothing;
    TestHost next(settings(), {}, [&](const LoginToStore& login) { nothing.push_back(login); });
    next.host.remember_ticket(asked[0].nonce, asked[0].expires_s);
    FakeClient again(next);
    EXPECT_FALSE(again.log_in(once));
    EXPECT_THAT(again.answer.refused().text(), testing::HasSubstr("used before"));
    EXPECT_TRUE(nothing.empty());
}

TEST_F(StoredLogin, SaysWhenALoginCannotBeStored) {
    FakeClient client(host);
    client.log_in(hello("ann"));
    stored(false);
    ASSERT_FALSE(host.frames[client.stream].empty());
    EXPECT_THAT(host.frames[client.stream].front().refused().text(),
                testing::HasSubstr("cannot store logins"));
    EXPECT_EQ(host.rejected("login_not_stored"), 1U);
    EXPECT_TRUE(host.host.sessions().empty());
}

TEST_F(StoredLogin, ABanThatComesMeanwhileCounts) {
    FakeClient client(host);
    client.log_in(hello("ann"));
    host.host.ban({"ann", 0, "cheats"});
    stored();
    EXPECT_THAT(host.frames[client.stream].front().refused().text(),
                testing::HasSubstr("banned: cheats"));
}

TEST_F(StoredLogin, AClientThatTalksWhileItWaitsIsClosed) {
    FakeClient client(host);
    client.log_in(hello("ann"));
    host.send(client.stream, hello("ann"));
    EXPECT_EQ(host.rejected("hello_again"), 1U);
    EXPECT_EQ(host.closed.count(client.stream), 1U);
    stored();
    EXPECT_TRUE(host.host.sessions().empty());
}

TEST_F(StoredLogin, AClientThatDoesNotWaitIsForgotten) {
    FakeClient client(host);
    client.log_in(hello("ann"));
    client.drop();
    stored();
    EXPECT_TRUE(host.host.sessions().empty());
    EXPECT_TRUE(host.take<mailbox::Join>().empty());
}

TEST_F(StoredLogin, ACharacterIsInTheWorldOnceAndOthersStay) {
    FakeClient ann(host);
    ann.log_in(hello("ann"));
    stored();
    FakeClient bob(host);
    bob.log_in(hello("bob"));
    stored();
    EXPECT_EQ(host.host.sessions().size(), 2U);
    FakeClient again(host);
    again.log_in(hello("ann"));
    EXPECT_EQ(host.take<mailbox::Leave>().size(), 1U) << "before the new login reads what it left";
    stored();
    EXPECT_EQ(host.host.sessions().size(), 2U);
    EXPECT_EQ(host.take<mailbox::Join>().size(), 3U);
}

}  // namespace
}  // namespace zoned::session

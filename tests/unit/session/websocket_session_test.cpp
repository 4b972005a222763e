// Sessions whose stream is a WebSocket: states and inputs travel inside it, unsealed, from the
// first on.
#include "tests/unit/session/fake_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace zoned::session {
namespace {

class WebSocketSession : public testing::Test {
  protected:
    WebSocketSession() : host(dev_settings()), client(host) {}

    bool log_in(proto::ClientMessage hello = hello_message(), bool local = true) {
        const StreamId stream{++host.last_stream};
        host.host.on_websocket_open(stream, local, host.now_s);
        client.stream = stream;
        client.down.emplace(wire::Seal::none());
        client.up.emplace(wire::Seal::none());
        host.send(stream, hello);
        auto& queue = host.frames[stream];
        if (queue.empty() || !queue.front().has_welcome()) {
            return false;
        }
        client.answer = queue.front();
        queue.pop_front();
        client.client = ClientId{client.answer.welcome().client_id()};
        client.connection = client.answer.welcome().connection_id();
        client.token = client.answer.welcome().resume_token();
        host.take<mailbox::Join>();
        return true;
    }

    bool come_back() {
        proto::ClientMessage hello = hello_message();
        hello.mutable_hello()->set_resume_token(client.token);
        return log_in(hello);
    }

    /// A datagram inside the stream.
    void send_inside(const std::vector<motion::InputCommand>& commands) {
        const Bytes datagram = client.make_datagram(++client.sequence, commands);
        proto::ClientMessage message;
        message.mutable_datagram()->set_sealed(datagram.data(), datagram.size());
        host.send(client.stream, message);
    }

    /// State packets that the stream has carried.
    std::vector<Bytes> carried() {
        std::vector<Bytes> out;
        for (const proto::ServerMessage& message : host.frames[client.stream]) {
            if (message.has_datagram()) {
                const std::string& bytes = message.datagram().sealed();
                out.emplace_back(bytes.begin(), bytes.end());
            }
        }
        return out;
    }

    TestHost host;
    FakeClient client;
};

TEST_F(WebSocketSession, HearsStatesAtOnceAndUnsealed) {
    ASSERT_TRUE(log_in());
    client.state(1);
    client.state(2);
    const std::vector<Bytes> packets = carried();
    ASSERT_EQ(packets.size(), 2U);
    EXPECT_TRUE(client.open(packets[0], 1));
    // Header, transport and body as they are, and zeros where a tag would stand.
    const Bytes& packet = packets[0];
    ASSERT_EQ(packet.size(),
              wire::kDatagramHeaderBytes + wire::kDownTransportBytes + 20 + wire::kSealTagBytes);
    EXPECT_EQ(Bytes(packet.end() - 36, packet.end() - 16), Bytes(20, 7));
    EXPECT_EQ(Bytes(packet.end() - 16, packet.end()), Bytes(16, 0));
    EXPECT_TRUE(host.datagrams.empty());
    EXPECT_EQ(host.host.stats().tunnelled, 2U);
}

TEST_F(WebSocketSession, TakesInputsInsideAndNoneByUdp) {
    ASSERT_TRUE(log_in());
    host.advance(0.1);
    send_inside(commands_at(host.tick + 1, 2));
    ASSERT_EQ(host.take<mailbox::Input>().size(), 1U);
    // Nothing proves who sent this.
    client.send_datagram(commands_at(host.tick + 3, 2));
    EXPECT_TRUE(host.take<mailbox::Input>().empty());
    EXPECT_EQ(host.rejected("not_authentic"), 1U);
    client.state(1);
    EXPECT_EQ(carried().size(), 1U);
    EXPECT_TRUE(host.datagrams.empty()) << "states follow a stranger's address";
    // A tag that is not zero is no canonical datagram.
    Bytes odd = client.make_datagram(++client.sequence, commands_at(host.tick + 4, 1));
    odd.back() = 1;
    proto::ClientMessage message;
    message.mutable_datagram()->set_sealed(odd.data(), odd.size());
    host.send(client.stream, message);
    EXPECT_EQ(host.rejected("not_authentic"), 2U);
}

TEST_F(WebSocketSession, StatesWaitBehindEightKilobytesAtMost) {
    ASSERT_TRUE(log_in());
    host.backlog = 8192;
    client.state(1);
    host.backlog = 8193;
    client.state(2);
    host.backlog = 0;
    client.state(3);
    EXPECT_EQ(carried().size(), 2U);
    EXPECT_EQ(host.rejected("out_tunnel_backlog"), 1U);
}

TEST_F(WebSocketSession, NeedsATicketWhereItIsNotLocal) {
    EXPECT_FALSE(log_in(hello_message(), false));
    EXPECT_EQ(host.rejected("login_ticket"), 1U);
}

TEST_F(WebSocketSession, MovesBetweenATlsStreamAndAWebSocket) {
    ASSERT_TRUE(client.log_in());
    host.take<mailbox::Join>();
    host.advance(0.1);
    client.send_datagram(commands_at(host.tick + 1, 1));
    ASSERT_EQ(host.take<mailbox::Input>().size(), 1U);
    client.state(1);
    ASSERT_EQ(host.datagrams.size(), 1U);
    client.drop();
    ASSERT_TRUE(come_back());
    EXPECT_TRUE(client.answer.welcome().resumed());
    EXPECT_TRUE(client.answer.welcome().datagram_key_up().empty());
    client.state(2);
    ASSERT_EQ(carried().size(), 1U);
    EXPECT_EQ(host.datagrams.size(), 1U);
    // The keys of the stream before open nothing any more.
    client.up.emplace(client.up_key);
    client.send_datagram(commands_at(host.tick + 2, 1));
    EXPECT_TRUE(host.take<mailbox::Input>().empty());
    client.drop();
    ASSERT_TRUE(client.resume(0));
    client.send_datagram(commands_at(host.tick + 3, 1));
    ASSERT_EQ(host.take<mailbox::Input>().size(), 1U);
    client.state(3);
    ASSERT_EQ(host.datagrams.size(), 2U);
    EXPECT_TRUE(client.open(host.datagrams[1].bytes, 3));
}

}  // namespace
}  // namespace zoned::session

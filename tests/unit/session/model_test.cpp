// Randomised runs: events and commands exactly once and in order across any reconnects; hostile
// bytes.
#include "tests/unit/session/fake_client.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zoned::session {
namespace {

/// A client that keeps its side of the contract, over a network that loses all packets in flight
/// when a connection breaks.
struct ModelClient {
    explicit ModelClient(TestHost& host) : link(host) {}

    FakeClient link;
    bool connected = false;
    std::deque<proto::ClientMessage> under_way;  ///< to the host
    std::uint64_t last_event = 0;
    std::vector<std::string> events_expected;
    std::vector<std::string> events_heard;
    std::uint64_t last_command = 0;
    std::deque<proto::ClientMessage> unacknowledged;
    std::vector<std::string> commands_expected;
    std::vector<std::string> commands_done;
};

class Model {
  public:
    explicit Model(std::uint64_t seed) : host(settings()), rng(seed) {
        for (int i = 0; i < 5; ++i) {
            clients.push_back(std::make_unique<ModelClient>(host));
            EXPECT_TRUE(clients.back()->link.log_in());
            clients.back()->connected = true;
        }
        host.take<mailbox::Join>();
    }

    static HostSettings settings() {
        HostSettings s = dev_settings();
        s.max_commands_per_s = 1000;
        s.max_frames_per_s = 10000;
        s.grace_s = 1e6;
        s.silence_timeout_s = 1e6;
        return s;
    }

    void step() {
        ModelClient& c = *clients[rng.below(static_cast<std::uint32_t>(clients.size()))];
        switch (rng.below(8)) {
            case 0:
            case 1:
                emit();
                break;
            case 2:
            case 3:
                hear(c, rng.below(4));
                break;
            case 4:
                command(c);
                break;
            case 5:
                deliver(c, rng.below(4));
                break;
            case 6:
                if (rng.below(4) == 0) {
                    break_connection(c);
                }
                break;
            default:
                if (!c.connected) {
                    come_back(c);
                }
                break;
        }
        host.advance(0.01);
        collect();
    }

    void settle() {
        for (auto& c : clients) {
            if (!c->connected) {
                come_back(*c);
            }
            hear(*c, 100'000);
            deliver(*c, 100'000);
        }
        host.advance(0.1);
        collect();
    }

    TestHost host;
    core::Rng rng;
    std::vector<std::unique_ptr<ModelClient>> clients;
    std::uint64_t reconnects = 0;

  private:
    void emit() {
        std::vector<ClientId> to;
        const std::string text = "event " + std::to_string(++emitted_);
        for (auto& c : clients) {
            if (rng.below(2) == 0) {
                to.push_back(c->link.client);
                c->events_expected.push_back(text);
            }
        }
        host.emit(to, text);
    }

    void hear(ModelClient& c, std::uint32_t count) {
        auto& queue = host.frames[c.link.stream];
        for (; c.connected && count > 0 && !queue.empty(); --count) {
            const proto::ServerMessage message = queue.front();
            queue.pop_front();
            if (message.has_event()) {
                // The stream is ordered, so the next number is the only one that may come.
                EXPECT_EQ(message.event().number(), c.last_event + 1);
                c.last_event = message.event().number();
                c.events_heard.push_back(message.event().payload());
                if (rng.below(3) == 0) {
                    proto::ClientMessage ack;
                    ack.mutable_event_ack()->set_through(c.last_event);
                    c.under_way.push_back(ack);
                }
            } else if (message.has_command_ack()) {
                forget(c, message.command_ack().through());
            }
        }
    }

    static void forget(ModelClient& c, std::uint64_t through) {
        while (!c.unacknowledged.empty() &&
               c.unacknowledged.front().command().number() <= through) {
            c.unacknowledged.pop_front();
        }
    }

    void command(ModelClient& c) {
        const std::string text = "command " + std::to_string(++commanded_);
        c.unacknowledged.push_back(command_message(++c.last_command, text));
        c.commands_expected.push_back(text);
        if (c.connected) {
            c.under_way.push_back(c.unacknowledged.back());
        }
    }

    void deliver(ModelClient& c, std::uint32_t count) {
        for (; c.connected && count > 0 && !c.under_way.empty(); --count) {
            host.send(c.link.stream, c.under_way.front());
            c.under_way.pop_front();
        }
    }

    void break_connection(ModelClient& c) {
        c.connected = false;
        c.under_way.clear();  // lost
        if (rng.below(2) == 0) {
            c.link.drop();  // else the host does not notice before the client comes back
        }
    }

    void come_back(ModelClient& c) {
        ++reconnects;
        const StreamId old = c.link.stream;
        ASSERT_TRUE(c.link.resume(c.last_event));
        if (rng.below(2) == 0) {
            host.host.on_stream_closed(old, host.now_s);  // the late notice of the old stream
        }
        c.connected = true;
        forget(c, c.link.answer.welcome().last_command());
        for (const auto& message : c.unacknowledged) {
            c.under_way.push_back(message);
        }
    }

    void collect() {
        for (const auto& command : host.take<mailbox::Command>()) {
            for (auto& c : clients) {
                if (c->link.client == command.client) {
                    c->commands_done.emplace_back(command.payload.begin(), command.payload.end());
                }
            }
        }
    }

    std::uint64_t emitted_ = 0;
    std::uint64_t commanded_ = 0;
};

TEST(ReliableMessages, ArriveExactlyOnceAndInOrderAcrossRandomReconnects) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        Model model(seed);
        for (int i = 0; i < 4000; ++i) {
            model.step();
        }
        model.settle();
        EXPECT_TRUE(model.host.ok);
        EXPECT_GT(model.reconnects, 50U);
        for (const auto& c : model.clients) {
            EXPECT_EQ(c->events_heard, c->events_expected);
            EXPECT_EQ(c->commands_done, c->commands_expected);
            EXPECT_GT(c->events_heard.size(), 100U);
            EXPECT_GT(c->commands_done.size(), 50U);
        }
        EXPECT_EQ(model.host.rejected("command_gap"), 0U);
        EXPECT_EQ(model.host.host.sessions().size(), 5U);
    }
}

/// Changes, cuts, doubles or swaps some bytes.
Bytes mutate(Bytes bytes, core::Rng& rng) {
    const std::uint32_t changes = 1 + rng.below(4);
    for (std::uint32_t i = 0; i < changes && !bytes.empty(); ++i) {
        const std::size_t at = rng.below(static_cast<std::uint32_t>(bytes.size()));
        switch (rng.below(4)) {
            case 0:
                bytes[at] = static_cast<std::uint8_t>(rng.next());
                break;
            case 1:
                bytes.resize(at);
                break;
            case 2:
                bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                             static_cast<std::uint8_t>(rng.next()));
                break;
            default:
                bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1u << rng.below(8)));
                break;
        }
    }
    return bytes;
}

Bytes random_bytes_of(core::Rng& rng, std::uint32_t longest) {
    Bytes bytes(rng.below(longest + 1));
    for (auto& b : bytes) {
        b = static_cast<std::uint8_t>(rng.next());
    }
    return bytes;
}

std::vector<Bytes> seeds_of_frames(std::uint64_t number) {
    std::vector<proto::ClientMessage> messages(8);
    messages[0] = hello_message();
    messages[1] = command_message(number, "payload");
    messages[2].mutable_event_ack()->set_through(1);
    messages[3].mutable_confirm()->set_event_id(1);
    messages[4].mutable_view_reset()->set_reason("r");
    messages[5].mutable_freeze()->set_on(true);
    messages[6].mutable_audit();
    messages[7].mutable_datagram()->set_sealed(std::string(40, 'd'));
    std::vector<Bytes> out;
    for (const auto& message : messages) {
        const std::string text = message.SerializeAsString();
        out.emplace_back(text.begin(), text.end());
    }
    return out;
}

TEST(HostileBytes, InFramesNeverHarmTheHost) {
    core::Rng rng(11);
    HostSettings settings = dev_settings();
    settings.max_sessions = 50;
    settings.dev_rights = 0xF;
    TestHost host(settings);
    FakeClient honest(host);
    ASSERT_TRUE(honest.log_in());
    FakeClient hostile(host);
    for (int i = 0; i < 30'000; ++i) {
        if (!hostile.stream || host.closed.count(hostile.stream) != 0 || rng.below(200) == 0) {
            host.frames.erase(hostile.stream);
            hostile = FakeClient(host);
            if (rng.below(3) == 0) {
                hostile.stream = host.open();
            } else {
                hostile.log_in();
            }
        }
        const auto seeds = seeds_of_frames(rng.below(5));
        const Bytes bytes =
            rng.below(4) == 0
                ? random_bytes_of(rng, 64)
                : mutate(seeds[rng.below(static_cast<std::uint32_t>(seeds.size()))], rng);
        host.host.on_frame(hostile.stream, bytes, host.now_s);
        if (i % 10 == 0) {
            host.advance(0.03);
            honest.send_datagram({});
            host.inbox.clear();
        }
        ASSERT_TRUE(host.ok);
        ASSERT_LE(host.host.sessions().size(), 50U);
    }
    host.emit({honest.client}, "still here");
    EXPECT_EQ(host.frames[honest.stream].back().event().payload(), "still here");
}

TEST(HostileBytes, InDatagramsNeverHarmTheHostOrTheClientThatTheyPretendToBe) {
    core::Rng rng(12);
    TestHost host(dev_settings());
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    client.send_datagram({}, 1);
    std::uint64_t sent = 0;
    for (int i = 0; i < 50'000; ++i) {
        Bytes bytes;
        if (rng.below(3) == 0) {
            bytes = random_bytes_of(rng, 100);
            if (bytes.size() >= wire::kDatagramHeaderBytes) {
                wire::write_datagram_header({client.connection, 0}, bytes.data());
            }
        } else {
            const Bytes good = client.make_datagram(client.sequence + 1, commands_at(host.tick, 3));
            bytes = mutate(good, rng);
            if (bytes == good) {
                continue;
            }
        }
        ++sent;
        host.host.on_datagram(test_address(666), bytes, host.now_s);
    }
    std::uint64_t rejected = 0;
    for (const auto& [reason, count] : host.host.stats().rejected) {
        rejected += count;
    }
    EXPECT_EQ(rejected, sent);
    EXPECT_TRUE(host.take<mailbox::Input>().empty());
    client.state(1);
    EXPECT_EQ(host.datagrams.at(0).to.port, 1);
}

TEST(HostileBytes, SealedByAClientThatHoldsTheKeysNeverHarmTheHost) {
    core::Rng rng(13);
    TestHost host(dev_settings());
    FakeClient client(host);
    ASSERT_TRUE(client.log_in());
    for (int i = 0; i < 30'000; ++i) {
        host.now_s += 0.01;
        host.tick += i % 3 == 0 ? 1 : 0;
        host.host.tick(host.now_s, host.tick);
        Bytes plain(wire::kUpTransportBytes);
        wire::write_commands(commands_at(host.tick, 1 + static_cast<int>(rng.below(8))), plain);
        plain = rng.below(4) == 0 ? random_bytes_of(rng, 60) : mutate(plain, rng);
        host.host.on_datagram(test_address(1), client.seal(++client.sequence, plain), host.now_s);
        for (const auto& input : host.take<mailbox::Input>()) {
            for (const auto& command : input.commands) {
                ASSERT_GE(command.tick, host.tick - 8);
                ASSERT_LE(command.tick, host.tick + 32);
                ASSERT_GE(command.move_x, -127);
                ASSERT_LE(std::abs(command.pitch), 16384);
            }
        }
    }
    EXPECT_TRUE(host.take<mailbox::Acks>().empty());  // nothing was ever sent
}

}  // namespace
}  // namespace zoned::session

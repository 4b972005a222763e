// RunLedger: sessions go on in another process, and nothing is lost, doubled or out of order.
#include "server/app/recovery/run_ledger.h"

#include "server/app/storage/held_output.h"
#include "tests/unit/session/fake_client.h"
#include "shared/core/archive/field_archive.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace zoned::app {
namespace {

using session::FakeClient;
using session::TestHost;

session::HostSettings journaled_settings() {
    session::HostSettings settings = session::dev_settings();
    settings.journaled = true;
    settings.max_commands_per_s = 1000;
    return settings;
}

/// A client that says and hears things, and checks what it hears.
struct Talker {
    explicit Talker(TestHost& host) : fake(host) {}

    FakeClient fake;
    std::uint64_t sent = 0;   ///< commands
    std::uint64_t kept = 0;   ///< that the server acknowledged
    std::uint64_t heard = 0;  ///< events
    std::vector<std::string> texts;

    void read(TestHost& host) {
        auto& queue = host.frames[fake.stream];
        for (; !queue.empty(); queue.pop_front()) {
            const proto::ServerMessage& message = queue.front();
            if (message.has_event()) {
                ASSERT_EQ(message.event().number(), heard + 1) << "lost, doubled or out of order";
                heard = message.event().number();
                texts.push_back(message.event().payload());
            } else if (message.has_command_ack()) {
                ASSERT_LE(message.command_ack().through(), sent);
                kept = std::max(kept, message.command_ack().through());
            }
        }
    }
};

/// A world without space: it carries out commands, and tells everybody everything.
struct TinyWorld {
    std::set<ClientId> inside;
    std::map<ClientId, std::uint64_t> done;  ///< number of the newest command
    std::map<ClientId, std::vector<std::string>> told;
    std::uint64_t events = 0;

    std::vector<mailbox::OutboxItem> tick(const std::vector<mailbox::InboxItem>& in, Tick now) {
        std::vector<mailbox::OutboxItem> out;
        for (const mailbox::InboxItem& item : in) {
            if (const auto* join = std::get_if<mailbox::Join>(&item)) {
                inside.insert(join->client);
            } else if (const auto* leave = std::get_if<mailbox::Leave>(&item)) {
                inside.erase(leave->client);
            } else if (const auto* command = std::get_if<mailbox::Command>(&item)) {
                EXPECT_EQ(command->number, done[command->client] + 1) << "lost or done twice";
                done[command->client] = command->number;
                say(command->payload, now, out);
            }
        }
        return out;
    }

    void say(const mailbox::Bytes& payload, Tick now, std::vector<mailbox::OutboxItem>& out) {
        mailbox::EventOut event;
        event.event = EventId{++events};
        event.tick = now;
        event.kind = 16;
        event.payload = payload;
        event.recipients.assign(inside.begin(), inside.end());
        for (const ClientId client : inside) {
            told[client].emplace_back(payload.begin(), payload.end());
        }
        out.emplace_back(std::move(event));
    }
};

RunLedger as_saved(const RunLedger& ledger) {
    std::vector<std::uint8_t> bytes;
    core::FieldWriter writer(bytes);
    writer(const_cast<RunLedger&>(ledger));
    RunLedger out;
    core::FieldReader reader(bytes);
    reader(out);
    EXPECT_EQ(reader.wrong(), "");
    EXPECT_EQ(reader.left(), 0U);
    return out;
}

/// Kills the server at random moments, and looks whether anybody notices more than a pause.
class Crashes {
  public:
    explicit Crashes(std::uint64_t seed) : rng_(seed) {
        host_ = std::make_unique<TestHost>(settings_);
    }

    void run(int ticks) {
        for (int t = 0; t < ticks && !testing::Test::HasFailure(); ++t) {
            act();
            const bool dies_before_output = rng_.below(40) == 0;
            tick(dies_before_output);
            if (dies_before_output || rng_.below(40) == 0) {
                if (rng_.below(2) == 0) {
                    act();  // of which the journal does not hear
                }
                crash();
            }
        }
        come_back();
        tick(false);
        tick(false);
        for (auto& talker : talkers_) {
            talker->read(*host_);
            EXPECT_EQ(talker->texts, world_.told[talker->fake.client]);
            EXPECT_EQ(talker->sent, world_.done[talker->fake.client]);
            EXPECT_EQ(talker->kept, talker->sent);
        }
        EXPECT_GT(crashes_, 5);
    }

  private:
    void act() {
        if (talkers_.size() < 6 && rng_.below(10) == 0) {
            talkers_.push_back(std::make_unique<Talker>(*host_));
            ASSERT_TRUE(talkers_.back()->fake.log_in());
        }
        for (auto& talker : talkers_) {
            if (host_->closed.count(talker->fake.stream) != 0 || away_.count(talker.get()) != 0) {
                continue;
            }
            if (rng_.below(3) == 0) {
                const std::uint64_t number = ++talker->sent;
                host_->send(talker->fake.stream,
                            session::command_message(number, text_of(*talker, number), 16));
            }
            if (rng_.below(4) == 0) {
                acknowledge(*talker);
            }
            if (rng_.below(30) == 0) {
                talker->fake.drop();
                away_.insert(talker.get());
            }
        }
        if (rng_.below(10) == 0) {
            come_back();
        }
    }

    static std::string text_of(const Talker& talker, std::uint64_t number) {
        return std::to_string(talker.fake.client.value) + ":" + std::to_string(number);
    }

    void acknowledge(Talker& talker) {
        talker.read(*host_);
        proto::ClientMessage message;
        message.mutable_event_ack()->set_through(talker.heard);
        host_->send(talker.fake.stream, message);
    }

    /// The journal takes the inputs, then the world makes its output, then it is told.
    void tick(bool dies_before_output) {
        const std::vector<mailbox::InboxItem> in = std::move(host_->inbox);
        host_->inbox.clear();
        std::vector<mailbox::OutboxItem> out = world_.tick(in, ++now_);
        for (const mailbox::InboxItem& item : in) {
            if (const auto* command = std::get_if<mailbox::Command>(&item)) {
                out.emplace_back(mailbox::CommandsKept{command->client, command->number});
            }
        }
        ledger_.apply(in, out);
        if (dies_before_output) {
            return;
        }
        for (const mailbox::OutboxItem& item : out) {
            host_->host.on_outbox(item, host_->now_s, host_->now_s);
        }
        host_->advance(0.03);
        for (auto& talker : talkers_) {
            talker->read(*host_);
        }
    }

    void crash() {
        ++crashes_;
        const double now_s = host_->now_s;
        for (auto& talker : talkers_) {
            talker->read(*host_);
        }
        auto next = std::make_unique<TestHost>(settings_);
        next->now_s = now_s;
        next->last_stream = host_->last_stream;
        ledger_ = as_saved(ledger_);
        next->host.number_sessions_after(ledger_.newest_client());
        std::set<ClientId> known;
        for (session::KeptSession& kept : ledger_.sessions()) {
            known.insert(kept.begun.client);
            next->host.restore(std::move(kept), now_s);
        }
        host_ = std::move(next);
        away_.clear();
        std::vector<std::unique_ptr<Talker>> left;
        for (auto& talker : talkers_) {
            // A login of which the journal had not heard is no session: its client logs in anew.
            if (known.count(talker->fake.client) != 0) {
                auto moved = std::make_unique<Talker>(*host_);
                moved->fake.client = talker->fake.client;
                moved->fake.token = talker->fake.token;
                moved->sent = talker->sent;
                moved->kept = talker->kept;
                moved->heard = talker->heard;
                moved->texts = std::move(talker->texts);
                away_.insert(moved.get());
                left.push_back(std::move(moved));
            }
        }
        talkers_ = std::move(left);
        if (rng_.below(2) == 0) {
            come_back();
        }
    }

    void come_back() {
        for (auto& talker : talkers_) {
            if (away_.erase(talker.get()) == 0) {
                continue;
            }
            const std::string token = talker->fake.token;
            ASSERT_TRUE(talker->fake.resume(talker->heard)) << talker->fake.answer.DebugString();
            const proto::Welcome& welcome = talker->fake.answer.welcome();
            EXPECT_EQ(welcome.resume_token(), token);
            talker->kept = std::max(talker->kept, welcome.last_command());
            for (std::uint64_t n = welcome.last_command() + 1; n <= talker->sent; ++n) {
                host_->send(talker->fake.stream,
                            session::command_message(n, text_of(*talker, n), 16));
            }
        }
    }

    core::Rng rng_;
    session::HostSettings settings_ = journaled_settings();
    std::unique_ptr<TestHost> host_;
    std::vector<std::unique_ptr<Talker>> talkers_;
    std::set<Talker*> away_;
    TinyWorld world_;
    RunLedger ledger_;
    Tick now_ = 0;
    int crashes_ = 0;
};

TEST(RunLedger, LosesDoublesAndReordersNothingOverAnyCrashes) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        SCOPED_TRACE(seed);
        Crashes(seed).run(600);
    }
}

TEST(RunLedger, KeepsNothingOfWhatIsOver) {
    RunLedger ledger;
    std::vector<mailbox::InboxItem> in;
    mailbox::EventOut event;
    event.confirm = true;
    for (std::uint32_t client = 1; client <= 3; ++client) {
        in.emplace_back(
            mailbox::SessionBegun{ClientId(client), mailbox::Bytes(32), "", "", "", 1, false});
        event.recipients.push_back(ClientId(client));
    }
    std::vector<mailbox::OutboxItem> out;
    for (std::uint64_t number = 1; number <= 4; ++number) {
        event.event = EventId(number);
        out.emplace_back(event);
    }
    ledger.apply(in, out);
    in = {mailbox::Leave{ClientId(2), mailbox::LeaveReason::kQuit},
          mailbox::SessionProgress{ClientId(1), 0, 3},
          mailbox::Confirm{ClientId(1), EventId(2)}};
    ledger.apply(in, {});
    const std::vector<session::KeptSession> kept = as_saved(ledger).sessions();
    ASSERT_EQ(kept.size(), 2U) << "who left is gone";
    EXPECT_EQ(kept[0].events.acknowledged(), 3U);
    EXPECT_EQ(kept[0].events.waiting().size(), 1U);
    EXPECT_EQ(kept[0].unconfirmed, (std::set<std::uint64_t>{1, 3, 4}));
    EXPECT_EQ(kept[1].events.waiting().size(), 4U);
}

TEST(RunLedger, KnowsWhatTheStoreOwes) {
    RunLedger ledger;
    mailbox::StoreRequest request;
    request.act = mailbox::StoreAct::kPut;
    request.key.key = "a";
    request.value = {1, 2};
    request.position[1] = 2.5;
    ledger.ask_store(7, std::vector{request});
    request.key.key = "b";
    ledger.ask_store(8, std::vector{request, request});
    const mailbox::InboxItem kept = mailbox::StoreKept{7};
    ledger.apply({&kept, 1}, {});
    RunLedger again = as_saved(ledger);
    const auto owed = again.ask_again(20);
    ASSERT_EQ(owed.size(), 2U);
    EXPECT_EQ(owed[0].key.key, "b");
    EXPECT_EQ(owed[0].value, request.value);
    EXPECT_EQ(owed[0].position[1], 2.5);
    // From then on they are of that tick.
    const mailbox::InboxItem done = mailbox::StoreKept{20};
    again.apply({&done, 1}, {});
    EXPECT_TRUE(again.ask_again(21).empty());
}

TEST(RunLedger, KnowsWhomTheRulesThrewOut) {
    RunLedger ledger;
    std::vector<mailbox::InboxItem> in{
        mailbox::SessionBegun{ClientId(3), mailbox::Bytes(32), "", "", "", 1, false}};
    std::vector<mailbox::OutboxItem> out{mailbox::Kick{ClientId(3), "cheats"}};
    ledger.apply(in, out);
    EXPECT_TRUE(ledger.sessions().empty());
    EXPECT_EQ(ledger.kicked(), std::set<ClientId>{ClientId(3)});
    in = {mailbox::Leave{ClientId(3), mailbox::LeaveReason::kKicked}};
    ledger.apply(in, {});
    EXPECT_TRUE(ledger.kicked().empty());
    EXPECT_EQ(ledger.newest_client(), ClientId(3));
}

// ---------------------------------------------------------------- HeldOutput

mailbox::EventOut event_of(std::uint64_t number, bool durable) {
    mailbox::EventOut event;
    event.event = EventId(number);
    event.kind = 16;
    event.durable = durable;
    event.payload = {1};
    event.recipients = {ClientId(1)};
    return event;
}

struct Left {
    std::vector<std::uint64_t> events;
    std::vector<std::uint16_t> kinds;
    int states = 0;

    void operator()(const mailbox::OutboxItem& item) {
        if (const auto* event = std::get_if<mailbox::EventOut>(&item)) {
            events.push_back(event->event.value);
            kinds.push_back(event->kind);
        } else {
            ++states;
        }
    }
};

TEST(HeldOutput, WithoutAJournalOnlyDurableEventsWait) {
    HeldOutput held;
    Left left;
    const auto send = [&](const mailbox::OutboxItem& item) {
        left(item);
    };
    held.take(event_of(1, true), 5, {3, false}, send);
    held.take(event_of(2, false), 5, {3, false}, send);
    held.take(event_of(3, true), 5, {0, true}, send);
    EXPECT_EQ(left.events, (std::vector<std::uint64_t>{2}));
    EXPECT_EQ(held.refused(), 1U);
    held.stored(2, send);
    EXPECT_EQ(held.waiting(), 1U);
    held.stored(3, send);
    EXPECT_EQ(left.events, (std::vector<std::uint64_t>{2, 1}));
}

TEST(HeldOutput, WithAJournalEverythingToldOnceWaitsInOrder) {
    HeldOutput held;
    held.await_journal(4);
    Left left;
    const auto send = [&](const mailbox::OutboxItem& item) {
        left(item);
    };
    held.take(event_of(1, false), 4, {}, send);
    EXPECT_EQ(left.events.size(), 1U) << "its tick is in the journal";
    held.take(event_of(2, true), 5, {9, false}, send);
    held.take(event_of(3, false), 5, {9, false}, send);
    held.take(mailbox::StatePacket{}, 5, {9, false}, send);
    EXPECT_EQ(left.states, 1) << "states do not wait";
    held.journaled(6, send);
    EXPECT_EQ(left.events.size(), 1U) << "the durable one waits for the store, the other behind it";
    held.take(event_of(4, true), 6, {0, true}, send);
    held.stored(9, send);
    EXPECT_EQ(left.events, (std::vector<std::uint64_t>{1, 2, 3, 4}));
    EXPECT_EQ(left.kinds, (std::vector<std::uint16_t>{16, 16, 16, 11})) << "refused: withdrawn";
    EXPECT_EQ(held.waiting(), 0U);
}

}  // namespace
}  // namespace zoned::app

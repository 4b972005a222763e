// The writer's thread: what it promises, in which order, and what it does when the store fails.
#include "server/store/store_service.h"
#include "tests/unit/store/store_fixture.h"

#include <future>

namespace zoned::store::test {
namespace {

using mailbox::StoreAct;
using mailbox::StoreAnswer;
using mailbox::StoreRequest;
using mailbox::StoreStatus;

constexpr auto kPatience = std::chrono::seconds(20);

StoreRequest request(StoreAct act,
                     std::uint64_t number,
                     const StoreKey& key,
                     StoredBytes value = {}) {
    StoreRequest out;
    out.act = act;
    out.number = number;
    out.zone = ZoneId(1);
    out.target = EntityId(7);
    out.key = key;
    out.value = std::move(value);
    return out;
}

/// A store that fails as long as it is told to; the real one is behind it.
class MoodyStore final : public Store {
  public:
    explicit MoodyStore(std::unique_ptr<Store> behind) : behind_(std::move(behind)) {}

    StoreResult<bool> commit(std::span<const StoreChange> changes) override {
        ++commits;
        if (fails) {
            return StoreResult<bool>::failure({StoreFault::kFull, "the disk is full"});
        }
        return behind_->commit(changes);
    }

    StoreResult<std::optional<StoredBytes>> get(const StoreKey& key) override {
        return behind_->get(key);
    }

    StoreResult<std::vector<PutRecord>> records(const std::string& account) override {
        return behind_->records(account);
    }

    StoreResult<std::optional<StandingPlace>> stand(const std::string& account,
                                                    const std::string& character) override {
        return behind_->stand(account, character);
    }

    StoreResult<std::vector<PutBan>> bans() override { return behind_->bans(); }

    StoreResult<std::vector<UseTicket>> tickets(std::int64_t unix_s) override {
        return behind_->tickets(unix_s);
    }

    StoreResult<std::vector<StoredEvent>> events(const std::string& account,
                                                 std::size_t most) override {
        return behind_->events(account, most);
    }

    StoreResult<StoreCounts> counts() override { return behind_->counts(); }

    StoreResult<std::vector<std::string>> check() override { return behind_->check(); }

    StoreResult<bool> backup(const std::string& file) override { return behind_->backup(file); }

    std::atomic<bool> fails{false};
    std::atomic<int> commits{0};

  private:
    std::unique_ptr<Store> behind_;
};

class Service : public ::testing::Test {
  protected:
    void SetUp() override { begin({}); }

    void begin(StoreServiceSettings settings) {
        service = nullptr;
        settings.retry_s = 0.005;
        settings.stop_patience_s = std::min(settings.stop_patience_s, 0.1);
        settings.world = "w";
        auto moody = std::make_unique<MoodyStore>(open_file(folder.file("store.db")));
        store = moody.get();
        service = std::make_unique<StoreService>(
            std::move(moody),
            settings,
            StoreServiceOutput{[this](StoreAnswer answer) {
                                   const std::lock_guard lock(mutex);
                                   answers.push_back(std::move(answer));
                                   changed.notify_all();
                               },
                               [this](std::uint64_t number) {
                                   const std::lock_guard lock(mutex);
                                   durable = number;
                                   changed.notify_all();
                               },
                               [this](const std::string& text) {
                                   const std::lock_guard lock(mutex);
                                   troubles.push_back(text);
                                   changed.notify_all();
                               }});
    }

    template <class Done>
    bool wait_until(Done done) {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, kPatience, done);
    }

    std::vector<StoreRequest> put(const std::string& key, std::uint8_t value) const {
        return {request(StoreAct::kPut, ++number_, world_key(key), {value})};
    }

    ScratchFolder folder;
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<StoreAnswer> answers;
    std::vector<std::string> troubles;
    std::uint64_t durable = 0;
    MoodyStore* store = nullptr;
    std::unique_ptr<StoreService> service;
    mutable std::uint64_t number_ = 0;
};

TEST_F(Service, ATicksWritesComeBeforeItsReads) {
    std::vector<StoreRequest> tick;
    tick.push_back(request(StoreAct::kGet, 1, world_key("k")));
    tick.push_back(request(StoreAct::kPut, 2, world_key("k"), {5}));
    tick.push_back(request(StoreAct::kGet, 3, world_key("none")));
    const std::uint64_t number = service->submit(30, std::move(tick));
    ASSERT_NE(number, 0U);
    ASSERT_TRUE(wait_until([&] { return durable >= number; }));
    ASSERT_EQ(answers.size(), 3U);
    EXPECT_EQ(answers[0].number, 1U);
    EXPECT_EQ(answers[0].value, StoredBytes{5});
    EXPECT_EQ(answers[0].target, EntityId(7));
    EXPECT_EQ(answers[0].key, world_key("k"));
    EXPECT_EQ(answers[1].act, StoreAct::kPut);
    EXPECT_EQ(answers[1].status, StoreStatus::kDone);
    EXPECT_EQ(answers[2].status, StoreStatus::kAbsent);
}

TEST_F(Service, NothingIsSaidToBeDurableBeforeItIs) {
    store->fails = true;
    const std::uint64_t number = service->submit(1, put("k", 1));
    ASSERT_TRUE(wait_until([&] { return !troubles.empty(); }));
    while (store->commits < 3) {
        std::this_thread::yield();
    }
    {
        const std::lock_guard lock(mutex);
        EXPECT_EQ(durable, 0U);
        EXPECT_TRUE(answers.empty());
        EXPECT_EQ(troubles, std::vector<std::string>{"the disk is full"}) << "said once";
    }
    EXPECT_EQ(service->figures().failing, "the disk is full");
    EXPECT_GE(service->figures().failures, 2U);
    store->fails = false;
    ASSERT_TRUE(wait_until([&] { return durable >= number; }));
    EXPECT_EQ(answers.size(), 1U);
    EXPECT_EQ(service->figures().failing, "");
    EXPECT_EQ(troubles.back(), "") << "and that it works again";
    service = nullptr;
    EXPECT_EQ(taken(open_file(folder.file("store.db"))->get(world_key("k"))), StoredBytes{1});
}

TEST_F(Service, RefusesWhatItHasNoRoomForAndKeepsWhatItTook) {
    StoreServiceSettings small;
    small.max_waiting_bytes = 100000;
    begin(small);
    store->fails = true;
    int taken_jobs = 0;
    std::uint64_t last = 0;
    for (std::uint8_t i = 0; i < 100; ++i) {
        const std::uint64_t number = service->submit(
            i,
            {request(StoreAct::kPut, i + 1U, world_key(std::to_string(i)), StoredBytes(9000, i))});
        taken_jobs += number != 0 ? 1 : 0;
        last = std::max(last, number);
    }
    EXPECT_GT(taken_jobs, 5);
    ASSERT_LT(taken_jobs, 12);
    {
        const std::lock_guard lock(mutex);
        ASSERT_EQ(answers.size(), static_cast<std::size_t>(100 - taken_jobs));
        EXPECT_EQ(answers[0].status, StoreStatus::kRefused);
    }
    EXPECT_EQ(service->figures().refused, static_cast<std::uint64_t>(100 - taken_jobs));
    store->fails = false;
    ASSERT_TRUE(wait_until([&] { return durable >= last; }));
    EXPECT_EQ(taken(store->counts()).records, static_cast<std::uint64_t>(taken_jobs));
    EXPECT_EQ(service->figures().waiting_bytes, 0U);
}

TEST_F(Service, WritesAllThatWaitsBeforeItEnds) {
    for (std::uint8_t i = 0; i < 50; ++i) {
        service->submit(i, put(std::to_string(i), i));
    }
    service->stop();
    EXPECT_EQ(service->figures().lost, 0U);
    EXPECT_EQ(service->submit(99, put("late", 1)), 0U);
    service = nullptr;
    EXPECT_EQ(taken(open_file(folder.file("store.db"))->counts()).records, 50U);
}

TEST_F(Service, EndsAndSaysWhatIsLostWhereTheStoreNeverTakesIt) {
    store->fails = true;
    service->submit(1, put("a", 1));
    service->submit(2, put("b", 1));
    service->stop();
    EXPECT_EQ(service->figures().lost, 2U);
    EXPECT_EQ(durable, 0U);
}

TEST_F(Service, ALoginIsAnsweredWhenItIsStoredWithWhereTheCharacterStood) {
    const auto log_in = [&](std::uint8_t nonce) {
        std::promise<LoginResult> done;
        service->log_in({"ann", "hero", 50}, UseTicket{{nonce}, 1000}, [&done](LoginResult result) {
            done.set_value(std::move(result));
        });
        return done.get_future().get();
    };
    const LoginResult first = log_in(1);
    EXPECT_TRUE(first.stored);
    EXPECT_FALSE(first.place);
    StoreRequest stand = request(StoreAct::kStand, 0, {StoreScope::kCharacter, "ann", "hero", {}});
    stand.position[0] = 1.0;
    stand.position[2] = -3.5;
    const std::uint64_t number = service->submit(1, {stand});
    ASSERT_TRUE(wait_until([&] { return durable >= number; }));
    EXPECT_TRUE(answers.empty()) << "nobody asked for an answer";
    const LoginResult second = log_in(2);
    ASSERT_TRUE(second.place);
    EXPECT_EQ(second.place->position_m, (std::array<double, 3>{1.0, 0.0, -3.5}));
    EXPECT_EQ(taken(store->tickets(0)).size(), 2U);
    // Another world has other ground.
    taken(store->commit(
        std::vector<StoreChange>{PutStand{"ann", "hero", {{1, 2, 3}, "another world"}}}));
    EXPECT_FALSE(log_in(3).place);
}

TEST_F(Service, DurableEventsAreKept) {
    StoreRequest event = request(StoreAct::kEvent, 0, {StoreScope::kWorld, "ann", {}, "news"}, {9});
    event.kind = 17;
    const std::uint64_t number = service->submit(42, {event});
    ASSERT_TRUE(wait_until([&] { return durable >= number; }));
    const auto events = taken(store->events("ann", 5));
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].tick, 42);
    EXPECT_EQ(events[0].kind, 17);
    EXPECT_EQ(events[0].topic, "news");
    EXPECT_GT(events[0].unix_ms, 0);
}

}  // namespace
}  // namespace zoned::store::test

#include "server/mailbox/bounded_queue.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

namespace zoned::mailbox {
namespace {

TEST(BoundedQueue, HandsOutItemsInTheOrderOfTheirArrival) {
    BoundedQueue<int> queue(10);
    for (int i = 0; i < 5; ++i) {
        EXPECT_TRUE(queue.push(i));
    }
    std::vector<int> out = {42};
    queue.take_all(out);
    EXPECT_EQ(out, std::vector<int>({0, 1, 2, 3, 4}));
    queue.take_all(out);
    EXPECT_TRUE(out.empty());
}

TEST(BoundedQueue, DropsAndCountsWhatDoesNotFit) {
    BoundedQueue<int> queue(3);
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(queue.push(i), i < 3);
    }
    EXPECT_EQ(queue.dropped(), 2U);
    std::vector<int> out;
    queue.take_all(out);
    EXPECT_EQ(out, std::vector<int>({0, 1, 2}));
    EXPECT_TRUE(queue.push(5));
    EXPECT_EQ(queue.dropped(), 2U);
}

TEST(BoundedQueue, AQueueOfCapacityZeroTakesNothing) {
    BoundedQueue<int> queue(0);
    EXPECT_FALSE(queue.push(1));
    EXPECT_EQ(queue.dropped(), 1U);
}

TEST(BoundedQueue, CarriesItemsThatCanOnlyBeMoved) {
    BoundedQueue<std::unique_ptr<int>> queue(2);
    queue.push(std::make_unique<int>(7));
    std::vector<std::unique_ptr<int>> out;
    queue.take_all(out);
    ASSERT_EQ(out.size(), 1U);
    EXPECT_EQ(*out[0], 7);
}

TEST(BoundedQueue, LosesNothingButWhatItCountsBetweenThreads) {
    constexpr int kProducers = 3;
    constexpr std::uint64_t kItems = 20000;

    struct Item {
        int producer = 0;
        std::uint64_t number = 0;
    };

    BoundedQueue<Item> queue(64);
    std::vector<std::uint64_t> accepted(kProducers, 0);
    std::vector<std::thread> producers;
    for (int p = 0; p < kProducers; ++p) {
        producers.emplace_back([&queue, &accepted, p] {
            for (std::uint64_t i = 1; i <= kItems; ++i) {
                accepted[static_cast<std::size_t>(p)] += queue.push({p, i}) ? 1 : 0;
            }
        });
    }
    std::vector<std::uint64_t> newest(kProducers, 0);
    std::uint64_t received = 0;
    std::vector<Item> out;
    const auto drain = [&] {
        queue.take_all(out);
        EXPECT_LE(out.size(), 64U);
        for (const Item& item : out) {
            // Each producer's items arrive in its order, none of them twice.
            EXPECT_GT(item.number, newest[static_cast<std::size_t>(item.producer)]);
            newest[static_cast<std::size_t>(item.producer)] = item.number;
        }
        received += out.size();
    };
    while (received + queue.dropped() < kProducers * kItems) {
        drain();
    }
    for (std::thread& producer : producers) {
        producer.join();
    }
    drain();
    EXPECT_EQ(received + queue.dropped(), kProducers * kItems);
    EXPECT_EQ(accepted[0] + accepted[1] + accepted[2], received);
}

}  // namespace
}  // namespace zoned::mailbox

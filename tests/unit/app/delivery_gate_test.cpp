#include "server/app/runtime/delivery_gate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

namespace zoned::app {
namespace {

TEST(DeliveryGate, LetsSoManyWaitAndNoMore) {
    constexpr int kOutputs = 2000;
    constexpr int kMost = 4;
    DeliveryGate gate(kMost);
    std::atomic<int> waiting{0};
    std::atomic<int> most_seen{0};
    std::thread loop([&] {
        for (int i = 0; i < kOutputs; ++i) {
            gate.enter();
            most_seen = std::max(most_seen.load(), ++waiting);
        }
    });
    for (int delivered = 0; delivered < kOutputs;) {
        if (waiting.load() > 0) {
            --waiting;
            gate.leave();
            ++delivered;
        } else {
            std::this_thread::yield();
        }
    }
    loop.join();
    EXPECT_LE(most_seen, kMost);
    EXPECT_EQ(waiting, 0);
}

TEST(DeliveryGate, HoldsWhoeverWouldBeOneTooManyUntilItOpens) {
    DeliveryGate gate(2);
    gate.enter();
    gate.enter();
    EXPECT_EQ(gate.held(), 0U);
    std::atomic<int> in{0};
    std::thread loop([&] {
        for (int i = 0; i < 3; ++i) {
            gate.enter();
            ++in;
        }
    });
    while (gate.held() == 0) {
        std::this_thread::yield();
    }
    EXPECT_EQ(in, 0);
    gate.leave();
    while (in.load() < 1 || gate.held() < 2) {
        std::this_thread::yield();
    }
    EXPECT_EQ(in, 1);
    gate.open();
    loop.join();
    EXPECT_EQ(in, 3);
}

}  // namespace
}  // namespace zoned::app

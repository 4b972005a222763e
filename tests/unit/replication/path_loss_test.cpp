// PathLoss: what is known to be lost, and the copies that it calls for.
#include "server/replication/delivery/path_loss.h"

#include <gtest/gtest.h>

namespace zoned::replication {
namespace {

constexpr float kTarget = 1e-6F;

TEST(PathLoss, TakesANewPathForAPoorOneUntilPacketsHaveArrived) {
    PathLoss loss;
    EXPECT_GT(loss.copies_wanted(kTarget), 2);
    // A guess of 0.02 that counts as 4 packets is 0.00125 beside 60 that arrived, and loses a 64th
    // with each further one: 0.001 after 75 in all.
    for (int i = 0; i < 70; ++i) {
        loss.on_arrived();
    }
    EXPECT_GT(loss.copies_wanted(kTarget), 1);
    for (int i = 0; i < 10; ++i) {
        loss.on_arrived();
    }
    EXPECT_EQ(loss.copies_wanted(kTarget), 1);
}

TEST(PathLoss, ForgetsALossAfterManyPacketsThatArrived) {
    PathLoss loss(0.0);
    loss.on_lost();
    EXPECT_GT(loss.copies_wanted(kTarget), 2);
    int packets = 0;
    while (loss.copies_wanted(kTarget) > 1 && packets < 1000) {
        loss.on_arrived();
        ++packets;
    }
    EXPECT_GT(packets, 100);
    EXPECT_LT(packets, 250);
}

TEST(PathLoss, TakesALossBackWhenThePacketComesAfterAll) {
    PathLoss loss(0.0);
    for (int i = 0; i < 20; ++i) {
        loss.on_lost();
    }
    EXPECT_GT(loss.copies_wanted(kTarget), 1);
    for (int i = 0; i < 20; ++i) {
        loss.on_found();
    }
    EXPECT_LT(loss.share(), 0.001);
    EXPECT_EQ(loss.copies_wanted(kTarget), 1);
}

TEST(PathLoss, StaysLossyWhereAPacketInTwentyIsLost) {
    PathLoss loss;
    for (int i = 0; i < 20; ++i) {
        loss.on_lost();
        for (int k = 0; k < 19; ++k) {
            loss.on_arrived();
        }
        if (i > 1) {
            EXPECT_GT(loss.copies_wanted(kTarget), 3) << i;
        }
    }
}

}  // namespace
}  // namespace zoned::replication

#include "server/interest/topics.h"

#include <gtest/gtest.h>

namespace zoned::interest {
namespace {

using Clients = std::vector<ClientId>;

TEST(Topics, ListSubscribersOnceAscending) {
    Topics topics;
    for (const std::uint32_t c : {7U, 3U, 7U, 5U}) {
        topics.subscribe(ClientId(c), "team/red");
    }
    EXPECT_EQ(topics.subscribers("team/red"), (Clients{ClientId(3), ClientId(5), ClientId(7)}));
    EXPECT_TRUE(topics.subscribers("team/blue").empty());
}

TEST(Topics, ForgetAClientInOneTopicOrInAll) {
    Topics topics;
    topics.subscribe(ClientId(1), "world");
    topics.subscribe(ClientId(1), "zone/2");
    topics.subscribe(ClientId(2), "world");
    topics.unsubscribe(ClientId(1), "zone/2");
    topics.unsubscribe(ClientId(1), "zone/9");
    EXPECT_TRUE(topics.subscribers("zone/2").empty());
    EXPECT_EQ(topics.subscribers("world").size(), 2U);
    topics.remove(ClientId(1));
    EXPECT_EQ(topics.subscribers("world"), Clients{ClientId(2)});
}

}  // namespace
}  // namespace zoned::interest

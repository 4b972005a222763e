#include "server/cluster/cluster_url.h"

#include <gtest/gtest.h>

namespace zoned::cluster {

TEST(ClusterUrl, TakesListsWithCommasAndRepetitions) {
    const auto urls = parse_cluster_urls({"nats://a:4222,tls://u:p@b", "nats://token@[::1]:1"});
    ASSERT_TRUE(urls.ok()) << urls.error();
    EXPECT_EQ(*urls,
              (std::vector<std::string>{"nats://a:4222", "tls://u:p@b", "nats://token@[::1]:1"}));
    EXPECT_TRUE(parse_cluster_urls({})->empty());
}

TEST(ClusterUrl, SaysWhatIsWrongWithoutTheSecret) {
    for (const char* wrong : {"http://a",
                              "localhost:4222",
                              "nats://",
                              "nats://u:hush@",
                              "nats://u:hush@:1",
                              "nats://u:hush@a:0",
                              "nats://u:hush@a:65536",
                              "nats://u:hush@a:x1",
                              "nats://a,"}) {
        const auto urls = parse_cluster_urls({wrong});
        ASSERT_FALSE(urls.ok()) << wrong;
        EXPECT_EQ(urls.error().find("hush"), std::string::npos) << urls.error();
        EXPECT_NE(urls.error().find("--cluster wants"), std::string::npos);
    }
}

TEST(ClusterUrl, LogsNeverShowWhatStandsBeforeTheHost) {
    EXPECT_EQ(without_secrets("nats://u:p@host:1"), "nats://host:1");
    EXPECT_EQ(without_secrets("tls://to@ken@host"), "tls://host");
    EXPECT_EQ(without_secrets("nats://host"), "nats://host");
}

}  // namespace zoned::cluster
